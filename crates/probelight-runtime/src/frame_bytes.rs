//! How much memory a frame must read.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;

/// Bytes that a frame must read at least once: the baked relight points, transport matrices and texel maps,
/// and last frame's irradiance at the receivers. Shadow rays and intermediate results are not counted.
pub fn frame_bytes(baked: &BakedScene) -> usize {
    let matrices = size_of_val(&baked.receiver_basis[..])
        + size_of_val(&baked.signal_basis[..])
        + size_of_val(&baked.row_scales[..])
        + size_of_val(&baked.clusters[..])
        + size_of_val(&baked.cluster_probes[..]);
    let lightmap = size_of_val(&baked.receiver_texels[..])
        + size_of_val(&baked.lightmap.dilation[..])
        + baked.receiver_texels.len() * size_of::<Vec3>();
    matrices + lightmap + size_of_val(&baked.relight_points[..])
}
