//! Parallel work over clusters that each write a stretch of one array.

use std::ops::Range;

/// Clusters a task works through by itself; a cluster takes some microseconds, a task far less.
const CLUSTERS_PER_TASK: usize = 4;

/// Runs `work` on every cluster (by number) with its own stretch of `output`. The stretches follow each other in the order of
/// the clusters; `start` says where a cluster's begins, counted as in the whole array, and, for the cluster behind the last,
/// where the last one's ends.
pub(super) fn for_each_cluster<T: Send>(
    clusters: Range<usize>,
    output: &mut [T],
    start: &(impl Fn(usize) -> usize + Sync),
    work: &(impl Fn(usize, &mut [T]) + Sync),
) {
    if clusters.len() <= CLUSTERS_PER_TASK {
        let mut rest = output;
        for cluster in clusters {
            let (stretch, behind) = rest.split_at_mut(start(cluster + 1) - start(cluster));
            work(cluster, stretch);
            rest = behind;
        }
        return;
    }
    let middle = clusters.start + clusters.len() / 2;
    let (low_output, high_output) = output.split_at_mut(start(middle) - start(clusters.start));
    rayon::join(
        || for_each_cluster(clusters.start..middle, low_output, start, work),
        || for_each_cluster(middle..clusters.end, high_output, start, work),
    );
}
