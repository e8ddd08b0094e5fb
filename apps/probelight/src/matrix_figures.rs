//! What the matrices of a baked scene take, and how well they keep the light: figures over its clusters.

use std::fmt::{Display, Formatter, Write};

use probelight_asset::packed::Ranks;
use probelight_asset::{BakedScene, Cluster};
use serde::Serialize;

/// Figures over all clusters.
#[derive(Debug, PartialEq, Serialize)]
pub(crate) struct MatrixFigures {
    /// Mean number of scalar signals of a cluster: surfels, groups of them, emitters, the sky.
    mean_signal_columns: f64,
    /// Mean number of a cluster's columns for coefficients of probes.
    mean_probe_columns: f64,
    /// Mean number of singular values of a cluster, by their precision in U.
    mean_receiver_rank: MeanRank,
    /// By their precision in ΣVᵀ.
    mean_signal_rank: MeanRank,
    bytes_per_receiver: BytesPerReceiver,
    /// Shares of the receivers by their cluster's relative error.
    error_histogram: Vec<Bin>,
    /// Shares of the receivers by their cluster's rank.
    rank_histogram: Vec<Bin>,
}

/// Mean number of singular values of a cluster, by what a value takes.
#[derive(Debug, PartialEq, Serialize)]
struct MeanRank {
    half_float: f64,
    eight_bit: f64,
    four_bit: f64,
}

impl MeanRank {
    fn of(clusters: &[Cluster], ranks: impl Fn(&Cluster) -> Ranks) -> Self {
        let mean = |of_precision: fn(Ranks) -> u32| {
            let sum: f64 = clusters.iter().map(|c| f64::from(of_precision(ranks(c)))).sum();
            sum / clusters.len().max(1) as f64
        };
        Self {
            half_float: mean(|ranks| ranks.f16),
            eight_bit: mean(|ranks| ranks.snorm8),
            four_bit: mean(|ranks| ranks.snorm4),
        }
    }
}

/// What there is, such as "9.5 eight-bit + 8.1 four-bit".
impl Display for MeanRank {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let parts =
            [(self.half_float, "half-float"), (self.eight_bit, "eight-bit"), (self.four_bit, "four-bit")];
        let present: Vec<String> = parts
            .iter()
            .filter(|(count, _)| *count > 0.0)
            .map(|(count, name)| format!("{count:.1} {name}"))
            .collect();
        f.write_str(&if present.is_empty() { "none".into() } else { present.join(" + ") })
    }
}

/// What a frame reads to gather light.
#[derive(Debug, PartialEq, Serialize)]
struct BytesPerReceiver {
    /// U.
    receiver_basis: f64,
    /// ΣVᵀ with its scales.
    signal_basis: f64,
    /// Which signals and probes the columns stand for.
    signals: f64,
    /// Clusters, the texels of the receivers, and which of them lie beside borders.
    metadata: f64,
    total: f64,
}

/// A bar of a histogram.
#[derive(Debug, PartialEq, Serialize)]
struct Bin {
    above: f64,
    /// Included; absent where there is no end.
    up_to: Option<f64>,
    /// Share of the receivers, 0 to 1.
    share: f64,
}

/// Edges of the error's bins, as multiples of the wanted error.
const ERROR_EDGES: [f64; 6] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0];

/// Edges of the rank's bins.
const RANK_EDGES: [f64; 7] = [0.0, 4.0, 8.0, 16.0, 24.0, 32.0, 64.0];

impl MatrixFigures {
    pub(crate) fn of(baked: &BakedScene) -> Self {
        let clusters = &baked.clusters[..baked.lightmap_clusters()];
        let mean = |value: &dyn Fn(&Cluster) -> f64| {
            clusters.iter().map(value).sum::<f64>() / clusters.len().max(1) as f64
        };
        let wanted = f64::from(baked.settings.max_cluster_error);
        let error_edges = ERROR_EDGES.map(|edge| edge * wanted);
        Self {
            mean_signal_columns: mean(&|c| f64::from(c.signal_count)),
            mean_probe_columns: mean(&|c| f64::from(c.probe_count)) * baked.coefficients() as f64,
            mean_receiver_rank: MeanRank::of(clusters, |c| c.receiver_ranks),
            mean_signal_rank: MeanRank::of(clusters, |c| c.signal_ranks),
            bytes_per_receiver: BytesPerReceiver::of(baked),
            error_histogram: histogram(clusters, &error_edges, |c| f64::from(c.error)),
            rank_histogram: histogram(clusters, &RANK_EDGES, |c| f64::from(c.rank())),
        }
    }

    /// The figures as text, a name and a value a line.
    pub(crate) fn lines(&self) -> Vec<(&'static str, String)> {
        let bytes = &self.bytes_per_receiver;
        let mut lines = vec![
            (
                "columns of a cluster",
                format!(
                    "{:.1} signals, {:.1} coefficients of probes",
                    self.mean_signal_columns, self.mean_probe_columns
                ),
            ),
            ("rank of a cluster", format!("U: {}; ΣVᵀ: {}", self.mean_receiver_rank, self.mean_signal_rank)),
            (
                "bytes per receiver",
                format!(
                    "{:.1}: U {:.1}, ΣVᵀ {:.1}, signals {:.1}, metadata {:.1}",
                    bytes.total, bytes.receiver_basis, bytes.signal_basis, bytes.signals, bytes.metadata
                ),
            ),
        ];
        let percent = |value: f64| format!("{:.2} %", 100.0 * value);
        lines.extend(bars("receivers by error", &self.error_histogram, percent));
        lines.extend(bars("receivers by rank", &self.rank_histogram, |value| value.to_string()));
        lines
    }
}

impl BytesPerReceiver {
    fn of(baked: &BakedScene) -> Self {
        let receivers = baked.receiver_texels.len().max(1) as f64;
        let share = |bytes: u64| bytes as f64 / receivers;
        let bytes = baked.lightmap_bytes();
        Self {
            receiver_basis: share(bytes.receiver_basis),
            signal_basis: share(bytes.signal_basis),
            signals: share(bytes.signals),
            metadata: share(bytes.metadata),
            total: baked.matrix_bytes_per_receiver(),
        }
    }
}

/// Shares of the receivers whose cluster's value lies between edges.
fn histogram(clusters: &[Cluster], edges: &[f64], value: impl Fn(&Cluster) -> f64) -> Vec<Bin> {
    let mut counts = vec![0u64; edges.len() + 1];
    for cluster in clusters {
        let value = value(cluster);
        counts[edges.partition_point(|edge| *edge < value)] += u64::from(cluster.receiver_count);
    }
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let bin = |(i, count): (usize, &u64)| Bin {
        above: if i == 0 { 0.0 } else { edges[i - 1] },
        up_to: edges.get(i).copied(),
        share: *count as f64 / total,
    };
    counts.iter().enumerate().map(bin).collect()
}

/// A histogram as lines of text; only the first has a name.
fn bars<'a>(
    name: &'static str,
    bins: &'a [Bin],
    shown: impl Fn(f64) -> String + 'a,
) -> impl Iterator<Item = (&'static str, String)> + 'a {
    const WIDTH: f64 = 40.0;
    bins.iter().enumerate().map(move |(i, bin)| {
        let range = match bin.up_to {
            Some(end) => format!("up to {}", shown(end)),
            None => format!("above {}", shown(bin.above)),
        };
        let mut text = format!("{range:<14}{:>5.1} %", 100.0 * bin.share);
        // A bar of no length would leave a blank at the end of the line.
        let length = (WIDTH * bin.share).round() as usize;
        if length > 0 {
            _ = write!(text, " {}", "█".repeat(length));
        }
        (if i == 0 { name } else { "" }, text)
    })
}

#[cfg(test)]
mod tests {
    use probelight_asset::packed::Ranks;

    use super::*;

    fn cluster(receiver_count: u32, error: f32, rank: u32) -> Cluster {
        Cluster {
            receiver_count,
            receiver_ranks: Ranks { snorm8: rank, ..Ranks::default() },
            signal_ranks: Ranks { snorm4: rank, ..Ranks::default() },
            error,
            ..Cluster::default()
        }
    }

    #[test]
    fn histograms_weigh_clusters_by_their_receivers_and_include_their_ends() {
        let clusters = [cluster(10, 0.5, 4), cluster(30, 1.0, 5), cluster(60, 9.0, 0)];
        let shares = |bins: Vec<Bin>| bins.iter().map(|bin| bin.share).collect::<Vec<f64>>();
        assert_eq!(shares(histogram(&clusters, &[0.6, 1.0], |c| f64::from(c.error))), [0.1, 0.3, 0.6]);
        let ranks = histogram(&clusters, &[0.0, 4.0], |c| f64::from(c.rank()));
        assert_eq!(shares(ranks), [0.6, 0.1, 0.3]);
        assert_eq!(shares(histogram(&[], &[1.0], |c| f64::from(c.error))), [0.0, 0.0]);
    }

    #[test]
    fn bars_are_as_long_as_their_share() {
        let bins = histogram(&[cluster(3, 0.1, 1), cluster(1, 0.9, 1)], &[0.5], |c| f64::from(c.error));
        let lines: Vec<_> = bars("name", &bins, |value| value.to_string()).collect();
        assert_eq!(lines[0], ("name", format!("up to 0.5      75.0 % {}", "█".repeat(30))));
        assert_eq!(lines[1], ("", format!("above 0.5      25.0 % {}", "█".repeat(10))));
    }
}
