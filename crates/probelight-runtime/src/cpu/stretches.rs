//! Parallel work on an array that is divided into stretches, such as those of clusters.

use std::ops::Range;

/// Clusters that a task works through by itself: one takes some microseconds, a task far less.
pub(super) const CLUSTERS_PER_TASK: usize = 4;

/// An array, or several that are divided alike.
pub(super) trait Stretches: Send + Sized {
    /// What lies before a place, and the rest.
    fn split_at(self, place: usize) -> (Self, Self);
}

impl<T: Send> Stretches for &mut [T] {
    fn split_at(self, place: usize) -> (Self, Self) {
        self.split_at_mut(place)
    }
}

/// Runs `work` on every stretch (by number) of `array`, of which a task takes up to `per_task`. They follow each other;
/// `start` says where one begins, counted as in the whole array, and, for the one behind the last, where the last one ends.
pub(super) fn for_each_stretch<A: Stretches>(
    stretches: Range<usize>,
    per_task: usize,
    array: A,
    start: &(impl Fn(usize) -> usize + Sync),
    work: &(impl Fn(usize, A) + Sync),
) {
    if stretches.len() <= per_task {
        let mut rest = array;
        for number in stretches {
            let (stretch, behind) = rest.split_at(start(number + 1) - start(number));
            work(number, stretch);
            rest = behind;
        }
        return;
    }
    let middle = stretches.start + stretches.len() / 2;
    let (low, high) = array.split_at(start(middle) - start(stretches.start));
    rayon::join(
        || for_each_stretch(stretches.start..middle, per_task, low, start, work),
        || for_each_stretch(middle..stretches.end, per_task, high, start, work),
    );
}
