//! Parallel work on an array that is divided into stretches, such as those of clusters.

use std::ops::Range;

/// Clusters that a task works through by itself: one takes some microseconds, a task far less.
pub(super) const CLUSTERS_PER_TASK: usize = 4;

/// Runs `work` on every stretch (by number) of `array`, of which a task takes up to `per_task`. They follow each other;
/// `start` says where one begins, counted as in the whole array, and, for the one behind the last, where the last one ends.
pub(super) fn for_each_stretch<T: Send>(
    stretches: Range<usize>,
    per_task: usize,
    array: &mut [T],
    start: &(impl Fn(usize) -> usize + Sync),
    work: &(impl Fn(usize, &mut [T]) + Sync),
) {
    if stretches.len() <= per_task {
        let mut rest = array;
        for number in stretches {
            let (stretch, behind) = rest.split_at_mut(start(number + 1) - start(number));
            work(number, stretch);
            rest = behind;
        }
        return;
    }
    let middle = stretches.start + stretches.len() / 2;
    let (low, high) = array.split_at_mut(start(middle) - start(stretches.start));
    rayon::join(
        || for_each_stretch(stretches.start..middle, per_task, low, start, work),
        || for_each_stretch(middle..stretches.end, per_task, high, start, work),
    );
}
