//! How much memory a frame must read.

use probelight_asset::{BakedScene, LightSample, Surfel};
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
        + size_of_val(&baked.border_blends()[..])
        + size_of_val(&baked.lightmap.dilation[..])
        + baked.receiver_texels.len() * size_of::<Vec3>();
    // Per sample a reflectance and a texel, per surfel its kept mean besides its range.
    let light = baked.light_samples.len() * (size_of::<Vec3>() + size_of::<u32>())
        + baked.surfels.len() * (size_of::<Surfel>() + size_of::<Vec3>())
        + size_of_val(&baked.surfel_groups[..])
        + size_of_val(&baked.relight_surfels[..])
        + size_of_val(&baked.relight_gains[..]);
    matrices + lightmap + light
}

/// Bytes that each stage of a frame on the CPU must move if it reads each of its inputs once and writes each of
/// its outputs once; in the order of the stages. Shadow rays are not counted, shading only if `lights_move`.
pub fn stage_bytes(baked: &BakedScene, lights_move: bool) -> [u64; 5] {
    let rgb = size_of::<Vec3>();
    let receivers = baked.receiver_texels.len();
    let signals = rgb * baked.scalar_signals();
    let probes = rgb * baked.probes.len() * baked.coefficients();
    let coefficients = rgb * baked.row_scales.len();
    let light = baked.light_samples.len() * (rgb + size_of::<u32>())
        + baked.surfels.len() * (size_of::<Surfel>() + rgb)
        + size_of_val(&baked.surfel_groups[..])
        + rgb * receivers
        + signals;
    // The samples, their direct light, written and read, and what shading leaves behind.
    let shading =
        baked.light_samples.len() * (size_of::<LightSample>() + 4 * rgb) + rgb * baked.surfels.len();
    let light = light + if lights_move { shading } else { 0 };
    let relight_rays = size_of_val(&baked.relight_surfels[..]) + size_of_val(&baked.relight_gains[..]);
    let relight = relight_rays + rgb * baked.surfels.len() + probes;
    let project = size_of_val(&baked.signal_basis[..])
        + size_of_val(&baked.row_scales[..])
        + size_of_val(&baked.column_exponents[..])
        + size_of_val(&baked.cluster_signals[..])
        + size_of_val(&baked.cluster_probes[..])
        + size_of_val(&baked.clusters[..])
        + signals
        + probes
        + coefficients;
    // A receiver's irradiance, the number of its texel, and the texel.
    let gather = size_of_val(&baked.receiver_basis[..])
        + coefficients
        + receivers * (2 * rgb + 4)
        + size_of_val(&baked.border_blends()[..]);
    let dilate = baked.lightmap.dilation.len() * (2 * rgb + 8);
    [light, relight, project, gather, dilate].map(|bytes| bytes as u64)
}
