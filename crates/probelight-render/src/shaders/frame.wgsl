// What all shaders of a picture share: camera, sky, lightmap, and which view is drawn.

struct Frame {
    clip_from_world: mat4x4f,
    eye: vec3f,
    // One of the constants below.
    view: u32,
    // From the image's middle to its right border, at unit distance along `forward`.
    right: vec3f,
    // One of the constants below.
    shading: u32,
    // From the image's middle to its upper border, at unit distance along `forward`.
    up: vec3f,
    // Factor on all emission.
    emissive_scale: f32,
    // Unit vector.
    forward: vec3f,
    // Radius of markers, metres.
    marker_radius: f32,
    // Radiance of the sky straight up, at the horizon and straight down, W·m⁻²·sr⁻¹ (xyz).
    zenith: vec4f,
    horizon: vec4f,
    ground: vec4f,
}

const VIEW_FULL = 0u;
const VIEW_DIRECT = 1u;
const VIEW_INDIRECT = 2u;
const VIEW_IRRADIANCE = 3u;
const VIEW_ALBEDO = 4u;
const VIEW_NORMALS = 5u;
const VIEW_LIGHTMAP_TEXELS = 6u;
const VIEW_CLUSTERS = 7u;
const VIEW_PROBES = 8u;
const VIEW_LIGHT_SAMPLES = 9u;

const SHADING_DIFFUSE = 0u;
const SHADING_PHYSICAL = 1u;

@group(1) @binding(0) var<uniform> frame: Frame;
// Irradiance by way of the signals, W/m².
@group(1) @binding(1) var lightmap: texture_2d<f32>;
@group(1) @binding(2) var lightmap_sampler: sampler;
// Colour of each lightmap texel's cluster.
@group(1) @binding(3) var cluster_colors: texture_2d<f32>;

// Corners of the front and the back face of each triangle in the lightmap, texels, in the order of the vertex buffer;
// negative without light of its own.
@group(1) @binding(4) var<storage, read> lightmap_faces: array<array<array<vec2f, 3>, 2>>;

// Corners of each triangle, metres, in the same order: x, y and z of one after the other.
@group(1) @binding(5) var<storage, read> triangle_corners: array<array<array<f32, 3>, 3>>;

const PI: f32 = 3.14159265;
