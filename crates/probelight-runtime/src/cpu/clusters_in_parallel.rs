//! Parallel work over clusters that each write their own stretch of one or several arrays.

use probelight_asset::Cluster;

/// Clusters a task works through by itself; a cluster takes some microseconds, a task far less.
const CLUSTERS_PER_TASK: usize = 4;

/// Runs `work` on every cluster with its own stretch of each of the `outputs`. The stretches follow each other in
/// the order of the clusters; `starts` says where a cluster's begin, counted as in the whole arrays.
pub(super) fn for_each_cluster<T: Send, const N: usize>(
    clusters: &[Cluster],
    outputs: [&mut [T]; N],
    starts: &(impl Fn(&Cluster) -> [usize; N] + Sync),
    work: &(impl Fn(&Cluster, [&mut [T]; N]) + Sync),
) {
    if clusters.len() <= CLUSTERS_PER_TASK {
        let mut rest = outputs;
        for (i, cluster) in clusters.iter().enumerate() {
            let (stretches, behind) = match clusters.get(i + 1) {
                Some(next) => split(rest, starts(cluster), starts(next)),
                None => (rest, std::array::from_fn(|_| <&mut [T]>::default())),
            };
            work(cluster, stretches);
            rest = behind;
        }
        return;
    }
    let (low, high) = clusters.split_at(clusters.len() / 2);
    let (low_outputs, high_outputs) = split(outputs, starts(&low[0]), starts(&high[0]));
    rayon::join(
        || for_each_cluster(low, low_outputs, starts, work),
        || for_each_cluster(high, high_outputs, starts, work),
    );
}

/// Splits arrays that begin at `starts` before `middles`.
fn split<T, const N: usize>(
    arrays: [&mut [T]; N],
    starts: [usize; N],
    middles: [usize; N],
) -> ([&mut [T]; N], [&mut [T]; N]) {
    let mut behind = std::array::from_fn(|_| <&mut [T]>::default());
    let mut number = 0;
    let before = arrays.map(|array| {
        let (before, rest) = array.split_at_mut(middles[number] - starts[number]);
        behind[number] = rest;
        number += 1;
        before
    });
    (before, behind)
}
