// Stage 5: fills the texels around charts that bilinear lookups touch.

struct TexelCopy {
    texel: u32,
    receiver: u32,
    /// The receiver's cluster.
    cluster: u32,
}

@group(0) @binding(0) var<storage, read> copies: array<TexelCopy>;
/// Irradiance of all receivers, W/m².
@group(0) @binding(1) var<storage, read> irradiance: array<f32>;
@group(0) @binding(2) var lightmap: texture_storage_2d<rgba16float, write>;
/// Whether the light of a cluster's receivers changes.
@group(0) @binding(3) var<storage, read> touched: array<u32>;

@compute @workgroup_size(64)
fn dilate_lightmap(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups) * 64u + local;
    if number >= arrayLength(&copies) || touched[copies[number].cluster] == 0u {
        return;
    }
    let at = 3u * copies[number].receiver;
    store_texel(copies[number].texel, vec3f(irradiance[at], irradiance[at + 1u], irradiance[at + 2u]));
}
