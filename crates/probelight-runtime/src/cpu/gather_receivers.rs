//! Stage 4: irradiance at every receiver, E = U·b (\[SED\] eq. 6), and its way into the lightmap.

use half::f16;
use probelight_asset::{BakedScene, Cluster};
use probelight_math::glam::Vec3;

use super::clusters_in_parallel::for_each_cluster;
use super::half_float::{decode, padded};
use super::texel_copies::TexelCopies;
use super::{LANES, Lanes};
use crate::IrradianceLightmap;

/// Receivers computed together: their three channels' sums fill twelve AVX-512 registers, and two cache lines
/// of each column of U are read in a row.
const BLOCK: usize = VECTORS * LANES;

const VECTORS: usize = 4;

/// Irradiance of the receivers, W/m².
#[derive(Clone, Debug)]
pub struct ReceiverIrradiance {
    values: Vec<Vec3>,
    copies: TexelCopies,
}

impl ReceiverIrradiance {
    /// Darkness for the receivers of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        Self {
            values: vec![Vec3::ZERO; baked.receiver_texels.len()],
            copies: TexelCopies::new(baked.receiver_texels.iter().copied().zip(0..)),
        }
    }

    /// One value per receiver, in the order of [`BakedScene::receiver_texels`], W/m².
    pub fn values(&self) -> &[Vec3] {
        &self.values
    }

    /// Forgets all light.
    pub fn clear(&mut self) {
        self.values.fill(Vec3::ZERO);
    }

    /// Computes E from the clusters' coefficients `b` (one RGB row per singular value, cluster by cluster) and
    /// writes it to the lightmap's texels.
    pub fn gather_receivers(
        &mut self,
        baked: &BakedScene,
        coefficients: &[[f32; 3]],
        lightmap: &mut IrradianceLightmap,
    ) {
        let start = |cluster: &Cluster| cluster.first_receiver as usize;
        for_each_cluster(&baked.clusters, &mut self.values, &start, &|cluster, receivers| {
            let b = &coefficients[cluster.row_scale_offset as usize..][..cluster.rank as usize];
            let basis = &baked.receiver_basis[cluster.receiver_basis_offset as usize..];
            gather_cluster(&basis[..receivers.len() * b.len()], b, receivers);
        });
        self.copies.apply(&self.values, &mut lightmap.texels);
    }
}

/// E = U·b for one cluster; `basis` holds U column by column.
fn gather_cluster(basis: &[f16], b: &[[f32; 3]], receivers: &mut [Vec3]) {
    let rows = receivers.len();
    let whole_blocks = rows - rows % BLOCK;
    for first in (0..whole_blocks).step_by(BLOCK) {
        gather_block::<VECTORS>(basis, b, rows, first, &mut receivers[first..first + BLOCK]);
    }
    for first in (whole_blocks..rows).step_by(LANES) {
        gather_block::<1>(basis, b, rows, first, &mut receivers[first..rows.min(first + LANES)]);
    }
}

/// E of up to `N` vectors of receivers from row `first` on.
#[inline(always)]
fn gather_block<const N: usize>(
    basis: &[f16],
    b: &[[f32; 3]],
    rows: usize,
    first: usize,
    receivers: &mut [Vec3],
) {
    let mut sums = [[Lanes::ZERO; 3]; N];
    for (column, b) in basis.chunks_exact(rows).zip(b) {
        let b = b.map(Lanes::splat);
        let column = &column[first..first + receivers.len()];
        for (vector, sums) in sums.iter_mut().enumerate() {
            let u = decode(&padded(&column[vector * LANES..]));
            for (sum, b) in sums.iter_mut().zip(b) {
                *sum = u.mul_add(b, *sum);
            }
        }
    }
    for (receivers, sums) in receivers.chunks_mut(LANES).zip(sums) {
        let [red, green, blue] = sums.map(Lanes::to_array);
        for (i, receiver) in receivers.iter_mut().enumerate() {
            *receiver = Vec3::new(red[i], green[i], blue[i]);
        }
    }
}
