//! What a change of a signal can do to a cluster, so that clusters to which nothing happens may rest.
//!
//! A signal's column of ΣVᵀ says by how much the irradiance of the cluster's receivers grows with it: U times that column.
//! Let w be the root mean square of that over the receivers. Then whatever the signals do, the root mean square of the
//! change of irradiance is at most Σ w_j |Δs_j|, by the triangle inequality. Reading a number per column each frame would
//! cost a fifth of what computing the cluster does; so signals are taken together in *sources* whose largest change
//! counts for all of them:
//!
//! ```text
//!  source    0 … blocks − 1                      then, for each probe,
//!            64 neighbouring scalar signals      a band of its coefficients
//! ```
//!
//! A source's weight is the sum of its signals' w. All is computed from the matrices when it is first needed.

use bytemuck::{Pod, Zeroable};
use probelight_asset::packed::{GAIN_STEPS, column_factor};
use probelight_asset::{BakedScene, Cluster, NONE};

/// Scalar signals of a source.
pub(crate) const BLOCK: usize = 64;

/// How much a source's change counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ChangeTerm {
    /// Number of the source.
    pub(crate) source: u32,
    /// Change of what reads it per change of the source.
    pub(crate) weight: f32,
}

/// A list for each of many things, one after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists<T> {
    /// Where each list begins in `items`, and where the last one ends.
    pub(crate) starts: Vec<u32>,
    pub(crate) items: Vec<T>,
}

impl<T> Lists<T> {
    fn new(lists: impl IntoIterator<Item = Vec<T>>) -> Self {
        let mut all = Self { starts: vec![0], items: Vec::new() };
        for list in lists {
            all.items.extend(list);
            all.starts.push(all.items.len() as u32);
        }
        all
    }

    /// The list of number `index`.
    #[cfg(any(feature = "cpu", test))]
    pub(crate) fn of(&self, index: usize) -> &[T] {
        &self.items[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

/// Who reads what, and how much of a change arrives.
#[derive(Clone, Debug)]
pub(crate) struct ChangeTables {
    /// Sources of scalar signals; those of the probes' bands follow.
    pub(crate) blocks: usize,
    /// Bands of a probe.
    pub(crate) bands: usize,
    /// Of each cluster: root mean square over its receivers of the change of irradiance, W/m².
    pub(crate) cluster_terms: Lists<ChangeTerm>,
    /// Of each probe: mean over the sphere of the change of radiance, W·m⁻²·sr⁻¹.
    pub(crate) probe_terms: Lists<ChangeTerm>,
    /// Of each row of b, the root mean square over the receivers of the irradiance that 1 there brings.
    pub(crate) row_strengths: Vec<f32>,
    /// Of each block of scalar signals, the clusters whose light its surfels reflect.
    pub(crate) reflected: Lists<u32>,
    /// Of each cluster, the others whose light its receivers blend with.
    pub(crate) neighbors: Lists<u32>,
}

impl ChangeTables {
    pub(crate) fn new(baked: &BakedScene) -> Self {
        let strengths = of_clusters(baked);
        let rows = strengths.iter().flat_map(|strengths| &strengths.rows).copied().collect();
        let blocks = baked.scalar_signals().div_ceil(BLOCK);
        let terms = |(cluster, strengths): (&Cluster, &Strengths)| {
            cluster_terms(baked, cluster, &strengths.columns, blocks)
        };
        Self {
            blocks,
            bands: baked.settings.sh_degree as usize + 1,
            cluster_terms: Lists::new(baked.clusters.iter().zip(&strengths).map(terms)),
            probe_terms: Lists::new((0..baked.probes.len()).map(|probe| probe_terms(baked, probe))),
            row_strengths: rows,
            reflected: reflected(baked, blocks),
            neighbors: neighbors(baked),
        }
    }

    /// Number of all sources.
    pub(crate) fn sources(&self, probes: usize) -> usize {
        self.blocks + probes * self.bands
    }
}

/// Root mean squares over a cluster's receivers of what 1 brings, W/m²: in a signal, and in a row of b.
struct Strengths {
    columns: Vec<f32>,
    rows: Vec<f32>,
}

/// Those of all clusters; the matrices of large scenes take all threads there are.
#[cfg(feature = "cpu")]
fn of_clusters(baked: &BakedScene) -> Vec<Strengths> {
    use rayon::prelude::*;
    baked.clusters.par_iter().map(|cluster| Strengths::of(baked, cluster)).collect()
}

#[cfg(not(feature = "cpu"))]
fn of_clusters(baked: &BakedScene) -> Vec<Strengths> {
    baked.clusters.iter().map(|cluster| Strengths::of(baked, cluster)).collect()
}

impl Strengths {
    fn of(baked: &BakedScene, cluster: &Cluster) -> Self {
        let (rank, columns) = (cluster.rank() as usize, baked.column_count(cluster));
        let products = products_of_u(baked, cluster);
        let scales = &baked.row_scales[cluster.row_scale_offset as usize..][..rank];
        let exponents = &baked.column_exponents[cluster.column_exponent_offset as usize..][..columns];
        let basis = &baked.signal_basis[cluster.signal_basis_offset as usize..];
        let value = |row: usize, column: usize| {
            let line = &basis[cluster.signal_ranks.line_start(row, columns)..];
            cluster.signal_ranks.precision(row).unpack(line, column) * scales[row]
        };
        let mut b = vec![0.0; rank];
        let column = |(column, exponent): (usize, &u8)| {
            b.iter_mut().enumerate().for_each(|(row, b)| *b = value(row, column));
            // |U b|² = bᵀ (UᵀU) b, whether or not U's columns are still orthogonal as stored.
            let rows = b.iter().zip(products.chunks_exact(rank));
            let square: f32 = rows
                .map(|(b_row, products)| b_row * products.iter().zip(&b).map(|(p, b)| p * b).sum::<f32>())
                .sum();
            square.max(0.0).sqrt() * column_factor(*exponent)
        };
        Self {
            columns: exponents.iter().enumerate().map(column).collect(),
            rows: (0..rank).map(|row| products[row * rank + row].sqrt()).collect(),
        }
    }
}

/// UᵀU divided by the number of receivers, row by row.
fn products_of_u(baked: &BakedScene, cluster: &Cluster) -> Vec<f32> {
    let (rank, receivers) = (cluster.rank() as usize, cluster.receiver_count as usize);
    let basis = &baked.receiver_basis[cluster.receiver_basis_offset as usize..];
    let line = |row: usize| -> Vec<f32> {
        let words = &basis[cluster.receiver_ranks.line_start(row, receivers)..];
        let precision = cluster.receiver_ranks.precision(row);
        (0..receivers).map(|receiver| precision.unpack(words, receiver)).collect()
    };
    let lines: Vec<Vec<f32>> = (0..rank).map(line).collect();
    let product =
        |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>() / receivers.max(1) as f32;
    lines.iter().flat_map(|a| lines.iter().map(|b| product(a, b))).collect()
}

/// The sources that a cluster reads: its scalar signals, block by block, then the bands of its probes.
fn cluster_terms(baked: &BakedScene, cluster: &Cluster, strengths: &[f32], blocks: usize) -> Vec<ChangeTerm> {
    let signals = baked.signals_of(cluster);
    let (of_signals, of_probes) = strengths.split_at(signals.len());
    let mut terms =
        by_source(signals.iter().map(|signal| *signal as usize / BLOCK).zip(of_signals.iter().copied()));
    let mut rest = of_probes;
    for band in 0..=baked.settings.sh_degree as usize {
        for probe in baked.probes_of(cluster) {
            let (coefficients, behind) = rest.split_at(2 * band + 1);
            let source = blocks + *probe as usize * (baked.settings.sh_degree as usize + 1) + band;
            terms.push(ChangeTerm { source: source as u32, weight: coefficients.iter().sum() });
            rest = behind;
        }
    }
    terms
}

/// The blocks of surfels that a probe's rays meet.
fn probe_terms(baked: &BakedScene, probe: usize) -> Vec<ChangeTerm> {
    let its = baked.rays_of(probe);
    let share = 1.0 / (f32::from(GAIN_STEPS) * its.len().max(1) as f32);
    let rays = baked.relight_surfels[its.clone()].iter().zip(&baked.relight_gains[its]);
    let met = rays.filter(|(surfel, _)| **surfel != NONE);
    by_source(met.map(|(surfel, gain)| (*surfel as usize / BLOCK, f32::from(*gain) * share)))
}

/// One term for each source, in their order.
fn by_source(weights: impl Iterator<Item = (usize, f32)>) -> Vec<ChangeTerm> {
    let mut weights: Vec<(usize, f32)> = weights.collect();
    weights.sort_by_key(|(source, _)| *source);
    let term = |run: &[(usize, f32)]| ChangeTerm {
        source: run[0].0 as u32,
        weight: run.iter().map(|(_, weight)| weight).sum(),
    };
    weights.chunk_by(|(a, _), (b, _)| a == b).map(term).collect()
}

/// Of each block, the clusters whose light its surfels reflect.
fn reflected(baked: &BakedScene, blocks: usize) -> Lists<u32> {
    let (receivers, clusters) = (baked.receivers_of_texels(), baked.clusters_of_receivers());
    let mut lists = vec![Vec::new(); blocks];
    for (list, surfels) in lists.iter_mut().zip(baked.surfels.chunks(BLOCK)) {
        let samples = surfels.iter().flat_map(|surfel| baked.samples_of(surfel));
        let met = samples.filter_map(|sample| receivers.get(baked.texel_of(sample) as usize));
        list.extend(met.filter(|receiver| **receiver != NONE).map(|receiver| clusters[*receiver as usize]));
        list.sort_unstable();
        list.dedup();
    }
    Lists::new(lists)
}

/// Of each cluster, those across its borders.
fn neighbors(baked: &BakedScene) -> Lists<u32> {
    let clusters = baked.clusters_of_receivers();
    let mut lists = vec![Vec::new(); baked.clusters.len()];
    for record in baked.border_blends() {
        let [own, across] = [record.receiver, record.neighbor].map(|receiver| clusters[receiver as usize]);
        lists[own as usize].push(across);
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    Lists::new(lists)
}
