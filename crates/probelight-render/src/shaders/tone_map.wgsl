// From radiance to a screen. The curve is that of tone_map.rs.

struct Display {
    // Factor on radiance.
    exposure: f32,
    // 1 for light, which goes through the curve; 0 for colours, which are shown as they are.
    has_curve: u32,
    // 1 if the target stores what it is given, 0 if it encodes linear colours as sRGB itself.
    encodes_srgb: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var picture: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn display_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(picture, vec2u(pixel.xy), 0).xyz;
    var shown = saturate(radiance * display.exposure);
    if display.has_curve == 1u {
        shown = filmic(radiance * display.exposure);
    }
    if display.encodes_srgb == 1u {
        shown = srgb_from_linear(shown);
    }
    return vec4f(shown, 1.0);
}

const MIX = mat3x3f(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
const UNMIX = mat3x3f(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);

// Stephen Hill's fit of the ACES reference rendering transform.
fn filmic(exposed: vec3f) -> vec3f {
    let v = MIX * clamp(exposed, vec3f(0.0), vec3f(1e6));
    let numerator = v * (v + 0.0245786) - 0.000090537;
    let denominator = v * (0.983729 * v + 0.432951) + 0.238081;
    return saturate(UNMIX * (numerator / denominator));
}

fn srgb_from_linear(linear: vec3f) -> vec3f {
    let high = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, linear * 12.92, linear <= vec3f(0.0031308));
}
