//! Finding the points near a place.

use probelight_math::glam::Vec3;
use probelight_trace::Tracer;
use rstar::primitives::GeomWithData;
use rstar::{RStarInsertionStrategy, RTree, RTreeParams};

/// Points in order of insertion, in an R-tree: a query takes the time of a few points, however far apart
/// they all lie.
#[derive(Default)]
pub(crate) struct PointTree {
    /// Positions in order of insertion.
    pub(crate) positions: Vec<Vec3>,
    tree: RTree<NumberedPoint, WideNodes>,
}

/// Nodes wider than usual: queries ask for a handful of points, and most of their time goes into the order of nodes.
struct WideNodes;

impl RTreeParams for WideNodes {
    const MIN_SIZE: usize = 8;
    const MAX_SIZE: usize = 16;
    const REINSERTION_COUNT: usize = 4;
    type DefaultInsertionStrategy = RStarInsertionStrategy;
}

/// A position and its number.
type NumberedPoint = GeomWithData<[f32; 3], u32>;

impl PointTree {
    /// A set of given positions.
    pub(crate) fn of(positions: &[Vec3]) -> Self {
        let numbered =
            (0..).zip(positions).map(|(number, position)| NumberedPoint::new((*position).into(), number));
        Self { positions: positions.to_vec(), tree: RTree::bulk_load_with_params(numbered.collect()) }
    }

    /// Adds a point.
    pub(crate) fn insert(&mut self, position: Vec3) {
        self.tree.insert(NumberedPoint::new(position.into(), self.positions.len() as u32));
        self.positions.push(position);
    }

    /// Whether a point within `radius` of `centre` satisfies `test`.
    pub(crate) fn any_within(&self, centre: Vec3, radius: f32, test: impl Fn(Vec3) -> bool) -> bool {
        self.tree
            .locate_within_distance(centre.into(), radius * radius)
            .any(|point| test(Vec3::from(*point.geom())))
    }

    /// Numbers of the points, nearest first; of those equally near, the smallest first.
    pub(crate) fn by_distance(&self, centre: Vec3) -> impl Iterator<Item = u32> {
        let mut sorted = self.tree.nearest_neighbor_iter_with_distance_2(&centre.into()).peekable();
        let mut equally_near = Vec::new();
        std::iter::from_fn(move || {
            if equally_near.is_empty() {
                let (point, distance) = sorted.next()?;
                equally_near.push(point.data);
                while let Some((other, _)) = sorted.next_if(|(_, other)| *other == distance) {
                    equally_near.push(other.data);
                }
                equally_near.sort_unstable_by(|a, b| b.cmp(a));
            }
            equally_near.pop()
        })
    }

    /// Numbers of the wanted points that are visible from a place, nearest first, among the `tried` nearest of all. Each
    /// is looked for when it is asked for.
    pub(crate) fn nearest_visible(
        &self,
        tracer: &Tracer,
        from: Vec3,
        tried: usize,
        is_wanted: impl Fn(Vec3) -> bool,
    ) -> impl Iterator<Item = u32> {
        self.by_distance(from).take(tried).filter(move |point| {
            let position = self.positions[*point as usize];
            is_wanted(position) && tracer.is_visible(from, position)
        })
    }

    /// Numbers of the `count` points nearest to a point, nearest first.
    pub(crate) fn nearest(&self, centre: Vec3, count: usize) -> Vec<u32> {
        self.by_distance(centre).take(count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::sampling::Rng;

    /// All points of a set, nearest first, by a full search.
    fn sorted(positions: &[Vec3], centre: Vec3) -> Vec<u32> {
        let mut all: Vec<u32> = (0..positions.len() as u32).collect();
        let distance = |i: &u32| positions[*i as usize].distance_squared(centre);
        all.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        all
    }

    #[test]
    fn nearest_agrees_with_a_full_search() {
        let mut rng = Rng::new(3, 4);
        let mut point = || 10.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let positions: Vec<Vec3> = (0..300).map(|_| point()).collect();
        let at_once = PointTree::of(&positions);
        let mut one_by_one = PointTree::default();
        positions.iter().for_each(|position| one_by_one.insert(*position));
        for _ in 0..50 {
            let centre = point() * 1.5;
            let expected = sorted(&positions, centre);
            for set in [&at_once, &one_by_one] {
                assert_eq!(set.nearest(centre, 17), expected[..17]);
                assert_eq!(set.nearest(centre, 1000), expected);
            }
        }
    }

    #[test]
    fn points_on_a_lattice_and_in_one_place_are_told_apart_by_number() {
        let lattice = |i: u32| Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32);
        let positions: Vec<Vec3> = (0..512).map(lattice).chain([Vec3::splat(3.5); 100]).collect();
        let set = PointTree::of(&positions);
        assert_eq!(set.nearest(Vec3::splat(3.5), 108), sorted(&positions, Vec3::splat(3.5))[..108]);
    }

    #[test]
    fn what_lies_within_a_radius_is_found_at_any_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let set = PointTree::of(&[Vec3::X * scale, Vec3::Y * 1e3 * scale]);
            let any = |radius: f32| set.any_within(Vec3::ZERO, radius * scale, |_| true);
            assert!(any(1.1) && !any(0.9));
            assert!(!set.any_within(Vec3::ZERO, 2e3 * scale, |p| p == Vec3::ZERO));
        }
    }
}
