//! Moves values from one array to chosen places of another.

use probelight_math::glam::Vec3;
use rayon::prelude::*;

/// Places that a task fills.
const PLACES_PER_TASK: usize = 2048;

/// Which place takes which value; sorted by place, so that tasks own separate parts of the target.
#[derive(Clone, Debug, Default)]
pub(super) struct Scatter {
    moves: Vec<Move>,
    /// The clusters whose values each task moves.
    clusters: Vec<Vec<u32>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Move {
    place: u32,
    value: u32,
}

impl Scatter {
    /// From pairs (place, value) in any order, with the cluster that each value belongs to.
    pub(super) fn new(
        pairs: impl Iterator<Item = (u32, u32)>,
        cluster_of_value: impl Fn(u32) -> u32,
    ) -> Self {
        let mut moves: Vec<Move> = pairs.map(|(place, value)| Move { place, value }).collect();
        moves.sort_unstable();
        let tasks = moves.last().map_or(0, |last| last.place as usize / PLACES_PER_TASK + 1);
        let mut clusters = vec![Vec::new(); tasks];
        for each in &moves {
            let of_task = &mut clusters[each.place as usize / PLACES_PER_TASK];
            let cluster = cluster_of_value(each.value);
            if !of_task.contains(&cluster) {
                of_task.push(cluster);
            }
        }
        Self { moves, clusters }
    }

    /// Copies `values` to their places; other places stay as they are, and may do so where no cluster is touched.
    pub(super) fn copy(&self, values: &[Vec3], target: &mut [Vec3], is_touched: impl Fn(u32) -> bool + Sync) {
        let tasks = target.par_chunks_mut(PLACES_PER_TASK).zip(&self.clusters).enumerate();
        tasks.filter(|(_, (_, clusters))| clusters.iter().any(|cluster| is_touched(*cluster))).for_each(
            |(task, (target, _))| {
                let first = task * PLACES_PER_TASK;
                let before = |end: usize| self.moves.partition_point(|each| (each.place as usize) < end);
                for each in &self.moves[before(first)..before(first + target.len())] {
                    target[each.place as usize - first] = values[each.value as usize];
                }
            },
        );
    }
}
