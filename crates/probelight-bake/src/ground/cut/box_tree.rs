//! A tree of axis-aligned boxes, for finding those that overlap another.

use probelight_scene::Bounds;

/// Boxes in a leaf.
const LEAF_SIZE: usize = 8;

/// Boxes sorted by repeated halving along the longest axis of their centres.
pub(super) struct BoxTree<'a> {
    boxes: &'a [Bounds],
    order: Vec<u32>,
    /// In the order in which [`Self::visit`] meets them: parent, first half, second half.
    nodes: Vec<Node>,
}

struct Node {
    bounds: Bounds,
    /// Node after this one's descendants.
    next: u32,
}

impl<'a> BoxTree<'a> {
    pub(super) fn new(boxes: &'a [Bounds]) -> Self {
        let mut tree = Self { boxes, order: (0..boxes.len() as u32).collect(), nodes: Vec::new() };
        tree.build(0, boxes.len());
        tree
    }

    fn build(&mut self, first: usize, end: usize) {
        let node = self.nodes.len();
        let of_order = |i: &u32| self.boxes[*i as usize];
        let range = &self.order[first..end];
        let bounds = Bounds::of(range.iter().map(of_order).flat_map(|b| [b.min, b.max]));
        let centres = Bounds::of(range.iter().map(of_order).map(|b| b.min + b.max));
        self.nodes.push(Node { bounds, next: 0 });
        if end - first > LEAF_SIZE {
            let axis = centres.size().max_position();
            let middle = (end - first) / 2;
            let centre = |i: u32| (self.boxes[i as usize].min + self.boxes[i as usize].max)[axis];
            self.order[first..end]
                .select_nth_unstable_by(middle, |a, b| centre(*a).total_cmp(&centre(*b)).then(a.cmp(b)));
            self.build(first, first + middle);
            self.build(first + middle, end);
        }
        self.nodes[node].next = self.nodes.len() as u32;
    }

    /// Indices of the boxes that overlap `query`, ascending.
    pub(super) fn overlapping(&self, query: &Bounds) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit(0, 0, self.order.len(), query, &mut found);
        found.sort_unstable();
        found
    }

    fn visit(&self, node: usize, first: usize, end: usize, query: &Bounds, found: &mut Vec<u32>) {
        if !overlap(&self.nodes[node].bounds, query) {
            return;
        }
        if end - first <= LEAF_SIZE {
            let leaf = self.order[first..end].iter();
            found.extend(leaf.filter(|i| overlap(&self.boxes[**i as usize], query)));
            return;
        }
        let middle = first + (end - first) / 2;
        self.visit(node + 1, first, middle, query, found);
        self.visit(self.nodes[node + 1].next as usize, middle, end, query, found);
    }
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}
