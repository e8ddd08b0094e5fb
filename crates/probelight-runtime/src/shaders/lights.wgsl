// Analytic lights. Units are radiometric, per linear Rec. 709 channel; positions and directions in world space.

// As many as there can be shadow maps.
const MAX_LIGHTS = 256u;

const DIRECTIONAL_LIGHT = 0u;
const POINT_LIGHT = 1u;
const SPOT_LIGHT = 2u;

struct Light {
    // Metres; unused for directional lights.
    position: vec3f,
    // One of the constants above.
    kind: u32,
    // Unit vector along which the light travels; the axis of a spot.
    direction: vec3f,
    // The light's first shadow map.
    first_view: u32,
    // Radiant intensity, W/sr; for directional lights irradiance on a surface that faces them, W/m².
    intensity: vec3f,
    // 1 / (cosine of the inner angle − cosine of the outer angle) of a spot.
    cone_scale: f32,
    // Cosine of a spot's outer angle.
    cos_outer: f32,
    // How many shadow maps the light has.
    view_count: u32,
    // 1 / range², 1/m²; 0 for light without end.
    inverse_squared_range: f32,
    // The first of its shadow maps that are fitted to the view of the eye, or NO_VIEW.
    eye_view: u32,
}

struct Lights {
    list: array<Light, MAX_LIGHTS>,
    count: u32,
}

// What a point receives from one light, before any shadow.
struct Illumination {
    // Unit vector towards the light.
    to_light: vec3f,
    // Irradiance on a surface that faces the light, W/m²; black where the light does not shine.
    irradiance: vec3f,
}

@group(0) @binding(0) var<uniform> lights: Lights;

fn illuminate(light: Light, position: vec3f) -> Illumination {
    if light.kind == DIRECTIONAL_LIGHT {
        return Illumination(-light.direction, light.intensity);
    }
    let offset = light.position - position;
    let squared = dot(offset, offset);
    if squared == 0.0 {
        return Illumination(vec3f(0.0, 1.0, 0.0), vec3f(0.0));
    }
    let to_light = offset * inverseSqrt(squared);
    // Light of a range ends there: the window of KHR_lights_punctual.
    let share = squared * light.inverse_squared_range;
    var attenuation = max(1.0 - share * share, 0.0);
    if light.kind == SPOT_LIGHT {
        let falloff = saturate((dot(light.direction, -to_light) - light.cos_outer) * light.cone_scale);
        attenuation *= falloff * falloff;
    }
    return Illumination(to_light, light.intensity * (attenuation / squared));
}
