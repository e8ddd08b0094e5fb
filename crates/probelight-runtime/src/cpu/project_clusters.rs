//! Stage 3: each cluster's coefficients, b = (ΣVᵀ)·λ (\[SED\] §3.3).

use std::sync::{Mutex, PoisonError};

use half::f16;
use probelight_asset::{BakedScene, Cluster};

use super::clusters_in_parallel::for_each_cluster;
use super::half_float::{decode, padded};
use super::{LANES, Lanes, ProbeRadiance, load};

/// Rows of ΣVᵀ multiplied together, so that each signal is loaded once for all of them. Their three channels'
/// sums fill twelve vector registers.
const ROWS: usize = 4;

/// The clusters' coefficients b, W/m² in the metric of U.
#[derive(Debug)]
pub struct ClusterCoefficients {
    values: Vec<[f32; 3]>,
    /// A cluster's signals, one set per worker thread.
    signals: Vec<Mutex<Signals>>,
}

impl ClusterCoefficients {
    /// Zeros for the clusters of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let columns = baked.clusters.iter().map(|c| baked.column_count(c)).max().unwrap_or(0);
        let threads = rayon::current_num_threads();
        Self {
            values: vec![[0.0; 3]; baked.row_scales.len()],
            signals: (0..threads).map(|_| Mutex::new(Signals::new(columns))).collect(),
        }
    }

    /// One RGB row per singular value, in the order of [`BakedScene::row_scales`].
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }

    /// Computes b from the probes' coefficients.
    pub fn project_clusters(&mut self, baked: &BakedScene, probes: &ProbeRadiance) {
        let start = |cluster: &Cluster| cluster.row_scale_offset as usize;
        let signals = &self.signals;
        for_each_cluster(&baked.clusters, &mut self.values, &start, &|cluster, b| {
            let slot = rayon::current_thread_index().unwrap_or(0) % signals.len();
            let mut signals = signals[slot].lock().unwrap_or_else(PoisonError::into_inner);
            signals.load(baked, cluster, probes);
            project_cluster(baked, cluster, &signals, b);
        });
    }
}

/// The input of one cluster: its probes' coefficients, each channel on its own, in the order of the columns.
/// Zeros follow up to a whole number of [`LANES`].
#[derive(Debug)]
struct Signals {
    channels: [Vec<f32>; 3],
}

impl Signals {
    fn new(columns: usize) -> Self {
        // One vector more than the columns need: loads write whole vectors.
        let length = columns.next_multiple_of(LANES) + LANES;
        Self { channels: std::array::from_fn(|_| vec![0.0; length]) }
    }

    /// Gathers the coefficients band by band (column order: see [`Cluster`]).
    ///
    /// A probe's band is a run of 2l + 1 values. It is copied in whole vectors, which is faster than copies of
    /// odd length; what a copy writes too much, the next one overwrites.
    fn load(&mut self, baked: &BakedScene, cluster: &Cluster, radiance: &ProbeRadiance) {
        let probes = &baked.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize];
        let columns = baked.column_count(cluster);
        for (channel, signals) in self.channels.iter_mut().enumerate() {
            let mut column = 0;
            for l in 0..=baked.settings.sh_degree as usize {
                for probe in probes {
                    let band = radiance.coefficients_from(*probe as usize, channel, l * l);
                    for at in (0..2 * l + 1).step_by(LANES) {
                        signals[column + at..][..LANES].copy_from_slice(&band[at..][..LANES]);
                    }
                    column += 2 * l + 1;
                }
            }
            signals[columns..columns.next_multiple_of(LANES)].fill(0.0);
        }
    }
}

/// b = (ΣVᵀ)·λ for one cluster.
fn project_cluster(baked: &BakedScene, cluster: &Cluster, signals: &Signals, b: &mut [[f32; 3]]) {
    let columns = baked.column_count(cluster);
    let basis = &baked.signal_basis[cluster.signal_basis_offset as usize..][..b.len() * columns];
    let scales = &baked.row_scales[cluster.row_scale_offset as usize..][..b.len()];
    if columns == 0 {
        b.fill([0.0; 3]);
        return;
    }
    let signals = signals.channels.each_ref().map(|c| &c[..columns.next_multiple_of(LANES)]);
    let whole = b.len() - b.len() % ROWS;
    for row in (0..whole).step_by(ROWS) {
        let rows = std::array::from_fn(|i| &basis[(row + i) * columns..][..columns]);
        b[row..row + ROWS].copy_from_slice(&multiply_rows::<ROWS>(rows, signals));
    }
    for row in whole..b.len() {
        [b[row]] = multiply_rows([&basis[row * columns..][..columns]], signals);
    }
    for (b, scale) in b.iter_mut().zip(scales) {
        *b = b.map(|channel| channel * scale);
    }
}

/// Products of `R` rows with the three channels.
#[inline(always)]
fn multiply_rows<const R: usize>(rows: [&[f16]; R], signals: [&[f32]; 3]) -> [[f32; 3]; R] {
    let mut sums = [[Lanes::ZERO; 3]; R];
    let columns = rows[0].len();
    let whole = columns - columns % LANES;
    for at in (0..whole).step_by(LANES) {
        accumulate(&mut sums, rows.map(|row| padded(&row[at..at + LANES])), signals.map(|s| load(&s[at..])));
    }
    if whole < columns {
        accumulate(&mut sums, rows.map(|row| padded(&row[whole..])), signals.map(|s| load(&s[whole..])));
    }
    sums.map(|row| row.map(Lanes::reduce_add))
}

/// Adds one vector's products to the sums.
#[inline(always)]
fn accumulate<const R: usize>(sums: &mut [[Lanes; 3]; R], rows: [[f16; LANES]; R], signals: [Lanes; 3]) {
    for (sums, row) in sums.iter_mut().zip(&rows) {
        let row = decode(row);
        for (sum, signal) in sums.iter_mut().zip(signals) {
            *sum = row.mul_add(signal, *sum);
        }
    }
}
