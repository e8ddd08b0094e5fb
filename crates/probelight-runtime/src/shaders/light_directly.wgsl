// Stage 1, when lights changed: irradiance of the analytic lights on every surfel.
//
//     surfel    │        0        │     1     │
//     points    │0 1 2 3 4 5 6 7 8│9 10 11 12 │

struct LitPoint {
    /// World position on the surface, metres.
    position: vec3f,
    /// Share of the surfel's area that it stands for.
    share: f32,
    /// Unit geometric normal of its side.
    normal: vec3f,
    padding: f32,
}

/// One more than there are surfels.
@group(1) @binding(0) var<storage, read> first_points: array<u32>;
@group(1) @binding(1) var<storage, read> points: array<LitPoint>;
@group(1) @binding(2) var<storage, read_write> direct: array<f32>;

@compute @workgroup_size(64)
fn light_directly(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let surfel = linear_workgroup(workgroup, workgroups) * 64u + local;
    if surfel + 1u >= arrayLength(&first_points) {
        return;
    }
    var sum = vec3f(0.0);
    for (var p = first_points[surfel]; p < first_points[surfel + 1u]; p++) {
        let point = points[p];
        for (var i = 0u; i < lights.count; i++) {
            let light = lights.list[i];
            let arriving = illuminate(light, point.position);
            let cosine = dot(point.normal, arriving.to_light);
            if cosine > 0.0 && any(arriving.irradiance > vec3f(0.0)) {
                let visibility = light_visibility(light, point.position, point.normal);
                sum += arriving.irradiance * (point.share * cosine * visibility);
            }
        }
    }
    direct[3u * surfel] = sum.x;
    direct[3u * surfel + 1u] = sum.y;
    direct[3u * surfel + 2u] = sum.z;
}
