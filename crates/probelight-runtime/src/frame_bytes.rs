//! How much memory a frame must read.

use probelight_asset::{BakedScene, Surfel};
use probelight_math::glam::Vec3;

/// Bytes that a frame must read at least once: the light samples, relight rays, transport matrices and
/// texel maps, and last frame's irradiance at the receivers. Shadow rays and intermediate results are not counted.
pub fn frame_bytes(baked: &BakedScene) -> usize {
    let matrices = size_of_val(&baked.receiver_basis[..])
        + size_of_val(&baked.signal_basis[..])
        + size_of_val(&baked.row_scales[..])
        + size_of_val(&baked.clusters[..])
        + size_of_val(&baked.column_exponents[..])
        + size_of_val(&baked.cluster_signals[..])
        + size_of_val(&baked.cluster_probes[..]);
    let lightmap = size_of_val(&baked.receiver_texels[..])
        + size_of_val(&baked.lightmap.dilation[..])
        + baked.receiver_texels.len() * size_of::<Vec3>();
    // Per sample a reflectance and a texel, per surfel its kept mean besides its range.
    let light = baked.light_samples.len() * (size_of::<Vec3>() + size_of::<u32>())
        + baked.surfels.len() * (size_of::<Surfel>() + size_of::<Vec3>())
        + size_of_val(&baked.surfel_groups[..])
        + size_of_val(&baked.relight_surfels[..]);
    matrices + lightmap + light
}
