//! Which of many boxes others touch, without comparing each with each.

use probelight_math::glam::Vec3;
use probelight_scene::Bounds;

/// Boxes of a leaf.
const LEAF: usize = 4;

/// A balanced tree over boxes that do not move.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    /// A node's children are behind it: the first at once, the second where it says.
    nodes: Vec<Node>,
    /// The boxes' numbers, leaf by leaf, with the boxes.
    boxes: Vec<(u32, Bounds)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Around all boxes below.
    bounds: Bounds,
    /// First of its boxes.
    first: u32,
    /// Behind the last.
    end: u32,
    /// Second child; 0 for leaves.
    second: u32,
}

impl BoxTree {
    /// Of boxes by their number.
    pub(super) fn new(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut tree = Self { nodes: Vec::new(), boxes: (0..).zip(boxes).collect() };
        if !tree.boxes.is_empty() {
            tree.divide(0, tree.boxes.len());
        }
        tree
    }

    /// Divides a range of boxes at the middle of its longest side.
    fn divide(&mut self, first: usize, end: usize) {
        let boxes = &mut self.boxes[first..end];
        let bounds = Bounds::of(boxes.iter().flat_map(|(_, bounds)| [bounds.min, bounds.max]));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, first: first as u32, end: end as u32, second: 0 });
        if boxes.len() <= LEAF {
            return;
        }
        let middle = |bounds: &Bounds| bounds.min.midpoint(bounds.max);
        let centers = Bounds::of(boxes.iter().map(|(_, bounds)| middle(bounds)));
        let axis = centers.size().max_position();
        boxes.sort_unstable_by(|(i, a), (j, b)| middle(a)[axis].total_cmp(&middle(b)[axis]).then(i.cmp(j)));
        let half = first.midpoint(end);
        self.divide(first, half);
        self.nodes[node].second = self.nodes.len() as u32;
        self.divide(half, end);
    }

    /// Calls `visit` with the number of each box that touches `bounds`.
    pub(super) fn visit_touched(&self, bounds: &Bounds, visit: &mut impl FnMut(usize)) {
        if !self.nodes.is_empty() {
            self.visit_below(0, bounds, visit);
        }
    }

    fn visit_below(&self, node: usize, bounds: &Bounds, visit: &mut impl FnMut(usize)) {
        let Node { bounds: around, first, end, second } = self.nodes[node];
        if !touch(&around, bounds) {
            return;
        }
        if second == 0 {
            let boxes = &self.boxes[first as usize..end as usize];
            boxes
                .iter()
                .filter(|(_, each)| touch(each, bounds))
                .for_each(|(number, _)| visit(*number as usize));
            return;
        }
        self.visit_below(node + 1, bounds, visit);
        self.visit_below(second as usize, bounds, visit);
    }
}

fn touch(a: &Bounds, b: &Bounds) -> bool {
    let overlap = |a: Vec3, b: Vec3| a.cmple(b).all();
    overlap(a.min, b.max) && overlap(b.min, a.max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(most: usize) -> impl Strategy<Value = Vec<Bounds>> {
        let corner = || (-9.0f32..9.0, -9.0f32..9.0, -9.0f32..9.0).prop_map(Vec3::from);
        let size = (0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0).prop_map(Vec3::from);
        prop::collection::vec(
            (corner(), size).prop_map(|(min, size)| Bounds { min, max: min + size }),
            0..most,
        )
    }

    proptest! {
        #[test]
        fn finds_what_comparing_each_with_each_does(still in boxes(60), moving in boxes(6)) {
            let tree = BoxTree::new(still.iter().copied());
            for bounds in &moving {
                let mut found = Vec::new();
                tree.visit_touched(bounds, &mut |number| found.push(number));
                found.sort_unstable();
                let expected: Vec<usize> = (0..still.len()).filter(|i| touch(&still[*i], bounds)).collect();
                prop_assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn few_boxes_are_compared() {
        let at = |i: usize| Vec3::new((i % 40) as f32, (i / 40) as f32, 0.0);
        let tree = BoxTree::new((0..1600).map(|i| Bounds { min: at(i), max: at(i) + 0.5 }));
        assert!(tree.nodes.len() < 1600);
        let mut found = Vec::new();
        tree.visit_touched(&Bounds { min: at(85) + 0.1, max: at(86) + 0.1 }, &mut |number| {
            found.push(number);
        });
        found.sort_unstable();
        assert_eq!(found, [85, 86]);
    }
}
