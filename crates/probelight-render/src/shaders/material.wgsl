// A glTF metallic-roughness material, and what a point of a surface is made of. Needs frame.wgsl.

struct Material {
    base_color: vec4f,
    // Radiance of the front face, W·m⁻²·sr⁻¹.
    emission: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    // Smallest alpha that is still surface.
    alpha_cutoff: f32,
    // Bit i is set if texture i uses the second set of texture coordinates.
    second_uv_sets: u32,
}

// Slopes of a normal map that eight bits cannot tell from none: 127 and 128 of 255 stand for a flat surface.
const FLAT_SLOPE = 0.004;

@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var material_sampler: sampler;
@group(2) @binding(2) var base_color_texture: texture_2d<f32>;
@group(2) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(2) @binding(4) var normal_texture: texture_2d<f32>;
@group(2) @binding(5) var occlusion_texture: texture_2d<f32>;
@group(2) @binding(6) var emissive_texture: texture_2d<f32>;

struct SurfaceVertex {
    @builtin(position) clip_position: vec4f,
    // Weights of the triangle's corners.
    @location(0) barycentric: vec3f,
    @location(1) uv: vec4f,
    @location(2) normal: vec3f,
    @location(3) tangent: vec4f,
    @location(4) @interpolate(flat) face_normal: vec3f,
    // Number of the triangle in the vertex buffer.
    @location(5) @interpolate(flat) triangle: u32,
}

// What lies between the corners of a triangle.
struct SurfaceCorner {
    uv: vec4f,
    normal: vec3f,
    tangent: vec4f,
    face_normal: vec3f,
}

// One side of a surface. Normals are unit vectors on the side that is seen.
struct Surface {
    position: vec3f,
    // Unit vector towards the eye.
    to_eye: vec3f,
    // 1 on the front, −1 on the back.
    side: f32,
    face_normal: vec3f,
    // That between the vertices'.
    smooth_normal: vec3f,
    // The same with the normal map's bumps.
    normal: vec3f,
    base_color: vec3f,
    alpha: f32,
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    // Radiance, W·m⁻²·sr⁻¹.
    emission: vec3f,
    // Texels; negative without light of its own.
    lightmap_position: vec2f,
}

fn uv_of(corner: SurfaceCorner, slot: u32) -> vec2f {
    return select(corner.uv.xy, corner.uv.zw, ((material.second_uv_sets >> slot) & 1u) == 1u);
}

// A surface without light of its own, with the normal of its normal map.
fn surface_at(corner: SurfaceCorner, position: vec3f) -> Surface {
    let base_color = material.base_color * textureSample(base_color_texture, material_sampler, uv_of(corner, 0u));
    let roughness_metallic = textureSample(metallic_roughness_texture, material_sampler, uv_of(corner, 1u)).yz;
    let bump = textureSample(normal_texture, material_sampler, uv_of(corner, 2u)).xyz;
    let occlusion = textureSample(occlusion_texture, material_sampler, uv_of(corner, 3u)).x;
    let emissive = textureSample(emissive_texture, material_sampler, uv_of(corner, 4u)).xyz;

    let to_eye = normalize(frame.eye - position);
    let is_back = dot(corner.face_normal, to_eye) < 0.0;

    var surface: Surface;
    surface.position = position;
    surface.to_eye = to_eye;
    surface.side = select(1.0, -1.0, is_back);
    surface.face_normal = normalize(corner.face_normal) * surface.side;
    surface.smooth_normal = normalize(corner.normal) * surface.side;
    surface.normal = shading_normal(corner, bump, surface.face_normal, surface.side);
    surface.base_color = base_color.xyz;
    surface.alpha = base_color.w;
    surface.metallic = material.metallic * roughness_metallic.y;
    surface.roughness = material.roughness * roughness_metallic.x;
    surface.occlusion = occlusion;
    surface.emission = material.emission * emissive * select(frame.emissive_scale, 0.0, is_back);
    surface.lightmap_position = vec2f(-1.0);
    if frame.shading == SHADING_DIFFUSE {
        surface.normal = surface.face_normal;
        surface.occlusion = 1.0;
    }
    return surface;
}

// A surface of the scene.
fn scene_surface(vertex: SurfaceVertex) -> Surface {
    let weights = weights_inside(vertex);
    let corner = SurfaceCorner(vertex.uv, vertex.normal, vertex.tangent, vertex.face_normal);
    var surface = surface_at(corner, position_of(vertex.triangle, weights));
    surface.lightmap_position = lightmap_position(vertex.triangle, u32(surface.side < 0.0), weights);
    return surface;
}

// The share of a pixel that a masked surface covers: the borders of holes are as smooth as other edges.
fn coverage(surface: Surface) -> f32 {
    let change = max(fwidth(surface.alpha), 1e-4);
    return saturate((surface.alpha - material.alpha_cutoff) / change + 0.5);
}

// Weights of the corners, limited to the triangle. A pixel's middle may lie outside a triangle that covers some of its
// samples: in another chart of the lightmap, or behind the next wall, in its shadow. Centroid interpolation is
// meant to prevent that, but Mesa's driver in software (version 22) takes the middle nevertheless.
fn weights_inside(vertex: SurfaceVertex) -> vec3f {
    let inside = max(vertex.barycentric, vec3f(0.0));
    return inside / (inside.x + inside.y + inside.z);
}

// World position, metres.
fn position_of(triangle: u32, weights: vec3f) -> vec3f {
    let corners = triangle_corners[triangle];
    let a = vec3f(corners[0][0], corners[0][1], corners[0][2]);
    let b = vec3f(corners[1][0], corners[1][1], corners[1][2]);
    let c = vec3f(corners[2][0], corners[2][1], corners[2][2]);
    return weights.x * a + weights.y * b + weights.z * c;
}

// Where the light of one side lies, texels.
fn lightmap_position(triangle: u32, side: u32, weights: vec3f) -> vec2f {
    let corners = lightmap_faces[triangle][side];
    return weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
}

// The vertices' normal with the normal map's bumps, on the side that is seen.
fn shading_normal(vertex: SurfaceCorner, bump: vec3f, face_normal: vec3f, side: f32) -> vec3f {
    let normal = normalize(vertex.normal);
    let bitangent = vertex.tangent.w * cross(normal, vertex.tangent.xyz);
    let coded = bump.xy * 2.0 - 1.0;
    let slope = (coded - clamp(coded, vec2f(-FLAT_SLOPE), vec2f(FLAT_SLOPE))) * material.normal_scale;
    let bumped = slope.x * vertex.tangent.xyz + slope.y * bitangent + (bump.z * 2.0 - 1.0) * normal;
    let length = length(bumped);
    return select(face_normal, side * bumped / length, length > 1e-6);
}
