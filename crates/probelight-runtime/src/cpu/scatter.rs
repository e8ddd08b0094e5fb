//! Moves values from one array to chosen places of another.

use std::ops::Range;

use probelight_math::glam::Vec3;
use rayon::prelude::*;

/// Places that a task fills: few enough to stay in the first-level cache, in whatever order they are filled.
const PLACES_PER_TASK: usize = 2048;

/// Which place takes which value, by parts of the target that tasks own.
#[derive(Clone, Debug, Default)]
pub(super) struct Scatter {
    /// Task by task, cluster by cluster.
    moves: Vec<Move>,
    /// Those of each task.
    tasks: Vec<Vec<Run>>,
}

#[derive(Clone, Copy, Debug)]
struct Move {
    /// Place in the task's part of the target.
    place: u16,
    value: u32,
}

/// Moves of one cluster's values.
#[derive(Clone, Debug)]
struct Run {
    cluster: u32,
    moves: Range<usize>,
}

impl Scatter {
    /// From pairs (place, value) in any order, with the cluster that each value belongs to.
    pub(super) fn new(
        pairs: impl Iterator<Item = (u32, u32)>,
        cluster_of_value: impl Fn(u32) -> u32,
    ) -> Self {
        let task_of = |place: u32| place as usize / PLACES_PER_TASK;
        let mut sorted: Vec<(usize, u32, u32, u32)> =
            pairs.map(|(place, value)| (task_of(place), cluster_of_value(value), value, place)).collect();
        sorted.sort_unstable();
        let mut tasks = vec![Vec::new(); sorted.last().map_or(0, |last| last.0 + 1)];
        let mut first = 0;
        for run in sorted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (task, cluster, ..) = run[0];
            tasks[task].push(Run { cluster, moves: first..first + run.len() });
            first += run.len();
        }
        let in_task = |place: u32| (place as usize % PLACES_PER_TASK) as u16;
        let moves =
            sorted.into_iter().map(|(.., value, place)| Move { place: in_task(place), value }).collect();
        Self { moves, tasks }
    }

    /// Copies the values of the touched clusters to their places; other places stay as they are.
    pub(super) fn copy(&self, values: &[Vec3], target: &mut [Vec3], is_touched: impl Fn(u32) -> bool + Sync) {
        target.par_chunks_mut(PLACES_PER_TASK).zip(&self.tasks).for_each(|(target, runs)| {
            for run in runs.iter().filter(|run| is_touched(run.cluster)) {
                for each in &self.moves[run.moves.clone()] {
                    target[usize::from(each.place)] = values[each.value as usize];
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_values_of_touched_clusters_come_to_their_places() {
        // Values 0 to 9,999 go to places in reverse; a thousand to a cluster.
        let count = 10_000;
        let scatter = Scatter::new((0..count).map(|value| (count - 1 - value, value)), |value| value / 1000);
        let values: Vec<Vec3> = (0..count).map(|value| Vec3::splat(1.0 + value as f32)).collect();
        let mut target = vec![Vec3::ZERO; count as usize];
        scatter.copy(&values, &mut target, |cluster| cluster == 3 || cluster == 9);
        for (place, found) in target.iter().enumerate() {
            let value = count as usize - 1 - place;
            let expected = if [3, 9].contains(&(value / 1000)) { values[value] } else { Vec3::ZERO };
            assert_eq!(*found, expected, "place {place}");
        }
        scatter.copy(&values, &mut target, |_| true);
        assert!(target.iter().rev().eq(&values));
    }
}
