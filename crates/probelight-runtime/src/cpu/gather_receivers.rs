//! Stage 4: irradiance at every receiver, E = U·b (\[SED\] eq. 6), blended at the borders between clusters, and its
//! way into the lightmap.

use probelight_asset::BakedScene;
use probelight_asset::packed::Ranks;
use probelight_math::glam::Vec3;

use super::blend_borders::BlendBorders;
use super::padded_end::PaddedEnd;
use super::scatter::Scatter;
use super::stretches::{CLUSTERS_PER_TASK, for_each_stretch};
use super::unpack::{Encoding, F16, Snorm4, Snorm8};
use super::{LANES, Lanes};
use crate::frame::{FillRecord, FillTables, leading};
use crate::{FramePlan, IrradianceLightmap};

/// Receivers computed together: their three channels' sums fill twelve AVX-512 registers, and up to two
/// cache lines of each column of U are read in a row.
const BLOCK: usize = VECTORS * LANES;

const VECTORS: usize = 4;

/// Irradiance of the receivers, W/m².
#[derive(Clone, Debug)]
pub struct ReceiverIrradiance {
    values: Vec<Vec3>,
    borders: BlendBorders,
    copies: Scatter,
    /// The same of receivers beside borders alone.
    border_copies: Scatter,
    basis_end: PaddedEnd,
    fills: FillTables,
}

impl ReceiverIrradiance {
    /// Darkness for the receivers of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let clusters = baked.clusters_of_receivers();
        let borders = BlendBorders::new(&baked.clusters, &baked.border_blends());
        let cluster_of = |receiver: u32| clusters[receiver as usize];
        let texel_of = |receiver: u32| Some((*baked.receiver_texels.get(receiver as usize)?, receiver));
        Self {
            values: vec![Vec3::ZERO; baked.receiver_count()],
            copies: Scatter::new(baked.receiver_texels.iter().copied().zip(0..), cluster_of),
            border_copies: Scatter::new(borders.receivers().filter_map(texel_of), cluster_of),
            borders,
            basis_end: PaddedEnd::new(
                &baked.receiver_basis,
                baked.clusters.iter().map(|cluster| cluster.receiver_basis_offset),
            ),
            fills: FillTables::default(),
        }
    }

    /// One value per receiver, W/m²: those of the lightmap in the order of
    /// [`receiver_texels`](probelight_asset::BakedParts::receiver_texels), then the grid's.
    pub fn values(&self) -> &[Vec3] {
        &self.values
    }

    /// Prepares for levels of the lightmap up to `coarsest`.
    pub(crate) fn prepare_fills(&mut self, baked: &BakedScene, coarsest: u32) {
        if self.fills.levels() < coarsest as usize {
            self.fills = FillTables::new(baked, coarsest);
        }
    }

    /// Forgets all light.
    pub fn clear(&mut self) {
        self.values.fill(Vec3::ZERO);
        self.borders.clear();
    }

    /// Computes E of the plan's receivers from the clusters' coefficients `b` (one RGB row per singular value, cluster by
    /// cluster) and writes it to the lightmap's texels. The clusters (by number) that are touched are the plan's, and those
    /// that blend with these.
    pub fn gather_receivers(
        &mut self,
        baked: &BakedScene,
        plan: &FramePlan,
        coefficients: &[[f32; 3]],
        lightmap: &mut IrradianceLightmap,
        is_touched: impl Fn(u32) -> bool + Sync,
    ) {
        if plan.clusters().iter().all(|extent| extent.receivers == 0) {
            return;
        }
        let (end, fills) = (&self.basis_end, &self.fills);
        let all = self.values.len();
        let start = |cluster: usize| baked.clusters.get(cluster).map_or(all, |c| c.first_receiver as usize);
        for_each_stretch(
            0..baked.clusters.len(),
            CLUSTERS_PER_TASK,
            &mut self.values[..],
            &start,
            &|cluster, receivers| {
                let (cluster, extent) = (&baked.clusters[cluster], plan.clusters()[cluster]);
                let b = &coefficients[cluster.row_scale_offset as usize..][..extent.rank as usize];
                let basis = end.words_from(&baked.receiver_basis, cluster.receiver_basis_offset);
                let (stride, count) = (receivers.len(), extent.receivers as usize);
                let ranks = leading(cluster.receiver_ranks, extent.rank);
                gather_cluster(basis, stride, ranks, b, &mut receivers[..count]);
                if extent.fill > 0 && extent.fill as usize <= fills.levels() {
                    fill(fills.of(cluster, extent.fill), receivers, count);
                }
            },
        );
        self.borders.blend_borders(plan.clusters(), &mut self.values, &is_touched);
        let runs = |cluster: u32| plan.clusters()[cluster as usize].receivers > 0;
        self.copies.copy(&self.values, &mut lightmap.texels, runs);
        let borders_only = |cluster| is_touched(cluster) && !runs(cluster);
        self.border_copies.copy(&self.values, &mut lightmap.texels, borders_only);
    }
}

/// Mixes the receivers behind the leading ones from these.
fn fill(records: &[FillRecord], receivers: &mut [Vec3], leading: usize) {
    for receiver in leading..receivers.len() {
        let parts = records[receiver].parts();
        receivers[receiver] = parts.into_iter().map(|(source, weight)| weight * receivers[source]).sum();
    }
}

/// E = U·b for the leading receivers of a cluster; `basis` starts with U, in columns of `stride` receivers.
fn gather_cluster(basis: &[u32], stride: usize, ranks: Ranks, b: &[[f32; 3]], receivers: &mut [Vec3]) {
    for (block, receivers) in receivers.chunks_mut(BLOCK).enumerate() {
        let block = Block { stride, first: block * BLOCK };
        match receivers.len().div_ceil(LANES) {
            1 => block.gather::<1>(basis, ranks, b, receivers),
            2 => block.gather::<2>(basis, ranks, b, receivers),
            3 => block.gather::<3>(basis, ranks, b, receivers),
            _ => block.gather::<VECTORS>(basis, ranks, b, receivers),
        }
    }
}

/// Receivers computed together.
#[derive(Clone, Copy)]
struct Block {
    /// Receivers of the cluster as stored: length of U's columns.
    stride: usize,
    /// The block's first one.
    first: usize,
}

impl Block {
    /// E of up to `N` vectors of receivers.
    #[inline(always)]
    fn gather<const N: usize>(self, basis: &[u32], ranks: Ranks, b: &[[f32; 3]], receivers: &mut [Vec3]) {
        let mut sums = [[Lanes::ZERO; 3]; N];
        let (f16, integers) = b.split_at(ranks.f16 as usize);
        let (snorm8, snorm4) = integers.split_at(ranks.snorm8 as usize);
        let basis = self.add_section::<F16, N>(&mut sums, basis, f16);
        let basis = self.add_section::<Snorm8, N>(&mut sums, basis, snorm8);
        self.add_section::<Snorm4, N>(&mut sums, basis, snorm4);
        for (receivers, sums) in receivers.chunks_mut(LANES).zip(sums) {
            let [red, green, blue] = sums.map(Lanes::to_array);
            let vector: [Vec3; LANES] = std::array::from_fn(|i| Vec3::new(red[i], green[i], blue[i]));
            receivers.copy_from_slice(&vector[..receivers.len()]);
        }
    }

    /// Adds the columns of one precision. Returns what lies behind them.
    ///
    /// The last vector of a column reaches into what follows it; no receiver takes those lanes.
    #[inline(always)]
    fn add_section<'a, E: Encoding, const N: usize>(
        self,
        sums: &mut [[Lanes; 3]; N],
        basis: &'a [u32],
        b: &[[f32; 3]],
    ) -> &'a [u32] {
        let per_word = E::PRECISION.values_per_word();
        let mut rest = basis;
        for b in b {
            let b = b.map(|channel| Lanes::splat(channel * E::UNIT));
            let column = &rest[self.first / per_word..];
            for (vector, sums) in sums.iter_mut().enumerate() {
                let u = E::decode(&column[vector * LANES / per_word..]);
                for (sum, b) in sums.iter_mut().zip(b) {
                    *sum = u.mul_add(b, *sum);
                }
            }
            rest = &rest[E::PRECISION.words(self.stride)..];
        }
        rest
    }
}
