// Second half of stage 4: receivers beside the borders between clusters. First all are blended from what was gathered,
// then the results take its place.

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

struct BorderBlend {
    receiver: u32,
    /// The next receiver across the border, and the one behind it.
    neighbor: u32,
    beyond: u32,
}

/// Steepest slope that is continued across a border, per texel, as a share of the irradiance: `STEEPEST_SLOPE` of the
/// asset.
const STEEPEST_SLOPE: f32 = 0.25;

@group(0) @binding(0) var<storage, read> border_receivers: array<BorderReceiver>;
@group(0) @binding(1) var<storage, read> records: array<BorderBlend>;
/// Irradiance of all receivers, W/m².
@group(0) @binding(2) var<storage, read_write> irradiance: array<f32>;
/// Blended irradiance of the receivers beside borders, W/m².
@group(0) @binding(3) var<storage, read_write> blended: array<f32>;
@group(0) @binding(4) var lightmap: texture_storage_2d<rgba16float, write>;
/// Of all clusters.
@group(0) @binding(5) var<storage, read> extents: array<ClusterExtent>;

fn is_computed(place: BorderReceiver) -> bool {
    return place.index < extents[place.cluster].receivers;
}

fn gathered(receiver: u32) -> vec3f {
    let at = 3u * receiver;
    return vec3f(irradiance[at], irradiance[at + 1u], irradiance[at + 2u]);
}

/// What the cluster across the border would say.
fn continued(record: BorderBlend) -> vec3f {
    let own = gathered(record.receiver);
    let neighbor = gathered(record.neighbor);
    let beyond = gathered(record.beyond);
    let steepest = STEEPEST_SLOPE * abs(neighbor);
    let continued = neighbor + clamp(neighbor - beyond, -steepest, steepest);
    return clamp(continued, min(min(neighbor, beyond), own), max(max(neighbor, beyond), own));
}

@compute @workgroup_size(64)
fn blend_borders(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups) * 64u + local;
    if number >= arrayLength(&border_receivers) {
        return;
    }
    let place = border_receivers[number];
    if !is_computed(place) {
        return;
    }
    var sum = 2.0 * gathered(place.receiver);
    for (var i = place.first_record; i < place.first_record + place.record_count; i++) {
        sum += continued(records[i]);
    }
    sum /= f32(place.record_count + 2u);
    blended[3u * number] = sum.x;
    blended[3u * number + 1u] = sum.y;
    blended[3u * number + 2u] = sum.z;
}

@compute @workgroup_size(64)
fn store_blended(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups) * 64u + local;
    if number >= arrayLength(&border_receivers) {
        return;
    }
    let place = border_receivers[number];
    if !is_computed(place) {
        return;
    }
    let value = vec3f(blended[3u * number], blended[3u * number + 1u], blended[3u * number + 2u]);
    let to = 3u * place.receiver;
    irradiance[to] = value.x;
    irradiance[to + 1u] = value.y;
    irradiance[to + 2u] = value.z;
    store_texel(place.texel, value);
}
