// The glTF 2.0 metallic-roughness model: a Lambertian base under a GGX layer.
//
// Distribution: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007. Masking and
// shadowing: Heitz, "Understanding the Masking-Shadowing Function", JCGT 2014. Fresnel: Schlick, "An Inexpensive
// BRDF Model", 1994. Needs frame.wgsl and material.wgsl.

// Reflectance of a dielectric that is looked at straight on.
const DIELECTRIC = 0.04;

// Below this roughness, highlights of lights without size would be points.
const LEAST_ROUGHNESS = 0.05;

fn diffuse_albedo(surface: Surface) -> vec3f {
    return surface.base_color * (1.0 - surface.metallic);
}

// Reflectance straight on.
fn specular_color(surface: Surface) -> vec3f {
    return mix(vec3f(DIELECTRIC), surface.base_color, surface.metallic);
}

// Share of the irradiance from `to_light` that is reflected to the eye, 1/sr.
fn brdf(surface: Surface, to_light: vec3f) -> vec3f {
    if frame.shading == SHADING_DIFFUSE {
        return surface.base_color / PI;
    }
    let fresnel = fresnel_towards(surface, to_light);
    return (1.0 - fresnel) * diffuse_albedo(surface) / PI + specular_brdf(surface, to_light, 1.0);
}

// The same of the layer alone. A light as wide as a half opening angle of some cosine makes highlights wider by its sine
// (Karis, "Real Shading in Unreal Engine 4", 2013), with as much light in them.
fn specular_brdf(surface: Surface, to_light: vec3f, cosine: f32) -> vec3f {
    let half_way = normalize(to_light + surface.to_eye);
    let n_l = max(dot(surface.normal, to_light), 1e-4);
    let n_v = max(dot(surface.normal, surface.to_eye), 1e-4);
    let n_h = saturate(dot(surface.normal, half_way));
    let width = 0.5 * sqrt(max(1.0 - cosine * cosine, 0.0));
    let alpha = saturate(pow(max(surface.roughness, LEAST_ROUGHNESS), 2.0) + width);
    return fresnel_towards(surface, to_light) * ggx_distribution(n_h, alpha) * ggx_visibility(n_l, n_v, alpha);
}

fn fresnel_towards(surface: Surface, to_light: vec3f) -> vec3f {
    let v_h = saturate(dot(surface.to_eye, normalize(to_light + surface.to_eye)));
    return mix(specular_color(surface), vec3f(1.0), pow(1.0 - v_h, 5.0));
}

fn ggx_distribution(n_h: f32, alpha: f32) -> f32 {
    let squared = alpha * alpha;
    let t = n_h * n_h * (squared - 1.0) + 1.0;
    return squared / (PI * t * t);
}

// Masking and shadowing, divided by 4 (n·l) (n·v).
fn ggx_visibility(n_l: f32, n_v: f32, alpha: f32) -> f32 {
    let squared = alpha * alpha;
    let light = n_v * sqrt(n_l * n_l * (1.0 - squared) + squared);
    let view = n_l * sqrt(n_v * n_v * (1.0 - squared) + squared);
    return 0.5 / (light + view);
}

// Share of evenly distributed light that the layer reflects: Karis' fit of the integral ("Physically Based Shading
// on Mobile", 2014).
fn specular_albedo(surface: Surface) -> vec3f {
    let r = surface.roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let n_v = saturate(dot(surface.normal, surface.to_eye));
    let a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    let scale_and_bias = vec2f(-1.04, 1.04) * a + r.zw;
    return specular_color(surface) * scale_and_bias.x + scale_and_bias.y;
}
