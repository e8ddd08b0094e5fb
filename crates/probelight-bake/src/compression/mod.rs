//! Clustered principal components: A_c = U_c Σ_c V_cᵀ, truncated, split where that is not enough
//! (\[SED\] §3.3, eq. 6).
//!
//! A plain truncated SVD treats every signal as equally likely to be bright, and spends its rank on light that
//! never occurs. The decomposition is therefore taken in a metric: U holds the eigenvectors of `A M Aᵀ`, where M
//! is the signals' expected second moment, and ΣVᵀ = Uᵀ A, which is the best for that U in any metric.

mod components;
mod error_feedback;
mod factors;
pub(crate) mod metric;
pub(crate) mod quantize;
mod ranks;

use faer::{Mat, MatRef, Scale};
use probelight_asset::{BakeSettings, Storage};
use serde::{Deserialize, Serialize};

use crate::compression::components::Components;
use crate::compression::factors::{Aim, Factors};
use crate::compression::metric::SignalMetric;
use crate::compression::quantize::{PackedFactors, quantize};
use crate::ground::site::Site;
use crate::options::ErrorGoal;
use crate::partition::KdRule;

/// A cluster ready for the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CompressedCluster {
    /// Receivers (indices), coarsest lightmap level first.
    pub(crate) receivers: Vec<u32>,
    /// Scalar signals of the leading columns.
    pub(crate) signals: Vec<u32>,
    /// Probes the other columns belong to.
    pub(crate) probes: Vec<u32>,
    /// U and ΣVᵀ.
    pub(crate) factors: PackedFactors,
}

/// A group's transport and what its columns are.
pub(crate) struct GroupMatrix<'a> {
    /// Receivers (row numbers, see [`crate::ground::Groundwork::rows`]).
    pub(crate) receivers: &'a [u32],
    /// The site of each.
    pub(crate) sites: &'a [Site],
    /// Rows that are compressed on their own to begin with.
    pub(crate) parts: Vec<Vec<u32>>,
    /// Rows of each place, one after another.
    pub(crate) rows_per_place: usize,
    pub(crate) error: ErrorGoal,
    /// What a byte must save, see [`BakeSettings::byte_price`].
    pub(crate) byte_price: f32,
    /// Two estimates of A from half of the rays each, row-major, one row per receiver of the group.
    pub(crate) halves: [&'a [f32]; 2],
    pub(crate) columns: usize,
    pub(crate) signals: &'a [u32],
    pub(crate) probes: &'a [u32],
    pub(crate) metric: &'a SignalMetric,
}

/// What compression needs to know of its surroundings.
pub(crate) struct Compressor<'a> {
    pub(crate) settings: &'a BakeSettings,
    pub(crate) split_rule: KdRule,
}

/// Clusters are not split below this many receivers per kept singular value, unless the error must be met: U and ΣVᵀ
/// would together outgrow the matrix they stand for. Nor are those split that are small already.
const FEWEST_RECEIVERS_PER_RANK: usize = 16;
const FEWEST_TO_SPLIT: usize = 512;

impl Compressor<'_> {
    /// Compresses the matrix of a group of receivers.
    pub(crate) fn compress(&self, matrix: &GroupMatrix<'_>) -> Vec<CompressedCluster> {
        let halves = matrix
            .halves
            .map(|rows| MatRef::from_row_major_slice(rows, matrix.receivers.len(), matrix.columns));
        let counted = (matrix.rows_per_place > 1).then(|| counted_energies(matrix, &halves));
        let mut pending: Vec<Vec<u32>> = matrix.parts.iter().rev().cloned().collect();
        let mut clusters = Vec::new();
        while let Some(mut rows) = pending.pop() {
            sort_coarsest_first(&mut rows, matrix.sites);
            let halves = halves
                .map(|half| Mat::from_fn(rows.len(), matrix.columns, |r, c| half[(rows[r] as usize, c)]));
            let cluster = self.decompose(&rows, &halves, matrix, counted.as_deref());
            let kept = cluster.factors.receiver_ranks.total() as usize;
            let can_split = rows.len() >= self.fewest_to_split(matrix.error, kept);
            if cluster.factors.error > matrix.error.error() && can_split {
                rows.sort_unstable();
                let (lower, upper) = self.split_rule.split(matrix.sites, rows);
                pending.push(upper);
                pending.push(lower);
            } else {
                clusters.push(cluster);
            }
        }
        clusters
    }

    fn fewest_to_split(&self, error: ErrorGoal, kept: usize) -> usize {
        // Truncation loses nothing of as many rows as there may be singular values.
        let most = self.settings.max_rank as usize + 1;
        if error.must_be_met() { most } else { FEWEST_TO_SPLIT.max(FEWEST_RECEIVERS_PER_RANK * kept) }
    }

    /// The principal components of a block, with as many singular values and bits as the error asks for.
    fn decompose(
        &self,
        rows: &[u32],
        halves: &[Mat<f32>; 2],
        matrix: &GroupMatrix<'_>,
        counted: Option<&[f64]>,
    ) -> CompressedCluster {
        let a = (&halves[0] + &halves[1]) * Scale(0.5);
        let most = (self.settings.max_rank as usize).min(a.nrows());
        let mut components = Components::of(&a, halves, matrix.metric, most);
        if let Some(counted) = counted {
            for (energy, row) in components.rows.iter_mut().zip(rows) {
                energy.counted = counted[*row as usize];
            }
        }
        let w = components.u.transpose() * &a;
        let factors = Factors {
            u: &components.u,
            w: &w,
            energies: &components.energies,
            tails: &components.tails,
            rows: &components.rows,
        };
        let aim = Aim {
            is_packed: self.settings.storage == Storage::Packed,
            error: f64::from(matrix.error.error()),
            must_be_met: matrix.error.must_be_met(),
            byte_price: f64::from(matrix.byte_price),
        };
        CompressedCluster {
            receivers: rows.iter().map(|row| matrix.receivers[*row as usize]).collect(),
            signals: matrix.signals.to_vec(),
            probes: matrix.probes.to_vec(),
            factors: quantize(&factors, matrix.metric, aim),
        }
    }
}

/// What the error of each row is a share of where places have several rows that are compressed apart: the rows of a
/// place are read together, so each part may lose an equal share of what all of them may.
fn counted_energies(matrix: &GroupMatrix<'_>, halves: &[MatRef<'_, f32>; 2]) -> Vec<f64> {
    let energies = matrix.metric.row_energies(&((halves[0] + halves[1]) * Scale(0.5)));
    let mut part_of = vec![0; energies.len()];
    for (part, rows) in matrix.parts.iter().enumerate() {
        rows.iter().for_each(|row| part_of[*row as usize] = part);
    }
    let of_place = |(energies, parts): (&[f64], &[usize])| -> Vec<f64> {
        let share = energies.iter().sum::<f64>() / matrix.parts.len() as f64;
        let count = |part: &usize| parts.iter().filter(|p| *p == part).count() as f64;
        parts.iter().map(|part| share / count(part)).collect()
    };
    let rows = matrix.rows_per_place;
    energies.chunks(rows).zip(part_of.chunks(rows)).flat_map(of_place).collect()
}

/// Orders rows so that each level of detail is a prefix.
fn sort_coarsest_first(rows: &mut [u32], sites: &[Site]) {
    rows.sort_unstable_by_key(|row| {
        let site = &sites[*row as usize];
        (std::cmp::Reverse(site.level), site.seed, *row)
    });
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compression::quantize::tests::unpacked;
    use probelight_asset::ERROR_STEPS;
    use probelight_asset::packed::Ranks;
    use probelight_math::glam::Vec3;
    use probelight_math::sampling::Rng;

    pub(crate) const COLUMNS: usize = 32;
    const STORAGES: [Storage; 2] = [Storage::F16, Storage::Packed];

    fn settings(max_rank: u32, max_cluster_error: f32, storage: Storage) -> BakeSettings {
        BakeSettings { max_rank, max_cluster_error, storage, ..BakeSettings::default() }
    }

    fn line_of_sites(count: u32) -> Vec<Site> {
        (0..count)
            .map(|i| Site {
                seed: i,
                level: ((i % 16) | (i / 16)).trailing_zeros(),
                position: Vec3::X * i as f32,
                normal: Vec3::Y,
                ..Site::default()
            })
            .collect()
    }

    /// Rows of `rank` random patterns with random weights.
    pub(crate) fn low_rank_rows(receivers: usize, rank: usize) -> Vec<f32> {
        let mut rng = Rng::new(5, 6);
        let mut random = |n: usize| (0..n).map(|_| rng.next_f32() - 0.5).collect::<Vec<f32>>();
        let (patterns, weights) = (random(rank * COLUMNS), random(rank * receivers));
        (0..receivers * COLUMNS)
            .map(|i| {
                let (r, c) = (i / COLUMNS, i % COLUMNS);
                (0..rank).map(|k| weights[k * receivers + r] * patterns[k * COLUMNS + c]).sum()
            })
            .collect()
    }

    /// Strengths of the signals: the last ones count a tenth of the first.
    fn strength(column: usize) -> f32 {
        (1.0 + column as f32 / 9.0).powf(-1.5)
    }

    fn reconstruct(cluster: &CompressedCluster) -> Mat<f32> {
        unpacked(&cluster.factors, cluster.receivers.len(), COLUMNS)
    }

    /// Relative error of a cluster's matrix in the metric.
    fn measured_error(cluster: &CompressedCluster, rows: &[f32]) -> f64 {
        let stored = reconstruct(cluster);
        let (mut squared_error, mut energy) = (0f64, 0f64);
        for (r, receiver) in cluster.receivers.iter().enumerate() {
            for c in 0..COLUMNS {
                let exact = f64::from(rows[*receiver as usize * COLUMNS + c]);
                squared_error += ((f64::from(stored[(r, c)]) - exact) * f64::from(strength(c))).powi(2);
                energy += (exact * f64::from(strength(c))).powi(2);
            }
        }
        (squared_error / energy).sqrt()
    }

    fn compress(rows: &[f32], settings: &BakeSettings) -> Vec<CompressedCluster> {
        let count = rows.len() / COLUMNS;
        let sites = line_of_sites(count as u32);
        let compressor =
            Compressor { settings, split_rule: KdRule { meters_per_normal: 1.0, by_outlook: true } };
        let group: Vec<u32> = (0..count as u32).collect();
        compressor.compress(&GroupMatrix {
            receivers: &group,
            sites: &sites,
            parts: vec![group.clone()],
            rows_per_place: 1,
            error: ErrorGoal::About(settings.max_cluster_error),
            byte_price: settings.byte_price,
            halves: [rows, rows],
            columns: COLUMNS,
            signals: &[7, 9],
            probes: &[0, 1],
            metric: &SignalMetric::independent((0..COLUMNS).map(strength).collect()),
        })
    }

    #[test]
    fn parts_of_a_place_may_lose_equal_shares_of_its_light() {
        let rows: Vec<f32> = [2.0, 1.0, 1.0, 0.0, 3.0, 0.0].into_iter().flat_map(|v| [v, 0.0]).collect();
        let metric = SignalMetric::independent(vec![1.0; 2]);
        let counted = |parts| {
            let sites = line_of_sites(6);
            let matrix = GroupMatrix {
                receivers: &[0, 1, 2, 3, 4, 5],
                sites: &sites,
                parts,
                rows_per_place: 3,
                error: ErrorGoal::About(0.1),
                byte_price: 0.44,
                halves: [&rows, &rows],
                columns: 2,
                signals: &[0, 1],
                probes: &[],
                metric: &metric,
            };
            counted_energies(&matrix, &matrix.halves.map(|h| MatRef::from_row_major_slice(h, 6, 2)))
        };
        assert_eq!(counted(vec![vec![0, 3], vec![1, 2, 4, 5]]), [3.0, 1.5, 1.5, 4.5, 2.25, 2.25]);
        assert_eq!(counted(vec![(0..6).collect()]), [2.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
    }

    #[test]
    fn matrices_of_low_rank_are_kept_to_storage_precision() {
        let rows = low_rank_rows(100, 5);
        let clusters = compress(&rows, &settings(8, 1e-3, Storage::F16));
        assert_eq!(
            (clusters.len(), clusters[0].factors.receiver_ranks),
            (1, Ranks { f16: 5, ..Ranks::default() })
        );
        let stored = reconstruct(&clusters[0]);
        for (r, receiver) in clusters[0].receivers.iter().enumerate() {
            for c in 0..COLUMNS {
                assert!((stored[(r, c)] - rows[*receiver as usize * COLUMNS + c]).abs() < 4e-3);
            }
        }
        assert!((&clusters[0].signals[..], &clusters[0].probes[..]) == (&[7, 9], &[0, 1]));
    }

    #[test]
    fn reported_error_is_that_of_the_reconstruction_and_not_trivial() {
        let rows = low_rank_rows(100, 30);
        for storage in STORAGES {
            let cluster = &compress(&rows, &settings(8, 1e-4, storage))[0];
            let measured = measured_error(cluster, &rows);
            assert!(
                (measured / f64::from(cluster.factors.error) - 1.0).abs() < 0.02,
                "{measured} {}",
                cluster.factors.error
            );
            assert!(cluster.factors.error > 0.05);
            // Negative control: a matrix with one value of ΣVᵀ wrong has another error.
            let mut wrong = cluster.clone();
            wrong.factors.row_scales[0] *= -1.0;
            assert!(measured_error(&wrong, &rows) > 1.2 * f64::from(cluster.factors.error));
        }
    }

    #[test]
    fn receivers_errors_are_those_of_their_rows() {
        let rows = low_rank_rows(100, 30);
        let target = 0.2;
        let cluster = &compress(&rows, &settings(8, target, Storage::Packed))[0];
        let stored = reconstruct(cluster);
        let real = |r: usize| {
            let exact = &rows[cluster.receivers[r] as usize * COLUMNS..][..COLUMNS];
            let energy = |value: &dyn Fn(usize) -> f32| -> f32 {
                (0..COLUMNS).map(|c| (value(c) * strength(c)).powi(2)).sum()
            };
            (energy(&|c| exact[c] - stored[(r, c)]) / energy(&|c| exact[c])).sqrt()
        };
        let reported = |r: usize| f32::from(cluster.factors.receiver_errors[r]) / ERROR_STEPS * target;
        let agree = |offset: usize| {
            let is_near = |r: &usize| (real(*r) / reported((r + offset) % 100) - 1.0).abs() < 0.1;
            (0..100).filter(is_near).count()
        };
        // The rounding of each value is known on average only.
        assert!(agree(0) > 80, "{}", agree(0));
        // Negative control: those of other receivers.
        assert!(agree(37) < 40, "{}", agree(37));
    }

    #[test]
    fn packing_takes_half_of_what_half_floats_take_at_most() {
        let rows = low_rank_rows(100, 30);
        let [floats, packed] = STORAGES.map(|storage| compress(&rows, &settings(8, 0.4, storage)).remove(0));
        let words = |cluster: &CompressedCluster| {
            cluster.factors.receiver_basis.len() + cluster.factors.signal_basis.len()
        };
        assert!(floats.factors.error <= 0.4 && packed.factors.error <= 0.4);
        assert!(2 * words(&packed) <= words(&floats) + 2 * packed.factors.receiver_ranks.total() as usize);
    }

    #[test]
    fn large_errors_split_the_cluster_and_lose_no_receiver() {
        for storage in STORAGES {
            let clusters = compress(&low_rank_rows(1024, 30), &settings(8, 1e-4, storage));
            assert!(clusters.len() > 1);
            let mut seen: Vec<u32> = clusters.iter().flat_map(|c| c.receivers.clone()).collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..1024).collect::<Vec<_>>());
        }
    }

    #[test]
    fn coarse_lightmap_levels_are_a_prefix() {
        let clusters = compress(&low_rank_rows(64, 2), &settings(8, 1e-3, Storage::Packed));
        let level = |texel: &u32| ((texel % 16) | (texel / 16)).trailing_zeros();
        let levels: Vec<u32> = clusters[0].receivers.iter().map(level).collect();
        assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    }
}
