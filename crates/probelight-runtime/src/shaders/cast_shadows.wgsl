// Depth of the surfaces that a light sees. Needs lights.wgsl and shadow_maps.wgsl for their structs; draws view
// `instance_index` of the uniform array, one view a draw call.

fn clip_position(position: vec3f, view: u32) -> vec4f {
    return shadow_views[view].clip_from_world * vec4f(position, 1.0);
}

@vertex
fn cast_opaque(@location(0) position: vec3f, @builtin(instance_index) view: u32) -> @builtin(position) vec4f {
    return clip_position(position, view);
}

struct MaskedVertex {
    @builtin(position) clip_position: vec4f,
    @location(0) uv: vec2f,
}

// A masked surface exists where factor · alpha ≥ cutoff.
struct AlphaTest {
    factor: f32,
    cutoff: f32,
    unused: vec2f,
}

@group(1) @binding(0) var<uniform> alpha_test: AlphaTest;
@group(1) @binding(1) var alpha_mask: texture_2d<f32>;
@group(1) @binding(2) var alpha_sampler: sampler;

@vertex
fn cast_masked(
    @location(0) position: vec3f,
    @location(1) uv: vec2f,
    @builtin(instance_index) view: u32,
) -> MaskedVertex {
    return MaskedVertex(clip_position(position, view), uv);
}

@fragment
fn cut_holes(vertex: MaskedVertex) {
    let alpha = alpha_test.factor * textureSampleLevel(alpha_mask, alpha_sampler, vertex.uv, 0.0).x;
    if alpha < alpha_test.cutoff {
        discard;
    }
}
