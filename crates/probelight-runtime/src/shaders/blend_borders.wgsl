// Second half of stage 4: where clusters blend, the irradiance of a receiver is what its own cluster says of it plus
// what its neighbours do.

struct BlendedReceiver {
    receiver: u32,
    texel: u32,
    /// First of its neighbours' contributions in `sources`.
    first_source: u32,
    source_count: u32,
}

@group(0) @binding(0) var<storage, read> blended: array<BlendedReceiver>;
/// Contributions by receiver: indices into `border_irradiance`.
@group(0) @binding(1) var<storage, read> sources: array<u32>;
/// What clusters say of receivers beyond their borders, W/m².
@group(0) @binding(2) var<storage, read> border_irradiance: array<f32>;
/// Irradiance of all receivers, W/m².
@group(0) @binding(3) var<storage, read_write> irradiance: array<f32>;
@group(0) @binding(4) var lightmap: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(64)
fn blend_borders(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups) * 64u + local;
    if number >= arrayLength(&blended) {
        return;
    }
    let place = blended[number];
    // Short buffers are filled up with zeros.
    if place.source_count == 0u {
        return;
    }
    let to = 3u * place.receiver;
    var sum = vec3f(irradiance[to], irradiance[to + 1u], irradiance[to + 2u]);
    for (var i = place.first_source; i < place.first_source + place.source_count; i++) {
        let at = 3u * sources[i];
        sum += vec3f(border_irradiance[at], border_irradiance[at + 1u], border_irradiance[at + 2u]);
    }
    irradiance[to] = sum.x;
    irradiance[to + 1u] = sum.y;
    irradiance[to + 2u] = sum.z;
    store_texel(place.texel, sum);
}
