// Second half of stage 4: receivers beside the borders between clusters. First what was gathered is kept, then all that
// may have changed are blended from what is kept, and take their place among the receivers.

struct BorderReceiver {
    receiver: u32,
    texel: u32,
    /// First of its records.
    first_record: u32,
    record_count: u32,
    /// Its cluster, among all.
    cluster: u32,
    /// Which of the cluster's receivers it is.
    index: u32,
}

/// What a receiver beside a border blends with across it.
struct BorderRecord {
    /// The next receiver across: its slot, or its number.
    neighbor: u32,
    /// The one behind it.
    beyond: u32,
    /// Their cluster.
    across: u32,
}

/// Marks the number of a slot, which is that of a receiver beside a border, where others are those of receivers.
const BORDER_SLOT: u32 = 0x80000000u;

/// Steepest slope that is continued across a border, per texel, as a share of the irradiance: `STEEPEST_SLOPE` of the
/// asset.
const STEEPEST_SLOPE: f32 = 0.25;

@group(0) @binding(0) var<storage, read> border_receivers: array<BorderReceiver>;
@group(0) @binding(1) var<storage, read> records: array<BorderRecord>;
/// Irradiance of all receivers, W/m².
@group(0) @binding(2) var<storage, read_write> irradiance: array<f32>;
/// Irradiance of the receivers beside borders as it was gathered, W/m².
@group(0) @binding(3) var<storage, read_write> unblended: array<f32>;
@group(0) @binding(4) var lightmap: texture_storage_2d<rgba16float, write>;
/// Of all clusters.
@group(0) @binding(5) var<storage, read> extents: array<ClusterExtent>;

fn kept(slot: u32) -> vec3f {
    return vec3f(unblended[3u * slot], unblended[3u * slot + 1u], unblended[3u * slot + 2u]);
}

/// What was gathered for a receiver or a slot.
fn gathered(source: u32) -> vec3f {
    if (source & BORDER_SLOT) != 0u {
        return kept(source ^ BORDER_SLOT);
    }
    return vec3f(irradiance[3u * source], irradiance[3u * source + 1u], irradiance[3u * source + 2u]);
}

/// What the cluster across the border would say.
fn continued(own: vec3f, record: BorderRecord) -> vec3f {
    let neighbor = gathered(record.neighbor);
    let beyond = gathered(record.beyond);
    let steepest = STEEPEST_SLOPE * abs(neighbor);
    let continued = neighbor + clamp(neighbor - beyond, -steepest, steepest);
    return clamp(continued, min(min(neighbor, beyond), own), max(max(neighbor, beyond), own));
}

@compute @workgroup_size(64)
fn keep_unblended(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let slot = linear_workgroup(workgroup, workgroups) * 64u + local;
    if slot >= arrayLength(&border_receivers) {
        return;
    }
    let place = border_receivers[slot];
    let extent = extents[place.cluster];
    if place.index < extent.receivers || extent.fill > 0u {
        let at = 3u * place.receiver;
        unblended[3u * slot] = irradiance[at];
        unblended[3u * slot + 1u] = irradiance[at + 1u];
        unblended[3u * slot + 2u] = irradiance[at + 2u];
    }
}

@compute @workgroup_size(64)
fn blend_borders(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let slot = linear_workgroup(workgroup, workgroups) * 64u + local;
    if slot >= arrayLength(&border_receivers) {
        return;
    }
    let place = border_receivers[slot];
    let own = kept(slot);
    var sum = 2.0 * own;
    var is_new = extents[place.cluster].receivers > 0u;
    for (var i = place.first_record; i < place.first_record + place.record_count; i++) {
        sum += continued(own, records[i]);
        is_new = is_new || extents[records[i].across].receivers > 0u;
    }
    if !is_new {
        return;
    }
    let value = sum / f32(place.record_count + 2u);
    let to = 3u * place.receiver;
    irradiance[to] = value.x;
    irradiance[to + 1u] = value.y;
    irradiance[to + 2u] = value.z;
    store_texel(place.texel, value);
}
