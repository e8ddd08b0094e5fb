//! Moves values from one array to chosen places of another.

use probelight_math::glam::Vec3;
use rayon::prelude::*;

/// Places that a task fills.
const PLACES_PER_TASK: usize = 8192;

/// Which place takes which value; sorted by place, so that tasks own separate parts of the target.
#[derive(Clone, Debug, Default)]
pub(super) struct Scatter {
    moves: Vec<Move>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Move {
    place: u32,
    value: u32,
}

impl Scatter {
    /// From pairs (place, value) in any order.
    pub(super) fn new(pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut moves: Vec<Move> = pairs.map(|(place, value)| Move { place, value }).collect();
        moves.sort_unstable();
        Self { moves }
    }

    /// Copies `values` to their places; other places stay as they are.
    pub(super) fn copy(&self, values: &[Vec3], target: &mut [Vec3]) {
        target.par_chunks_mut(PLACES_PER_TASK).enumerate().for_each(|(task, target)| {
            let first = task * PLACES_PER_TASK;
            let before = |end: usize| self.moves.partition_point(|each| (each.place as usize) < end);
            for each in &self.moves[before(first)..before(first + target.len())] {
                target[each.place as usize - first] = values[each.value as usize];
            }
        });
    }
}
