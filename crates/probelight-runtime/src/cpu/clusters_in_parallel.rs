//! Parallel work over clusters that each write a stretch of one array.

use probelight_asset::Cluster;

/// Clusters a task works through by itself; a cluster takes some microseconds, a task far less.
const CLUSTERS_PER_TASK: usize = 4;

/// Runs `work` on every cluster with its own stretch of `output`. The stretches follow each other in the order
/// of the clusters; `start` says where a cluster's begins, counted as in the whole array.
pub(super) fn for_each_cluster<T: Send>(
    clusters: &[Cluster],
    output: &mut [T],
    start: &(impl Fn(&Cluster) -> usize + Sync),
    work: &(impl Fn(&Cluster, &mut [T]) + Sync),
) {
    if clusters.len() <= CLUSTERS_PER_TASK {
        let mut rest = output;
        for (i, cluster) in clusters.iter().enumerate() {
            let length = clusters.get(i + 1).map_or(rest.len(), |next| start(next) - start(cluster));
            let (stretch, behind) = rest.split_at_mut(length);
            work(cluster, stretch);
            rest = behind;
        }
        return;
    }
    let (low, high) = clusters.split_at(clusters.len() / 2);
    let (low_output, high_output) = output.split_at_mut(start(&high[0]) - start(&low[0]));
    rayon::join(
        || for_each_cluster(low, low_output, start, work),
        || for_each_cluster(high, high_output, start, work),
    );
}
