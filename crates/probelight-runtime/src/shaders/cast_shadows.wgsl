// Depth of the surfaces that a light sees. Needs lights.wgsl and shadow_maps.wgsl for their structs, and placements.wgsl;
// draws view `instance_index` of the uniform array, one view a draw call.

fn clip_position(position: vec3f, view: u32) -> vec4f {
    return shadow_views[view].clip_from_world * vec4f(position, 1.0);
}

@vertex
fn cast_opaque(@location(0) position: vec3f, @builtin(instance_index) view: u32) -> @builtin(position) vec4f {
    return clip_position(position, view);
}

// All objects, for each view once more: as many as there are in the instances before those of the view's own.
@group(0) @binding(4) var<storage, read> placements: array<Placement>;
@group(0) @binding(5) var<uniform> object_count: vec4u;

fn object_clip_position(position: vec3f, instance: u32) -> vec4f {
    let object = placements[instance % object_count.x];
    return clip_position(placed_point(object, position), instance / object_count.x);
}

@vertex
fn cast_opaque_object(
    @location(0) position: vec3f,
    @builtin(instance_index) instance: u32,
) -> @builtin(position) vec4f {
    return object_clip_position(position, instance);
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

@vertex
fn cast_masked_object(
    @location(0) position: vec3f,
    @location(1) uv: vec2f,
    @builtin(instance_index) instance: u32,
) -> MaskedVertex {
    return MaskedVertex(object_clip_position(position, instance), uv);
}

@fragment
fn cut_holes(vertex: MaskedVertex) {
    let alpha = alpha_test.factor * textureSampleLevel(alpha_mask, alpha_sampler, vertex.uv, 0.0).x;
    if alpha < alpha_test.cutoff {
        discard;
    }
}
