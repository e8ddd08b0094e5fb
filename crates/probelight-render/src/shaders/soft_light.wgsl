// The light of lightmap and grid on surfaces: all but that of the analytic lights. Needs grid.wgsl, object_spheres.wgsl,
// frame.wgsl, material.wgsl and brdf.wgsl.

// What arrives at a surface, W/m², and what goes on to the eye, W·m⁻²·sr⁻¹.
struct SoftLight {
    irradiance: vec3f,
    reflected: vec3f,
}

// Between directions whose angle has at least this cosine light does not differ: a tenth of a degree.
const SAME_DIRECTION = 1.0 - 1.5e-6;

// Share of the light around a point that is added to both directions where one is held against the other: what is known
// of a direction that gets less is noise of the grid.
const UNCERTAIN_LIGHT = 0.02;

// How much brighter light may become from one direction to another. Bumps of 45° under a lamp 15° above a surface
// reach it.
const MOST_BRIGHTENING = 4.0;

// The light of the lightmap.
fn light_of_lightmap(surface: Surface) -> SoftLight {
    return reflected_evenly(surface, irradiance_of_lightmap(surface));
}

// The same with objects around.
fn light_with_objects(surface: Surface) -> SoftLight {
    let irradiance = irradiance_of_lightmap(surface);
    let objects = object_influence_on_scene(surface.position, surface.face_normal, irradiance);
    return reflected_evenly(surface, irradiance * objects.left + objects.reflected);
}

// The same on a normal map's bumps.
fn light_on_bumps(surface: Surface) -> SoftLight {
    var light = light_above(surface);
    return reflected_evenly(surface, irradiance_on_bumps(surface, &light));
}

// The same of a surface with gloss.
fn light_on_gloss(surface: Surface) -> SoftLight {
    var light = light_above(surface);
    return reflected_with_gloss(surface, &light, irradiance_on_bumps(surface, &light));
}

// Light that counts as coming evenly from all sides.
fn reflected_evenly(surface: Surface, irradiance: vec3f) -> SoftLight {
    var reflectance = surface.base_color;
    if frame.shading == SHADING_PHYSICAL {
        reflectance = diffuse_albedo(surface) + specular_albedo(surface);
    }
    return SoftLight(irradiance, reflectance / PI * surface.occlusion * irradiance);
}

// Light of which the grid tells where it comes from: a lamp in light that is even ([SED] figure 4). `irradiance`
// is what arrives of it.
fn reflected_with_gloss(surface: Surface, light: ptr<function, GridLight>, irradiance: vec3f) -> SoftLight {
    let lamp = lamp_of(light, surface.normal);
    let arriving = irradiance_from(light, surface.normal);
    let of_lamp = min(lamp.flux * max(dot(surface.normal, lamp.direction), 0.0), arriving);
    let even = arriving - of_lamp;
    // The lightmap knows better how much arrives, the grid in which shares.
    let lamp_share = of_lamp / max(arriving, vec3f(1e-30));
    let mirrored = mirrored_direction(surface);
    let of_lamp_there = lamp.flux * max(dot(mirrored, lamp.direction), 0.0);
    let even_there = max(irradiance_from(light, mirrored) - of_lamp_there, vec3f(0.0));
    let all_around = arriving + irradiance_from(light, -surface.normal);
    let seen = (1.0 - lamp_share) * irradiance * limited_ratio(even_there, even, all_around);
    let diffuse = diffuse_albedo(surface) / PI * irradiance;
    let highlight = specular_brdf(surface, lamp.direction, lamp.cosine) * lamp_share * irradiance;
    let glossy = highlight + specular_albedo(surface) / PI * seen;
    return SoftLight(irradiance, surface.occlusion * (diffuse + glossy));
}

// Where most of what a layer reflects comes from: the mirrored eye, the rougher the nearer to the normal (Lagarde and
// de Rousiers, "Moving Frostbite to PBR", 2014).
fn mirrored_direction(surface: Surface) -> vec3f {
    let alpha = surface.roughness * surface.roughness;
    let share = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
    return normalize(mix(surface.normal, reflect(-surface.to_eye, surface.normal), share));
}

// Light in free space on the side of a surface that is seen: on the surface itself it may be that of either side.
fn light_above(surface: Surface) -> GridLight {
    return light_in_air(surface.position + grid.off_surface * surface.face_normal, surface.face_normal);
}

// Irradiance of lightmap and objects, W/m², as a normal map's bumps have it.
fn irradiance_on_bumps(surface: Surface, light: ptr<function, GridLight>) -> vec3f {
    let of_lightmap = irradiance_of_lightmap(surface);
    let objects = object_influence(0u, NO_OBJECT, surface.position, surface.face_normal, of_lightmap, light);
    let irradiance = of_lightmap * objects.left + objects.reflected;
    if dot(surface.normal, surface.smooth_normal) > SAME_DIRECTION {
        return irradiance;
    }
    let on_bumps = irradiance_from(light, surface.normal);
    let without = irradiance_from(light, surface.smooth_normal);
    let all_around = without + irradiance_from(light, -surface.smooth_normal);
    return irradiance * limited_ratio(on_bumps, without, all_around);
}

// Light of one direction against that of another; 1 where neither has any.
fn limited_ratio(light: vec3f, reference: vec3f, all_around: vec3f) -> vec3f {
    let uncertain = 0.5 * UNCERTAIN_LIGHT * all_around + 1e-30;
    return min((light + uncertain) / (reference + uncertain), vec3f(MOST_BRIGHTENING));
}

// Irradiance of the lightmap, W/m². Level 0, as charts lie side by side and coarser levels would blend them.
fn irradiance_of_lightmap(surface: Surface) -> vec3f {
    let uv = surface.lightmap_position / vec2f(textureDimensions(lightmap));
    let texel = textureSampleLevel(lightmap, lightmap_sampler, uv, 0.0).xyz;
    // Compressed matrices can yield slightly negative light.
    return select(max(texel, vec3f(0.0)), vec3f(0.0), surface.lightmap_position.x < 0.0);
}
