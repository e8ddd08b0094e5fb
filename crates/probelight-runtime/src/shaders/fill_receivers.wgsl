// Second part of stage 4, where levels of detail leave receivers out: these get their light from those that are computed.

/// What one receiver is mixed from.
struct FillRecord {
    /// Four receivers of its cluster, counted within that: two to a word.
    sources: array<u32, 2>,
    /// Their weights, a byte each, together 255.
    weights: u32,
}

@group(0) @binding(0) var<storage, read> clusters: array<ClusterRecord>;
@group(0) @binding(1) var<storage, read> tasks: array<GatherTask>;
/// Lightmap texel of each of the shard's receivers; NONE for those of the grid.
@group(0) @binding(2) var<storage, read> receiver_texels: array<u32>;
/// A record for each receiver of the lightmap: all of level 1, all of level 2, …
@group(0) @binding(3) var<storage, read> fills: array<FillRecord>;
/// How many a level has.
@group(0) @binding(4) var<uniform> fills_of_level: u32;
/// Irradiance of all receivers, W/m².
@group(0) @binding(5) var<storage, read_write> irradiance: array<f32>;
@group(0) @binding(6) var lightmap: texture_storage_2d<rgba16float, write>;
/// Of all clusters.
@group(0) @binding(7) var<storage, read> extents: array<ClusterExtent>;

fn gathered(receiver: u32) -> vec3f {
    return vec3f(irradiance[3u * receiver], irradiance[3u * receiver + 1u], irradiance[3u * receiver + 2u]);
}

@compute @workgroup_size(256)
fn fill_receivers(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups);
    if number >= arrayLength(&tasks) {
        return;
    }
    let cluster = clusters[tasks[number].cluster];
    let extent = extents[cluster.number];
    let index = tasks[number].first + local;
    if extent.fill == 0u || index < extent.receivers || index >= cluster.receiver_count {
        return;
    }
    let first = cluster.first_receiver;
    let record = fills[(extent.fill - 1u) * fills_of_level + first + index];
    let weights = unpack4x8unorm(record.weights);
    let value = weights.x * gathered(first + (record.sources[0] & 0xffffu))
        + weights.y * gathered(first + (record.sources[0] >> 16u))
        + weights.z * gathered(first + (record.sources[1] & 0xffffu))
        + weights.w * gathered(first + (record.sources[1] >> 16u));
    let to = 3u * (first + index);
    irradiance[to] = value.x;
    irradiance[to + 1u] = value.y;
    irradiance[to + 2u] = value.z;
    let texel = receiver_texels[cluster.first_texel + index];
    if texel != NONE {
        store_texel(texel, value);
    }
}
