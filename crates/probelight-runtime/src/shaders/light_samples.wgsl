// Stage 1, when lights changed: irradiance of the analytic lights at every light sample.

struct SamplePlace {
    /// World position on the surface, metres.
    position: vec3f,
    padding_a: f32,
    /// Unit geometric normal of the sample's side.
    normal: vec3f,
    padding_b: f32,
}

@group(1) @binding(0) var<storage, read> places: array<SamplePlace>;
@group(1) @binding(1) var<storage, read_write> direct: array<f32>;

@compute @workgroup_size(64)
fn light_samples(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let sample = linear_workgroup(workgroup, workgroups) * 64u + local;
    if sample >= arrayLength(&places) {
        return;
    }
    let place = places[sample];
    var sum = vec3f(0.0);
    for (var i = 0u; i < lights.count; i++) {
        let light = lights.list[i];
        let arriving = illuminate(light, place.position);
        let cosine = dot(place.normal, arriving.to_light);
        if cosine > 0.0 && any(arriving.irradiance > vec3f(0.0)) {
            sum += arriving.irradiance * (cosine * light_visibility(light, place.position, place.normal));
        }
    }
    direct[3u * sample] = sum.x;
    direct[3u * sample + 1u] = sum.y;
    direct[3u * sample + 2u] = sum.z;
}
