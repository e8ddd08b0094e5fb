//! Stage 3: each cluster's coefficients, b = (ΣVᵀ)·s of its signals (\[SED\] §3.3).

use probelight_asset::packed::column_factor;
use probelight_asset::{BakedScene, Cluster};
use probelight_math::glam::Vec3;

use super::padded_end::PaddedEnd;
use super::per_thread::PerThread;
use super::stretches::{CLUSTERS_PER_TASK, for_each_stretch};
use super::unpack::{Encoding, F16, Snorm4, Snorm8};
use super::{LANES, Lanes, ProbeRadiance, load};
use crate::frame::leading;
use crate::{ClusterExtent, FramePlan, Ways};

/// Rows of ΣVᵀ multiplied together, so that each signal is loaded once for all of them. Their three channels'
/// sums fill twelve vector registers.
const ROWS: usize = 4;

/// The clusters' coefficients b, W/m² in the metric of U.
#[derive(Debug)]
pub struct ClusterCoefficients {
    values: Vec<[f32; 3]>,
    columns: PerThread<Columns>,
    /// Factor of each exponent.
    column_factors: [f32; 256],
    basis_end: PaddedEnd,
}

impl ClusterCoefficients {
    /// Zeros for the clusters of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let columns = baked.clusters.iter().map(|c| baked.column_count(c)).max().unwrap_or(0);
        Self {
            values: vec![[0.0; 3]; baked.row_scales.len()],
            columns: PerThread::new(|| Columns::new(columns)),
            column_factors: std::array::from_fn(|exponent| column_factor(exponent as u8)),
            basis_end: PaddedEnd::new(
                &baked.signal_basis,
                baked.clusters.iter().map(|cluster| cluster.signal_basis_offset),
            ),
        }
    }

    /// One RGB row per singular value, in the order of [`row_scales`](probelight_asset::BakedParts::row_scales).
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }

    /// Computes the plan's rows of b from as many scalar signals and coefficients of probes.
    pub fn project_clusters(
        &mut self,
        baked: &BakedScene,
        ways: Ways<'_>,
        plan: &FramePlan,
        signals: &[Vec3],
        probes: &ProbeRadiance,
    ) {
        let (columns, factors, end) = (&self.columns, &self.column_factors, &self.basis_end);
        let rows = self.values.len();
        let start =
            |cluster: usize| baked.clusters.get(cluster).map_or(rows, |c| c.row_scale_offset as usize);
        for_each_stretch(
            0..baked.clusters.len(),
            CLUSTERS_PER_TASK,
            &mut self.values[..],
            &start,
            &|cluster, b| {
                let (cluster, extent) = (&baked.clusters[cluster], plan.clusters()[cluster]);
                if extent.rank == 0 {
                    return;
                }
                let mut columns = columns.lock();
                columns.load_signals(baked, cluster, extent, signals);
                columns.load_probes(baked, cluster, extent, probes);
                let columns = columns.scale(ways, cluster, extent, factors);
                let words = end.words_from(&baked.signal_basis, cluster.signal_basis_offset);
                project_cluster(baked, cluster, extent, words, columns, &mut b[..extent.rank as usize]);
            },
        );
    }
}

/// The input of one cluster: a value per column of its ΣVᵀ, as far as columns count.
#[derive(Debug)]
struct Columns {
    /// Signals and coefficients, each channel on its own.
    channels: [Vec<f32>; 3],
    /// The same times the columns' factors, in vectors of each channel; zeros follow up to a whole vector.
    scaled: Vec<[Lanes; 3]>,
}

impl Columns {
    fn new(columns: usize) -> Self {
        let vectors = columns.div_ceil(LANES);
        // One vector more than the columns need: copies write whole vectors.
        let channel = vec![0.0; (vectors + 1) * LANES];
        Self {
            channels: [channel.clone(), channel.clone(), channel],
            scaled: vec![[Lanes::ZERO; 3]; vectors],
        }
    }

    /// Gathers the cluster's scalar signals to the first columns.
    fn load_signals(
        &mut self,
        baked: &BakedScene,
        cluster: &Cluster,
        extent: ClusterExtent,
        signals: &[Vec3],
    ) {
        let numbers = baked.signals_of(cluster);
        let numbers = &numbers[..numbers.len().min(extent.columns as usize)];
        let [red, green, blue] = self.channels.each_mut().map(|channel| &mut channel[..numbers.len()]);
        for (column, number) in numbers.iter().enumerate() {
            let signal = signals[*number as usize];
            (red[column], green[column], blue[column]) = (signal.x, signal.y, signal.z);
        }
    }

    /// Gathers the probes' coefficients band by band (column order: see [`Cluster`]), up to the last band of which a
    /// column counts.
    ///
    /// A probe's band is a run of 2l + 1 values. It is copied in whole vectors, which is faster than copies of
    /// odd length; what a copy writes too much, the next one overwrites.
    fn load_probes(
        &mut self,
        baked: &BakedScene,
        cluster: &Cluster,
        extent: ClusterExtent,
        radiance: &ProbeRadiance,
    ) {
        let probes = baked.probes_of(cluster);
        for (channel, columns) in self.channels.iter_mut().enumerate() {
            let mut column = cluster.signal_count as usize;
            for l in 0..=baked.settings.sh_degree as usize {
                if column >= extent.columns as usize {
                    break;
                }
                for probe in probes {
                    let band = radiance.coefficients_from(*probe as usize, channel, l * l);
                    for at in (0..2 * l + 1).step_by(LANES) {
                        columns[column + at..][..LANES].copy_from_slice(&band[at..][..LANES]);
                    }
                    column += 2 * l + 1;
                }
            }
        }
    }

    /// Multiplies the columns that count with their factors.
    fn scale(
        &mut self,
        ways: Ways<'_>,
        cluster: &Cluster,
        extent: ClusterExtent,
        factors: &[f32; 256],
    ) -> &[[Lanes; 3]] {
        let count = extent.columns as usize;
        let exponents = &ways.column_exponents[cluster.column_exponent_offset as usize..][..count];
        for channel in &mut self.channels {
            channel[count..count.next_multiple_of(LANES)].fill(0.0);
        }
        let [red, green, blue] = &self.channels;
        let scaled = &mut self.scaled[..count.div_ceil(LANES)];
        for (vector, (scaled, exponents)) in scaled.iter_mut().zip(exponents.chunks(LANES)).enumerate() {
            let mut lanes = [0.0; LANES];
            for (factor, exponent) in lanes.iter_mut().zip(exponents) {
                *factor = factors[usize::from(*exponent)];
            }
            let (lanes, at) = (Lanes::new(lanes), vector * LANES);
            *scaled = [load(&red[at..]) * lanes, load(&green[at..]) * lanes, load(&blue[at..]) * lanes];
        }
        scaled
    }
}

/// A stretch of rows of ΣVᵀ that are stored with one precision, and the words behind it.
#[derive(Clone, Copy)]
struct Rows<'a> {
    words: &'a [u32],
    /// Values of a row as stored.
    stride: usize,
}

impl<'a> Rows<'a> {
    /// Products of the first rows with the columns, without their scales. Returns the rows behind them.
    fn multiply_section<E: Encoding>(mut self, columns: &[[Lanes; 3]], products: &mut [[f32; 3]]) -> Self {
        let mut blocks = products.chunks_exact_mut(ROWS);
        for block in &mut blocks {
            self = self.multiply::<E, ROWS>(columns, block);
        }
        match blocks.into_remainder() {
            rest @ [_] => self.multiply::<E, 1>(columns, rest),
            rest @ [_, _] => self.multiply::<E, 2>(columns, rest),
            rest @ [_, _, _] => self.multiply::<E, 3>(columns, rest),
            _ => self,
        }
    }

    /// Products of the first `R` rows. Returns the rows behind them.
    ///
    /// The last vector of a row reaches into what follows it: there the columns are zero, and packed values
    /// are finite whatever their bits.
    #[inline(always)]
    fn multiply<E: Encoding, const R: usize>(
        self,
        columns: &[[Lanes; 3]],
        products: &mut [[f32; 3]],
    ) -> Self {
        let words = E::PRECISION.words(self.stride);
        let rows: [&[u32]; R] = std::array::from_fn(|row| &self.words[row * words..]);
        let mut sums = [[Lanes::ZERO; 3]; R];
        for (vector, columns) in columns.iter().enumerate() {
            for (sums, row) in sums.iter_mut().zip(rows) {
                let values = E::decode(&row[vector * LANES / E::PRECISION.values_per_word()..]);
                for (sum, column) in sums.iter_mut().zip(columns) {
                    *sum = values.mul_add(*column, *sum);
                }
            }
        }
        for (product, sums) in products.iter_mut().zip(sums) {
            *product = sums.map(|sum| sum.reduce_add() * E::UNIT);
        }
        Self { words: &self.words[R * words..], ..self }
    }
}

/// The leading rows of b = (ΣVᵀ)·s for one cluster, whose matrix is the beginning of `words`.
fn project_cluster(
    baked: &BakedScene,
    cluster: &Cluster,
    extent: ClusterExtent,
    words: &[u32],
    columns: &[[Lanes; 3]],
    b: &mut [[f32; 3]],
) {
    let rows = Rows { words, stride: baked.column_count(cluster) };
    let ranks = leading(cluster.signal_ranks, b.len() as u32);
    let (f16, integers) = b.split_at_mut(ranks.f16 as usize);
    let (snorm8, snorm4) = integers.split_at_mut(ranks.snorm8 as usize);
    rows.multiply_section::<F16>(columns, f16)
        .multiply_section::<Snorm8>(columns, snorm8)
        .multiply_section::<Snorm4>(columns, snorm4);
    let scales = &baked.row_scales[cluster.row_scale_offset as usize..];
    for (row, (b, scale)) in b.iter_mut().zip(scales).enumerate() {
        *b = b.map(|channel| channel * (scale * extent.weight(row)));
    }
}
