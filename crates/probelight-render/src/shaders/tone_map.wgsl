// From radiance to a screen. The curve is that of tone_map.rs.

struct Display {
    // Factor on radiance.
    exposure: f32,
    // 1 for light, which goes through the curve; 0 for colours, which are shown as they are.
    has_curve: u32,
    // 1 if the target stores what it is given, 0 if it encodes linear colours as sRGB itself.
    encodes_srgb: u32,
    // One of the constants below.
    coloring: u32,
    // Pixels left of this one are the other picture's.
    divider: f32,
    // Share of the other picture in the pixels right of it.
    fade: f32,
    // 1 if pixels are marked that are no number, negative or too bright.
    marks: u32,
    unused: u32,
}

const COLORING_NATURAL = 0u;
const COLORING_STOPS = 1u;
const COLORING_DIFFERENCE = 2u;

@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var picture: texture_2d<f32>;
// Of any size.
@group(0) @binding(2) var other_picture: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn display_color(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let own = textureLoad(picture, vec2u(pixel.xy), 0).xyz;
    let scale = vec2f(textureDimensions(other_picture)) / vec2f(textureDimensions(picture));
    let other = textureLoad(other_picture, vec2u(pixel.xy * scale), 0).xyz;
    let radiance = mix(own, other, select(display.fade, 1.0, pixel.x < display.divider));
    var shown = saturate(radiance * display.exposure);
    if display.has_curve == 1u {
        switch display.coloring {
            case COLORING_STOPS: { shown = color_of_stops(luminance(radiance) * display.exposure); }
            case COLORING_DIFFERENCE: { shown = color_of_difference(own, other); }
            default: { shown = filmic(radiance * display.exposure); }
        }
    }
    if display.marks == 1u {
        shown = marked(shown, radiance, pixel.xy);
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

fn luminance(rgb: vec3f) -> f32 {
    return dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
}

// Stops below and above middle grey that have colours of their own.
const STOPS = 6.0;
// What the curve shows as middle grey.
const MIDDLE_GREY: f32 = 0.27;

// From blue six stops below middle grey over green, grey at its place, yellow, to red; black and white beyond.
fn color_of_stops(exposed: f32) -> vec3f {
    let stops = log2(max(exposed, 1e-12) / MIDDLE_GREY);
    if stops < -STOPS { return vec3f(0.0); }
    if stops > STOPS { return vec3f(1.0); }
    // Half a stop around the middle is grey; each stop has one colour, so that one can count.
    if abs(stops) < 0.5 { return vec3f(0.2); }
    return hue((STOPS - round(stops)) / (2.0 * STOPS) * 0.7);
}

// Difference from the other picture, as a share of it, that has the full colour.
const LARGEST_DIFFERENCE = 0.5;

// Red where a picture is brighter than the other, blue where it is darker, black where they are the same.
fn color_of_difference(own: vec3f, other: vec3f) -> vec3f {
    // What is much darker than middle grey differs by nothing that one sees.
    let floor = 0.05 * MIDDLE_GREY / display.exposure;
    let difference = (luminance(own) - luminance(other)) / max(luminance(other), floor);
    let share = clamp(difference / LARGEST_DIFFERENCE, -1.0, 1.0);
    return select(vec3f(0.1, 0.3, 1.0), vec3f(1.0, 0.25, 0.05), share > 0.0) * share * share;
}

fn hue(turn: f32) -> vec3f {
    return saturate(abs(fract(turn + vec3f(1.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0);
}

// Magenta where a pixel is no number, cyan where it is negative, red stripes where all of it is too bright.
fn marked(shown: vec3f, radiance: vec3f, pixel: vec2f) -> vec3f {
    let exponent = bitcast<vec3u>(radiance) & vec3u(0x7f800000u);
    if any(exponent == vec3u(0x7f800000u)) { return vec3f(1.0, 0.0, 1.0); }
    if any(radiance < vec3f(0.0)) { return vec3f(0.0, 1.0, 1.0); }
    if display.has_curve == 1u && all(shown > vec3f(0.995)) && fract((pixel.x + pixel.y) / 8.0) < 0.5 {
        return vec3f(1.0, 0.0, 0.0);
    }
    return shown;
}
