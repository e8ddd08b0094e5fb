//! Parallel work over clusters that each write a stretch of one array.

use probelight_asset::Cluster;

use crate::ClusterExtent;

/// Clusters a task works through by itself; a cluster takes some microseconds, a task far less.
const CLUSTERS_PER_TASK: usize = 4;

/// Runs `work` on every cluster with its extent and its own stretch of `output`. The stretches follow each other in the
/// order of the clusters; `start` says where a cluster's begins, counted as in the whole array.
pub(super) fn for_each_cluster<T: Send>(
    clusters: &[Cluster],
    extents: &[ClusterExtent],
    output: &mut [T],
    start: &(impl Fn(&Cluster) -> usize + Sync),
    work: &(impl Fn(&Cluster, ClusterExtent, &mut [T]) + Sync),
) {
    if clusters.len() <= CLUSTERS_PER_TASK {
        let mut rest = output;
        for (i, (cluster, extent)) in clusters.iter().zip(extents).enumerate() {
            let length = clusters.get(i + 1).map_or(rest.len(), |next| start(next) - start(cluster));
            let (stretch, behind) = rest.split_at_mut(length);
            work(cluster, *extent, stretch);
            rest = behind;
        }
        return;
    }
    let middle = clusters.len() / 2;
    let (low, high) = clusters.split_at(middle);
    let (low_extents, high_extents) = extents.split_at(middle);
    let (low_output, high_output) = output.split_at_mut(start(&high[0]) - start(&low[0]));
    rayon::join(
        || for_each_cluster(low, low_extents, low_output, start, work),
        || for_each_cluster(high, high_extents, high_output, start, work),
    );
}
