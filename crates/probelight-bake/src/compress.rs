//! Clustered principal components: A_c = U_c Σ_c V_cᵀ, truncated, split where that is not enough
//! (\[SED\] §3.3, eq. 6).
//!
//! A plain truncated SVD treats every coefficient as equally likely to be bright, and spends its rank on
//! high bands that carry little light. The decomposition is therefore taken in a metric: columns are
//! multiplied by the expected strength of their band before, and divided by it after.

use faer::{Mat, MatRef};
use half::f16;
use probelight_asset::BakeSettings;
use probelight_math::sh::band;
use probelight_scene::Bounds;
use serde::{Deserialize, Serialize};

use crate::partition::KdRule;
use crate::receivers::Receiver;

/// Expected strength of the coefficients of band l relative to band 0: a prior, not a measurement of the scene
/// at hand. Radiance with edges falls off about so.
fn band_strength(l: usize) -> f32 {
    (1.0 + l as f32).powf(-1.5)
}

/// A cluster ready for the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CompressedCluster {
    /// Receivers (indices), coarsest lightmap level first.
    pub(crate) receivers: Vec<u32>,
    /// Probes the columns belong to.
    pub(crate) probes: Vec<u32>,
    pub(crate) rank: u32,
    /// U: `rank` columns of one value per receiver.
    pub(crate) receiver_basis: Vec<f16>,
    /// ΣVᵀ: `rank` rows of one value per column of A, each divided by its scale.
    pub(crate) signal_basis: Vec<f16>,
    /// One scale per row.
    pub(crate) row_scales: Vec<f32>,
    /// Relative error of the truncated matrix in the metric.
    pub(crate) error: f32,
}

/// A matrix block still to be compressed: receivers (indices) and their rows of A.
struct Block {
    receivers: Vec<u32>,
    /// Row numbers in the cluster's matrix.
    rows: Vec<usize>,
}

/// What compression needs to know of its surroundings.
pub(crate) struct Compressor<'a> {
    pub(crate) settings: &'a BakeSettings,
    pub(crate) receivers: &'a [Receiver],
    pub(crate) split_rule: KdRule,
    pub(crate) lightmap_width: u32,
}

/// Clusters are not split below this many receivers per kept singular value: U and ΣVᵀ would together
/// outgrow the matrix they stand for.
const FEWEST_RECEIVERS_PER_RANK: usize = 8;

impl Compressor<'_> {
    /// Compresses the rows of `group` (row-major, one per receiver of the group).
    pub(crate) fn compress(
        &self,
        group: &[u32],
        rows: &[f32],
        columns: usize,
        probes: &[u32],
    ) -> Vec<CompressedCluster> {
        let strength: Vec<f32> = (0..columns).map(|c| band_strength(band(c / probes.len().max(1)))).collect();
        let matrix = MatRef::from_row_major_slice(rows, group.len(), columns);
        let mut pending = vec![Block { receivers: group.to_vec(), rows: (0..group.len()).collect() }];
        let mut clusters = Vec::new();
        while let Some(mut block) = pending.pop() {
            self.sort_coarsest_first(&mut block);
            let weighted =
                Mat::from_fn(block.rows.len(), columns, |r, c| matrix[(block.rows[r], c)] * strength[c]);
            let cluster = self.truncate(&block, &weighted, &strength, probes);
            let can_split =
                block.rows.len() >= 2 * FEWEST_RECEIVERS_PER_RANK * self.settings.max_rank as usize;
            if cluster.error > self.settings.max_cluster_error && can_split {
                let (lower, upper) = self.split(block);
                pending.push(upper);
                pending.push(lower);
            } else {
                clusters.push(cluster);
            }
        }
        clusters
    }

    fn split(&self, block: Block) -> (Block, Block) {
        let row_of: std::collections::HashMap<u32, usize> =
            block.receivers.iter().copied().zip(block.rows.iter().copied()).collect();
        let (lower, upper) = self.split_rule.split(self.receivers, block.receivers);
        let with_rows =
            |receivers: Vec<u32>| Block { rows: receivers.iter().map(|r| row_of[r]).collect(), receivers };
        (with_rows(lower), with_rows(upper))
    }

    /// Orders a block's receivers so that each lightmap level is a prefix: texels whose coordinates both
    /// have k trailing zero bits belong to level k (\[SED\] §5.3).
    fn sort_coarsest_first(&self, block: &mut Block) {
        let mut order: Vec<(u32, usize)> =
            block.receivers.iter().copied().zip(block.rows.iter().copied()).collect();
        order.sort_unstable_by_key(|(receiver, _)| {
            let texel = self.receivers[*receiver as usize].texel;
            let (x, y) = (texel % self.lightmap_width, texel / self.lightmap_width);
            (std::cmp::Reverse((x | y).trailing_zeros()), texel)
        });
        (block.receivers, block.rows) = order.into_iter().unzip();
    }

    /// The truncated SVD of a weighted block, with as many singular values as the error asks for.
    fn truncate(
        &self,
        block: &Block,
        weighted: &Mat<f32>,
        strength: &[f32],
        probes: &[u32],
    ) -> CompressedCluster {
        let (u, singular, v) = thin_svd(weighted);
        let energy: f64 = singular.iter().map(|s| f64::from(*s).powi(2)).sum();
        let target = energy * f64::from(self.settings.max_cluster_error).powi(2);
        let most = singular.len().min(self.settings.max_rank as usize);
        let mut rest = energy;
        let mut rank = 0;
        while rank < most && rest > target {
            rest -= f64::from(singular[rank]).powi(2);
            rank += 1;
        }
        let height = block.rows.len();
        // U's columns have unit length; scaled to unit mean square they sit in f16's best range.
        let u_scale = (height as f32).sqrt();
        let mut cluster = CompressedCluster {
            receivers: block.receivers.clone(),
            probes: probes.to_vec(),
            rank: rank as u32,
            receiver_basis: Vec::with_capacity(rank * height),
            signal_basis: Vec::with_capacity(rank * strength.len()),
            row_scales: Vec::with_capacity(rank),
            error: (rest.max(0.0) / energy.max(f64::MIN_POSITIVE)).sqrt() as f32,
        };
        for k in 0..rank {
            cluster.receiver_basis.extend((0..height).map(|r| f16::from_f32(u[(r, k)] * u_scale)));
            let row: Vec<f32> =
                (0..strength.len()).map(|c| singular[k] * v[(c, k)] / (strength[c] * u_scale)).collect();
            let scale =
                row.iter().fold(0f32, |largest, value| largest.max(value.abs())).max(f32::MIN_POSITIVE);
            cluster.row_scales.push(scale);
            cluster.signal_basis.extend(row.iter().map(|value| f16::from_f32(value / scale)));
        }
        cluster
    }
}

/// U, the singular values in descending order, and V. A matrix that does not decompose (it holds no
/// finite numbers) has none.
fn thin_svd(matrix: &Mat<f32>) -> (Mat<f32>, Vec<f32>, Mat<f32>) {
    match matrix.thin_svd() {
        Ok(svd) => {
            let singular = svd.S().column_vector().iter().copied().collect();
            (svd.U().to_owned(), singular, svd.V().to_owned())
        }
        Err(_) => (Mat::zeros(matrix.nrows(), 0), Vec::new(), Mat::zeros(matrix.ncols(), 0)),
    }
}

/// Box around a cluster's receivers.
pub(crate) fn bounds_of(receivers: &[Receiver], group: &[u32]) -> Bounds {
    Bounds::of(group.iter().map(|r| receivers[*r as usize].position))
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::glam::Vec3;
    use probelight_math::sampling::Rng;

    fn settings(max_rank: u32, max_cluster_error: f32) -> BakeSettings {
        BakeSettings { max_rank, max_cluster_error, ..BakeSettings::default() }
    }

    fn line_of_receivers(count: u32) -> Vec<Receiver> {
        (0..count)
            .map(|i| Receiver { texel: i, position: Vec3::X * i as f32, normal: Vec3::Y, outlook: None })
            .collect()
    }

    /// Rows of `rank` random patterns with random weights.
    fn low_rank_rows(receivers: usize, columns: usize, rank: usize) -> Vec<f32> {
        let mut rng = Rng::new(5, 6);
        let mut random = |n: usize| (0..n).map(|_| rng.next_f32() - 0.5).collect::<Vec<f32>>();
        let (patterns, weights) = (random(rank * columns), random(rank * receivers));
        (0..receivers * columns)
            .map(|i| {
                let (r, c) = (i / columns, i % columns);
                (0..rank).map(|k| weights[k * receivers + r] * patterns[k * columns + c]).sum()
            })
            .collect()
    }

    fn reconstruct(cluster: &CompressedCluster, columns: usize) -> Vec<(u32, Vec<f32>)> {
        let height = cluster.receivers.len();
        let value = |r: usize, c: usize| -> f32 {
            (0..cluster.rank as usize)
                .map(|k| {
                    cluster.receiver_basis[k * height + r].to_f32()
                        * cluster.signal_basis[k * columns + c].to_f32()
                        * cluster.row_scales[k]
                })
                .sum()
        };
        (0..height).map(|r| (cluster.receivers[r], (0..columns).map(|c| value(r, c)).collect())).collect()
    }

    fn compress(count: usize, rows: &[f32], settings: &BakeSettings) -> Vec<CompressedCluster> {
        let receivers = line_of_receivers(count as u32);
        let compressor = Compressor {
            settings,
            receivers: &receivers,
            split_rule: KdRule { meters_per_normal: 1.0 },
            lightmap_width: 16,
        };
        let group: Vec<u32> = (0..count as u32).collect();
        compressor.compress(&group, rows, rows.len() / count, &[0, 1])
    }

    #[test]
    fn matrices_of_low_rank_are_kept_to_storage_precision() {
        let (count, columns) = (100, 32);
        let rows = low_rank_rows(count, columns, 5);
        let clusters = compress(count, &rows, &settings(8, 1e-4));
        assert_eq!((clusters.len(), clusters[0].rank), (1, 5));
        for (receiver, row) in reconstruct(&clusters[0], columns) {
            for (c, value) in row.iter().enumerate() {
                assert!((value - rows[receiver as usize * columns + c]).abs() < 4e-3);
            }
        }
    }

    #[test]
    fn reported_error_bounds_the_reconstruction_and_is_not_trivial() {
        let (count, columns) = (100, 32);
        let rows = low_rank_rows(count, columns, 30);
        let cluster = &compress(count, &rows, &settings(8, 1e-4))[0];
        let (mut squared_error, mut energy) = (0f64, 0f64);
        for (receiver, row) in reconstruct(cluster, columns) {
            for (c, value) in row.iter().enumerate() {
                let strength = f64::from(band_strength(band(c / 2)));
                let exact = f64::from(rows[receiver as usize * columns + c]);
                squared_error += ((f64::from(*value) - exact) * strength).powi(2);
                energy += (exact * strength).powi(2);
            }
        }
        let measured = (squared_error / energy).sqrt();
        assert!((measured - f64::from(cluster.error)).abs() < 2e-3, "{measured} {}", cluster.error);
        assert!(cluster.error > 0.05);
    }

    #[test]
    fn large_errors_split_the_cluster_and_lose_no_receiver() {
        let (count, columns) = (256, 32);
        let rows = low_rank_rows(count, columns, 30);
        let clusters = compress(count, &rows, &settings(8, 1e-4));
        assert!(clusters.len() > 1);
        let mut seen: Vec<u32> = clusters.iter().flat_map(|c| c.receivers.clone()).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..count as u32).collect::<Vec<_>>());
    }

    #[test]
    fn coarse_lightmap_levels_are_a_prefix() {
        let rows = low_rank_rows(64, 32, 2);
        let clusters = compress(64, &rows, &settings(8, 1e-3));
        let level = |texel: &u32| ((texel % 16) | (texel / 16)).trailing_zeros();
        let levels: Vec<u32> = clusters[0].receivers.iter().map(level).collect();
        assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    }
}
