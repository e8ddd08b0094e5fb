// Stage 1, every frame: radiance of the surfels with last frame's irradiance as feedback, where that is new.

/// Number of the shard's first surfel.
@group(0) @binding(0) var<uniform> first_surfel: u32;
/// One more than the shard has surfels.
@group(0) @binding(1) var<storage, read> first_bounces: array<u32>;
@group(0) @binding(2) var<storage, read> bounces: array<Bounce>;
/// Mean radiance of each surfel without feedback.
@group(0) @binding(3) var<storage, read> unbounced: array<f32>;
/// Irradiance of all receivers in the last frame.
@group(0) @binding(4) var<storage, read> irradiance: array<f32>;
@group(0) @binding(5) var<storage, read_write> signals: array<f32>;
/// Of each block of signals, whether its surfels reflect anything new.
@group(0) @binding(6) var<storage, read> dirty: array<u32>;

@compute @workgroup_size(64)
fn light_surfels(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let surfel = linear_workgroup(workgroup, workgroups) * 64u + local;
    if surfel + 1u >= arrayLength(&first_bounces) || dirty[(first_surfel + surfel) / SOURCE_SIGNALS] == 0u {
        return;
    }
    var radiance = vec3f(unbounced[3u * surfel], unbounced[3u * surfel + 1u], unbounced[3u * surfel + 2u]);
    for (var i = first_bounces[surfel]; i < first_bounces[surfel + 1u]; i++) {
        let bounce = bounces[i];
        if bounce.receiver != NONE {
            let at = 3u * bounce.receiver;
            let arriving = vec3f(irradiance[at], irradiance[at + 1u], irradiance[at + 2u]);
            // Truncated matrices can yield slightly negative irradiance, and no surface reflects that.
            radiance += bounce.reflectance * max(arriving, vec3f(0.0));
        }
    }
    let signal = 3u * (first_surfel + surfel);
    signals[signal] = radiance.x;
    signals[signal + 1u] = radiance.y;
    signals[signal + 2u] = radiance.z;
}
