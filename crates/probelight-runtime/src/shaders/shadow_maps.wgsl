// Which share of a light reaches a point. Needs lights.wgsl.
//
// A light sees the scene through one or more views; each is a layer of one texture. Depth is 1 at the light and
// falls with distance, so that the precision of floats lies where it is needed.

const MAX_SHADOW_VIEWS = 256u;

// A directional light's map is divided into this many views along each side.
const DIRECTIONAL_VIEWS_PER_SIDE = 2u;

// Texels along each border of a view that belong to its neighbours: as many as filter and bias reach.
const GUARD_TEXELS = 4u;

struct ShadowView {
    clip_from_world: mat4x4f,
    // Unit vector along which the view looks.
    axis: vec3f,
    // Width of a texel, metres: of a directional light anywhere, of others at one metre along the axis.
    texel_width: f32,
}

@group(0) @binding(1) var<uniform> shadow_views: array<ShadowView, MAX_SHADOW_VIEWS>;
@group(0) @binding(2) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(3) var shadow_sampler: sampler_comparison;

// How far from its position a lookup takes depths into account, texels along the diagonal: √2 · 1½.
const FILTER_REACH = 2.13;

// Share of a texel by which surfaces that face the light must lie off themselves: more than rounding.
const LEAST_BIAS = 0.1;

// Visibility of a light from a point on a surface, 0 to 1; `normal` is the unit geometric normal on the point's
// side. The surface must face the light.
fn light_visibility(light: Light, position: vec3f, normal: vec3f) -> f32 {
    let index = shadow_view_at(light, position);
    let view = shadow_views[index];
    var texel_width = view.texel_width;
    if light.kind != DIRECTIONAL_LIGHT {
        texel_width *= dot(view.axis, position - light.position);
    }
    // A surface whose normal is n departs from the depth at a texel's middle by |n − (n·a) a| per unit along the
    // view's plane, a being the view's axis. Moved that far along n it is nowhere behind itself.
    let slope = length(normal - dot(normal, view.axis) * view.axis);
    let rounding = 1e-6 * max(abs(position.x), max(abs(position.y), abs(position.z)));
    let moved = position + normal * (texel_width * (FILTER_REACH * slope + LEAST_BIAS) + rounding);
    return filtered_visibility(index, view.clip_from_world * vec4f(moved, 1.0));
}

// The view whose layer holds a point.
fn shadow_view_at(light: Light, position: vec3f) -> u32 {
    if light.kind == DIRECTIONAL_LIGHT {
        return light.first_view + directional_view_at(light, position);
    }
    if light.view_count == 1u {
        return light.first_view;
    }
    let offset = position - light.position;
    let size = abs(offset);
    if size.x >= size.y && size.x >= size.z {
        return light.first_view + select(0u, 1u, offset.x < 0.0);
    }
    if size.y >= size.z {
        return light.first_view + select(2u, 3u, offset.y < 0.0);
    }
    return light.first_view + select(4u, 5u, offset.z < 0.0);
}

// The views of a directional light lie side by side. The first one's border without its guard is at `core` in
// its own clip space.
fn directional_view_at(light: Light, position: vec3f) -> u32 {
    let clip = shadow_views[light.first_view].clip_from_world * vec4f(position, 1.0);
    let core = 1.0 - 2.0 * f32(GUARD_TEXELS) / f32(textureDimensions(shadow_maps).x);
    let last = f32(DIRECTIONAL_VIEWS_PER_SIDE - 1u);
    let cell = vec2u(clamp(floor((clip.xy + core) / (2.0 * core)), vec2f(0.0), vec2f(last)));
    return cell.y * DIRECTIONAL_VIEWS_PER_SIDE + cell.x;
}

// Four bilinear comparisons half a texel apart: a quadratic B-spline over three by three texels.
fn filtered_visibility(layer: u32, clip: vec4f) -> f32 {
    let ndc = clip.xyz / clip.w;
    let uv = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
    let half_texel = 0.5 / f32(textureDimensions(shadow_maps).x);
    var sum = 0.0;
    for (var tap = 0u; tap < 4u; tap++) {
        let side = vec2f(f32(tap & 1u), f32(tap >> 1u)) * 2.0 - 1.0;
        let at = uv + side * half_texel;
        sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, at, layer, ndc.z);
    }
    return sum * 0.25;
}
