// Stage 1, when a light or a colour changed: what does not depend on feedback.
//
// A surfel's samples are sorted by the receiver whose light they reflect. A run of samples with the same receiver
// is one bounce: one reflectance, one read of the receiver, however many samples there are.
//
//     surfel    │        0        │     1     │
//     bounces   │  0  │ 1 │   2   │   3   │ 4 │
//     samples   │0 1 2│ 3 │4 5 6 7│8 9 10 │11 │

struct SampleColors {
    /// Base colour texture, sRGB-encoded, red in the lowest byte.
    base_color: u32,
    /// Emissive texture, sRGB-encoded; zero on back faces, which do not shine.
    emission: u32,
    material: u32,
}

struct MaterialColors {
    /// Linear base colour factor.
    base_color: vec4f,
    /// Radiance that surfels on it emit, W·m⁻²·sr⁻¹; zero where emitters carry it.
    emission: vec4f,
}

const INVERSE_PI: f32 = 0.31830988618379067;

/// `linear_from_srgb[code / 4][code % 4]`.
@group(0) @binding(0) var<uniform> linear_from_srgb: array<vec4f, 64>;
@group(0) @binding(1) var<storage, read> materials: array<MaterialColors>;
/// One more than there are surfels.
@group(0) @binding(2) var<storage, read> first_bounces: array<u32>;
/// One more than there are bounces.
@group(0) @binding(3) var<storage, read> first_samples: array<u32>;
@group(0) @binding(4) var<storage, read> colors: array<SampleColors>;
/// Irradiance of the analytic lights on each surfel.
@group(0) @binding(5) var<storage, read> direct: array<f32>;
@group(0) @binding(6) var<storage, read_write> bounces: array<Bounce>;
/// Mean radiance of each surfel without feedback.
@group(0) @binding(7) var<storage, read_write> unbounced: array<f32>;

fn decode(code: u32) -> f32 {
    return linear_from_srgb[code >> 2u][code & 3u];
}

fn texel(codes: u32) -> vec3f {
    return vec3f(decode(codes & 255u), decode((codes >> 8u) & 255u), decode((codes >> 16u) & 255u));
}

@compute @workgroup_size(64)
fn shade_surfels(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let surfel = linear_workgroup(workgroup, workgroups) * 64u + local;
    if surfel + 1u >= arrayLength(&first_bounces) {
        return;
    }
    let first_bounce = first_bounces[surfel];
    let end_bounce = first_bounces[surfel + 1u];
    let share = 1.0 / f32(first_samples[end_bounce] - first_samples[first_bounce]);
    let arriving = vec3f(direct[3u * surfel], direct[3u * surfel + 1u], direct[3u * surfel + 2u]);
    var radiance = vec3f(0.0);
    for (var bounce = first_bounce; bounce < end_bounce; bounce++) {
        var reflectance = vec3f(0.0);
        for (var sample = first_samples[bounce]; sample < first_samples[bounce + 1u]; sample++) {
            let material = materials[colors[sample].material];
            radiance += material.emission.xyz * texel(colors[sample].emission);
            reflectance += material.base_color.xyz * texel(colors[sample].base_color) * INVERSE_PI;
        }
        radiance += reflectance * arriving;
        bounces[bounce].reflectance = reflectance * share;
    }
    unbounced[3u * surfel] = radiance.x * share;
    unbounced[3u * surfel + 1u] = radiance.y * share;
    unbounced[3u * surfel + 2u] = radiance.z * share;
}
