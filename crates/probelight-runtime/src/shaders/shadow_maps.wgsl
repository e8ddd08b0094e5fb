// Which share of a light reaches a point. Needs lights.wgsl.
//
// A light sees the scene through one or more views; each is a layer of one texture. Depth is 1 at the light and
// falls with distance, so that the precision of floats lies where it is needed.

const MAX_SHADOW_VIEWS = 256u;

// Views for an eye come behind all others; they are the layers of a texture of their own.
const MAX_EYE_VIEWS = 12u;

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

@group(0) @binding(1) var<uniform> shadow_views: array<ShadowView, MAX_SHADOW_VIEWS + MAX_EYE_VIEWS>;
@group(0) @binding(2) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(3) var eye_shadow_maps: texture_depth_2d_array;

// How far from its position a lookup compares depths, texels along the diagonal: √2 · 1½.
const FILTER_REACH = 2.13;

// Surfaces are lifted off themselves by this share of a texel: more than rounding.
const LEAST_BIAS = 0.15;

// Steepest slope of depth that lookups follow. Along steeper ones a texel's step sideways would be a long one on the
// surface, through walls.
const STEEPEST = 1.0;

// What is nearer than this to a point, along the light's axis and in texels, touches the point's surface rather than
// casts a shadow on it from afar.
const CONTACT_RANGE = 4.0;

// A point against a wall is lit if at least this share of the texels around the foot of the wall is.
const LIT_SHARE_AT_WALLS = 0.25;

// A light has so many views that are fitted to the view of the eye, from fine to coarse, or none; and what stands for
// none.
const EYE_VIEWS = 2u;
const NO_VIEW = 0xffffffffu;

// Where a fine view gives way to a coarser one: share of its half width.
const EYE_BLEND = 0.15;

// Visibility of a light from a point on a surface, 0 to 1; `normal` is the unit geometric normal on the point's
// side. The surface must face the light.
fn light_visibility(light: Light, position: vec3f, normal: vec3f) -> f32 {
    let view = shadow_view_at(light, position);
    return visibility_in(shadow_maps, view, view, light, position, normal);
}

// The same from views that are fitted to the view of the eye, as far as they reach: for pictures. What lights the scene
// must not depend on who looks.
fn light_visibility_for_eye(light: Light, position: vec3f, normal: vec3f) -> f32 {
    if light.eye_view == NO_VIEW {
        return light_visibility(light, position, normal);
    }
    let core = 1.0 - 2.0 * f32(GUARD_TEXELS) / f32(textureDimensions(eye_shadow_maps).x);
    var visibility = 0.0;
    // Share of the views that are still to be asked.
    var left = 1.0;
    for (var i = 0u; i < EYE_VIEWS; i++) {
        let layer = light.eye_view + i;
        let view = MAX_SHADOW_VIEWS + layer;
        let clip = shadow_views[view].clip_from_world * vec4f(position, 1.0);
        // What lies behind a lamp's window is far outside.
        let from_middle = max(abs(clip.x), abs(clip.y)) / max(clip.w, 1e-6);
        let share = left * saturate((core - from_middle) / EYE_BLEND);
        if share > 0.0 {
            visibility += share * visibility_in(eye_shadow_maps, layer, view, light, position, normal);
            left -= share;
        }
    }
    if left > 0.0 {
        visibility += left * light_visibility(light, position, normal);
    }
    return visibility;
}

// Visibility in one of a light's views, which is a layer of some maps.
fn visibility_in(
    maps: texture_depth_2d_array,
    layer: u32,
    index: u32,
    light: Light,
    position: vec3f,
    normal: vec3f,
) -> f32 {
    let view = shadow_views[index];
    var texel_width = view.texel_width;
    if light.kind != DIRECTIONAL_LIGHT {
        texel_width *= dot(view.axis, position - light.position);
    }
    let towards = -dot(normal, view.axis);
    let sideways = normal + towards * view.axis;
    let tilt = length(sideways);
    var followed = normal;
    var bias = LEAST_BIAS;
    if tilt > STEEPEST * towards {
        // What a slope is too steep by, the surface is moved along its normal: far enough that it is nowhere behind
        // itself.
        followed = STEEPEST / tilt * sideways - view.axis;
        bias += FILTER_REACH * min(tilt - STEEPEST * towards, tilt);
    }
    let rounding = 1e-6 * max(abs(position.x), max(abs(position.y), abs(position.z)));
    let lifted = position + normal * (texel_width * bias + rounding);
    let contact = lifted - view.axis * (CONTACT_RANGE * texel_width);
    return filtered_visibility(maps, layer, index, lifted, normalize(followed), contact);
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

// A quadratic B-spline over three by three texels.
//
// Each texel is compared with the depth that the surface's plane has at the texel's own middle, where the map has its
// depth too. So a flat surface does not shadow itself, and need not be moved far off itself, which would
// make the shadows of small ledges vanish.
//
// In a corner some texels hold the other wall, in front of where the plane would go on behind it. They say little about
// the point's own surface, so texels between the plane and the depth of `contact` are left out, as long as enough others
// are lit. Otherwise all corners would be darkened.
fn filtered_visibility(
    maps: texture_depth_2d_array,
    layer: u32,
    index: u32,
    position: vec3f,
    normal: vec3f,
    contact: vec3f,
) -> f32 {
    let clip_from_world = shadow_views[index].clip_from_world;
    let clip = clip_from_world * vec4f(position, 1.0);
    let ndc = clip.xyz / clip.w;
    let contact_clip = clip_from_world * vec4f(contact, 1.0);
    let contact_depth = contact_clip.z / contact_clip.w;
    let resolution = f32(textureDimensions(maps).x);
    let texel = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * resolution;
    let slope = depth_slope(index, clip, normal) * vec2f(2.0, -2.0) / resolution;
    let middle = floor(texel);
    // From the middle of the nearest texel.
    let offset = texel - middle - 0.5;
    let weights_x = spline_weights(offset.x);
    let weights_y = spline_weights(offset.y);
    var lit = 0.0;
    var touching = 0.0;
    var shadowed = 0.0;
    for (var tap = 0u; tap < 9u; tap++) {
        let step = vec2f(f32(tap % 3u), f32(tap / 3u)) - 1.0;
        let at = vec2u(clamp(middle + step, vec2f(0.0), vec2f(resolution - 1.0)));
        let depth = ndc.z + dot(slope, step - offset);
        let nearest = textureLoad(maps, at, layer, 0);
        let weight = weights_x[tap % 3u] * weights_y[tap / 3u];
        if depth >= nearest {
            lit += weight;
        } else if contact_depth >= nearest {
            touching += weight;
        } else {
            shadowed += weight;
        }
    }
    if lit == 0.0 {
        return 0.0;
    }
    return lit / (lit + shadowed) * saturate(lit / (LIT_SHARE_AT_WALLS * (lit + touching)));
}

// Weights of the texel before, the nearest and the texel after, at −½ to ½ from the nearest one's middle.
fn spline_weights(offset: f32) -> array<f32, 3> {
    let before = 0.5 - offset;
    let after = 0.5 + offset;
    return array(0.5 * before * before, 0.75 - offset * offset, 0.5 * after * after);
}

// Change of depth along x and y of normalised device coordinates, in the plane with a unit normal. Projections keep
// planes, so it is the same everywhere in the plane.
fn depth_slope(index: u32, clip: vec4f, normal: vec3f) -> vec2f {
    let helper = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
    let across = normalize(cross(normal, helper));
    let plane = cross(ndc_change(index, clip, across), ndc_change(index, clip, cross(normal, across)));
    // Seen edge-on there is no slope; any steep one will do.
    return -plane.xy / select(plane.z, 1e-20, abs(plane.z) < 1e-20);
}

// How normalised device coordinates change when a point moves in `direction`, but for a factor.
fn ndc_change(index: u32, clip: vec4f, direction: vec3f) -> vec3f {
    let change = shadow_views[index].clip_from_world * vec4f(direction, 0.0);
    return change.xyz * clip.w - clip.xyz * change.w;
}
