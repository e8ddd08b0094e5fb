//! Finding the points near a place.

use std::collections::HashMap;

use probelight_math::glam::{IVec3, Vec3};

/// Points in order of insertion, with a hash grid for neighbour queries.
pub(crate) struct PointGrid {
    cell: f32,
    /// Positions in order of insertion.
    pub(crate) positions: Vec<Vec3>,
    cells: HashMap<IVec3, Vec<u32>>,
    low: IVec3,
    high: IVec3,
}

impl PointGrid {
    /// An empty set for queries of about `cell` metres.
    pub(crate) fn new(cell: f32) -> Self {
        Self { cell, positions: Vec::new(), cells: HashMap::new(), low: IVec3::MAX, high: IVec3::MIN }
    }

    /// A set of given positions.
    pub(crate) fn of(positions: &[Vec3], cell: f32) -> Self {
        let mut set = Self::new(cell);
        for position in positions {
            set.insert(*position);
        }
        set
    }

    fn cell_of(&self, position: Vec3) -> IVec3 {
        (position / self.cell).floor().as_ivec3()
    }

    /// Adds a point.
    pub(crate) fn insert(&mut self, position: Vec3) {
        let cell = self.cell_of(position);
        self.low = self.low.min(cell);
        self.high = self.high.max(cell);
        self.cells.entry(cell).or_default().push(self.positions.len() as u32);
        self.positions.push(position);
    }

    /// Whether a point within `radius` of `centre` satisfies `test`.
    pub(crate) fn any_within(&self, centre: Vec3, radius: f32, test: impl Fn(Vec3) -> bool) -> bool {
        let reach = (radius / self.cell).ceil() as i32;
        let middle = self.cell_of(centre);
        cube(middle - reach, middle + reach).filter_map(|cell| self.cells.get(&cell)).flatten().any(|p| {
            let position = self.positions[*p as usize];
            position.distance_squared(centre) < radius * radius && test(position)
        })
    }

    /// Numbers of the `count` points nearest to a point, nearest first.
    pub(crate) fn nearest(&self, centre: Vec3, count: usize) -> Vec<u32> {
        let middle = self.cell_of(centre);
        let farthest = (middle - self.low).max(self.high - middle).max_element().max(0);
        let mut found: Vec<(f32, u32)> = Vec::new();
        for shell in 0..=farthest {
            // Everything in this shell is at least this far away.
            let shell_distance = (shell - 1).max(0) as f32 * self.cell;
            if found.len() >= count {
                found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                if found[count - 1].0 <= shell_distance * shell_distance {
                    break;
                }
            }
            for cell in shell_cells(middle, shell) {
                for p in self.cells.get(&cell).into_iter().flatten() {
                    found.push((self.positions[*p as usize].distance_squared(centre), *p));
                }
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(count);
        found.into_iter().map(|(_, p)| p).collect()
    }
}

/// All cells of a box, corners included.
fn cube(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    (low.z..=high.z).flat_map(move |z| {
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// The cells at Chebyshev distance `shell` from `middle`.
fn shell_cells(middle: IVec3, shell: i32) -> impl Iterator<Item = IVec3> {
    cube(middle - shell, middle + shell).filter(move |cell| (*cell - middle).abs().max_element() == shell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::sampling::Rng;

    #[test]
    fn nearest_agrees_with_a_full_search() {
        let mut rng = Rng::new(3, 4);
        let mut point = || 10.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let positions: Vec<Vec3> = (0..300).map(|_| point()).collect();
        let set = PointGrid::of(&positions, 0.7);
        for _ in 0..50 {
            let centre = point() * 1.5;
            let mut all: Vec<u32> = (0..300).collect();
            all.sort_by(|a, b| {
                let d = |i: &u32| positions[*i as usize].distance_squared(centre);
                d(a).total_cmp(&d(b))
            });
            assert_eq!(set.nearest(centre, 17), all[..17]);
        }
        assert_eq!(set.nearest(Vec3::ZERO, 1000).len(), 300);
    }
}
