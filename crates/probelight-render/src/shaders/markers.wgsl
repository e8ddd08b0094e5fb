// Probes as white spheres in their own light, and light samples as discs as bright as their surfels. Needs
// frame.wgsl.

struct Marker {
    // World position, metres.
    position: vec3f,
    // The surfel's signal, or the probe's first coefficient.
    signal: u32,
    // Unit normal of a light sample's side.
    normal: vec3f,
    // Highest band of a probe, at most 2: higher ones do not show on diffuse spheres.
    degree: u32,
}

@group(2) @binding(0) var<storage, read> markers: array<Marker>;
// Radiance of surfels and coefficients of probes: RGB each, W·m⁻²·sr⁻¹.
@group(2) @binding(1) var<storage, read> signals: array<f32>;

struct MarkerVertex {
    @builtin(position) clip_position: vec4f,
    @location(0) normal: vec3f,
    @location(1) @interpolate(flat) marker: u32,
}

// Triangles around and along a sphere, and around a disc.
const SLICES = 20u;
const STACKS = 10u;

const QUAD_CORNERS = array(vec2u(0u, 0u), vec2u(1u, 0u), vec2u(1u, 1u), vec2u(0u, 0u), vec2u(1u, 1u), vec2u(0u, 1u));

@vertex
fn sphere_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) marker: u32) -> MarkerVertex {
    var corners = QUAD_CORNERS;
    let quad = index / 6u;
    let corner = vec2u(quad % SLICES, quad / SLICES) + corners[index % 6u];
    let longitude = 2.0 * PI * f32(corner.x) / f32(SLICES);
    let latitude = PI * f32(corner.y) / f32(STACKS);
    let normal = vec3f(sin(latitude) * cos(longitude), cos(latitude), sin(latitude) * sin(longitude));
    let position = markers[marker].position + frame.marker_radius * normal;
    return MarkerVertex(frame.clip_from_world * vec4f(position, 1.0), normal, marker);
}

@vertex
fn disc_vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) marker: u32) -> MarkerVertex {
    let normal = markers[marker].normal;
    // Any two axes in the disc's plane will do.
    let helper = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
    let across = normalize(cross(normal, helper));
    let angle = 2.0 * PI * f32(index / 3u + index % 3u - 1u) / f32(SLICES);
    let spoke = cos(angle) * across + sin(angle) * cross(normal, across);
    let offset = select(spoke, vec3f(0.0), index % 3u == 0u);
    // Off the surface, so that the disc is not hidden by it.
    let position = markers[marker].position + frame.marker_radius * (offset + 0.1 * normal);
    return MarkerVertex(frame.clip_from_world * vec4f(position, 1.0), normal, marker);
}

fn signal(number: u32) -> vec3f {
    return vec3f(signals[3u * number], signals[3u * number + 1u], signals[3u * number + 2u]);
}

@fragment
fn disc_color(vertex: MarkerVertex) -> @location(0) vec4f {
    return vec4f(signal(markers[vertex.marker].signal), 1.0);
}

// Radiance of a white diffuse sphere in the probe's light: coefficients times those of the cosine lobe over π
// (1, 2/3, 1/4 by band) times the basis.
@fragment
fn sphere_color(vertex: MarkerVertex) -> @location(0) vec4f {
    let n = normalize(vertex.normal);
    let first = markers[vertex.marker].signal;
    var sum = 0.28209479 * signal(first);
    if markers[vertex.marker].degree >= 1u {
        let band = n.y * signal(first + 1u) + n.z * signal(first + 2u) + n.x * signal(first + 3u);
        sum += 2.0 / 3.0 * 0.48860251 * band;
    }
    if markers[vertex.marker].degree >= 2u {
        let band = n.x * n.y * signal(first + 4u) + n.y * n.z * signal(first + 5u) + n.x * n.z * signal(first + 7u);
        sum += 0.25 * 1.0925484 * band;
        sum += 0.25 * 0.31539157 * (3.0 * n.z * n.z - 1.0) * signal(first + 6u);
        sum += 0.25 * 0.54627422 * (n.x * n.x - n.y * n.y) * signal(first + 8u);
    }
    return vec4f(max(sum, vec3f(0.0)), 1.0);
}
