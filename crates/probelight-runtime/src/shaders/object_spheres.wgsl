// Spheres in place of objects, where these darken and colour soft light. The twin of object_spheres.rs. Needs grid.wgsl.

struct ObjectSphere {
    // World space, metres.
    center: vec3f,
    radius: f32,
    albedo: vec3f,
    // Distance at which it hides nothing any more, metres.
    reach: f32,
    object: u32,
    // How much it darkens what it hides: 1, or 0 where that light is missing without it.
    hides: f32,
    // Whether it is the core of its object: 1 or 0.
    is_core: u32,
    unused: u32,
}

// An emissive surface as it looks from afar.
struct EmissiveDisc {
    // World space, metres.
    center: vec3f,
    // Square metres.
    area: f32,
    // Mean of the unit normals: shorter where the surface is curved, zero if it is closed.
    normal: vec3f,
    padding: f32,
    radiance: vec3f,
    padding_2: f32,
}

const MOST_DISCS = 16u;

struct EmissiveDiscs {
    discs: array<EmissiveDisc, MOST_DISCS>,
    count: u32,
}

@group(3) @binding(6) var<storage, read> object_spheres: array<ObjectSphere>;
@group(3) @binding(7) var<uniform> emissive: EmissiveDiscs;

// Largest cosine of a disc's half opening angle: what is farther away is so large at least.
const SMALLEST_DISC: f32 = 0.9999;

// How far beyond a lamp's edge discs still count, as a share of its half opening angle; and what is added to that, radians.
const EDGE_SHARE: f32 = 0.5;
const EDGE_ANGLE: f32 = 0.1;

// A disc counts less where less light than it would send arrives from about there, or in all on the surface, and nothing from
// this share on.
const HIDDEN_SHARE: f32 = 0.5;

// Share of the reach within which spheres hide all kinds of light, beyond it only that of discs.
const EVEN_REACH: f32 = 0.6666667;

const HALF_TURN: f32 = 3.14159265;

// From this share of the reach on, spheres fade out.
const FADE_FROM: f32 = 0.5;

// Share of the light behind a sphere that it hides; it shows so much more than its part of the object does.
const OPACITY: f32 = 0.5;

// What spheres do not know: the surface of no object.
const NO_OBJECT = 0xFFFFFFFFu;

// What objects make of the soft light on a surface: the share of its irradiance that they leave, and irradiance of what they
// reflect, W/m².
struct ObjectInfluence {
    left: vec3f,
    reflected: vec3f,
}

// On a surface of the scene where `irradiance` arrives without objects, W/m²; its light in free space is looked up where it is
// needed.
fn object_influence_on_scene(position: vec3f, normal: vec3f, irradiance: vec3f) -> ObjectInfluence {
    var first = 0u;
    while first < grid.sphere_count && !is_near(first, NO_OBJECT, position) {
        first++;
    }
    if first == grid.sphere_count || grid.rows == 0u {
        return ObjectInfluence(vec3f(1.0), vec3f(0.0));
    }
    var light = light_in_air(position, normal);
    return object_influence(first, NO_OBJECT, position, normal, irradiance, &light);
}

// Whether a sphere may hide any light from a point; far away, that of one of the discs.
fn is_near(index: u32, own: u32, position: vec3f) -> bool {
    let sphere = object_spheres[index];
    let offset = sphere.center - position;
    let squared = dot(offset, offset);
    if sphere.object == own || squared >= sphere.reach * sphere.reach {
        return false;
    }
    let even_reach = EVEN_REACH * sphere.reach;
    if squared < even_reach * even_reach {
        return true;
    }
    for (var i = 0u; i < emissive.count; i++) {
        let to_disc = emissive.discs[i].center - position;
        let along = dot(offset, to_disc) / dot(to_disc, to_disc);
        // Patches count as if the disc was as large as they are, at least.
        let width = 2.0 * sphere.radius + along * sqrt(emissive.discs[i].area / HALF_TURN);
        let beside = offset - along * to_disc;
        if along > 0.0 && along < 1.0 && dot(beside, beside) < width * width {
            return true;
        }
    }
    return false;
}

// That of the spheres from the first one on. `own` is the object that the surface belongs to; without objects `irradiance`
// arrives, of `light`.
fn object_influence(
    first: u32,
    own: u32,
    position: vec3f,
    normal: vec3f,
    irradiance: vec3f,
    light: ptr<function, GridLight>,
) -> ObjectInfluence {
    var lamps: array<Lamp, 3>;
    // Half opening angle of each lamp.
    var widths = vec3f(0.0);
    var any_near = false;
    var hidden = 0.0;
    // Of each lamp.
    var lamps_left = vec3f(1.0);
    // By patches, and by the core.
    var lamps_hidden = vec3f(0.0);
    var lamps_behind = vec3f(0.0);
    var reflected = vec3f(0.0);
    // Of one object: its spheres follow each other.
    var object = NO_OBJECT;
    var albedo = vec3f(0.0);
    var from_object = vec3f(0.0);
    for (var i = first; i < grid.sphere_count; i++) {
        if !is_near(i, own, position) {
            continue;
        }
        if !any_near {
            any_near = true;
            lamps = told_apart(lamp_of(light, normal), position, normal, irradiance);
            widths = acos(vec3f(lamps[0].cosine, lamps[1].cosine, lamps[2].cosine));
        }
        let sphere = object_spheres[i];
        if sphere.object != object {
            reflected += reflected_by(light, albedo, from_object);
            lamps_left *= max(1.0 - max(lamps_hidden, lamps_behind), vec3f(0.0));
            lamps_hidden = vec3f(0.0);
            lamps_behind = vec3f(0.0);
            object = sphere.object;
            albedo = vec3f(0.0);
            from_object = vec3f(0.0);
        }
        let offset = sphere.center - position;
        let distance = max(length(offset), 1e-30);
        let direction = offset / distance;
        let disc_fade = 1.0 - smoothstep(FADE_FROM, 1.0, distance / sphere.reach);
        let even_fade = 1.0 - smoothstep(FADE_FROM, 1.0, distance / (EVEN_REACH * sphere.reach));
        let radii = max(distance / max(sphere.radius, 1e-30), 1.0);
        let angle = asin(1.0 / radii);
        for (var k = 0u; k < 3u; k++) {
            let lamp = widths[k];
            let between = acos(clamp(dot(lamps[k].direction, direction), -1.0, 1.0));
            if all(lamps[k].flux == vec3f(0.0)) || between >= max(lamp, angle) + angle {
                continue;
            }
            // The third is what is not known as a disc.
            let fade = select(even_fade, disc_fade, k < 2u);
            if sphere.is_core == 1u {
                // What it does to wide lamps, patches know better.
                let narrow = 1.0 - smoothstep(0.5, 1.0, lamp / angle);
                lamps_behind[k] = sphere.hides * fade * narrow * covered_share(lamp, angle, between);
            } else {
                // To a patch no lamp is smaller than itself: between the patches there would be light.
                let covered = covered_share(max(lamp, angle), angle, between);
                lamps_hidden[k] += sphere.hides * OPACITY * fade * covered;
            }
        }
        if sphere.is_core == 0u {
            let share = OPACITY * even_fade * sphere_form_factor(radii, dot(normal, direction));
            hidden += sphere.hides * share;
            albedo += share * sphere.albedo;
            from_object += share * direction;
        }
    }
    reflected += reflected_by(light, albedo, from_object);
    lamps_left *= max(1.0 - max(lamps_hidden, lamps_behind), vec3f(0.0));
    var of_lamps = vec3f(0.0);
    var left = vec3f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let of_lamp = lamp_irradiance(lamps[k], normal);
        of_lamps += of_lamp;
        left += of_lamp * lamps_left[k];
    }
    let everything = max(max(irradiance_from(light, normal), of_lamps), vec3f(1e-30));
    left += (everything - of_lamps) * max(1.0 - hidden, 0.0);
    return ObjectInfluence(left / everything, reflected);
}

fn lamp_irradiance(lamp: Lamp, normal: vec3f) -> vec3f {
    return lamp.flux * (0.5 * (1.0 + lamp.cosine) * max(dot(normal, lamp.direction), 0.0));
}

// What a disc is to a point, if nothing stands between.
fn lamp_of_disc(disc: EmissiveDisc, position: vec3f) -> Lamp {
    let offset = disc.center - position;
    let squared = max(dot(offset, offset), 1e-12);
    let direction = offset / sqrt(squared);
    // What is closed shows a quarter of its area from anywhere.
    let shown = disc.area * (max(-dot(disc.normal, direction), 0.0) + 0.25 * max(1.0 - length(disc.normal), 0.0));
    let cosine = min(sqrt(squared / (squared + shown / HALF_TURN)), SMALLEST_DISC);
    return Lamp(direction, cosine, disc.radiance * min(shown / squared, 2.0 * HALF_TURN * (1.0 - cosine)));
}

// Whether what arrives may be that of a disc, from 0 to 1.
fn seen(arriving: vec3f, sent: vec3f) -> f32 {
    return smoothstep(HIDDEN_SHARE, 1.0, grid_luminance(arriving) / max(grid_luminance(sent), 1e-30));
}

// The lamp that was found in the light around a point, told apart into the two discs that do most of it there, and the rest.
fn told_apart(found: Lamp, position: vec3f, normal: vec3f, irradiance: vec3f) -> array<Lamp, 3> {
    let none = Lamp(found.direction, found.cosine, vec3f(0.0));
    var first = none;
    var second = none;
    var strengths = vec2f(0.0);
    let width = acos(found.cosine);
    for (var i = 0u; i < emissive.count; i++) {
        var lamp = lamp_of_disc(emissive.discs[i], position);
        let beyond = acos(clamp(dot(found.direction, lamp.direction), -1.0, 1.0)) - width;
        let gate = 1.0 - smoothstep(0.0, EDGE_SHARE * width + EDGE_ANGLE, beyond);
        let is_seen = seen(found.flux, lamp.flux) * seen(irradiance, lamp_irradiance(lamp, normal));
        lamp.flux = min(lamp.flux * (gate * is_seen), found.flux);
        let strength = grid_luminance(lamp_irradiance(lamp, normal));
        if strength > strengths.x {
            second = first;
            first = lamp;
            strengths = vec2f(strength, strengths.x);
        } else if strength > strengths.y {
            second = lamp;
            strengths.y = strength;
        }
    }
    let share = min(found.flux / max(first.flux + second.flux, vec3f(1e-30)), vec3f(1.0));
    first.flux *= share;
    second.flux *= share;
    let rest = max(found.flux - first.flux - second.flux, vec3f(0.0));
    return array<Lamp, 3>(first, second, Lamp(found.direction, found.cosine, rest));
}

// Irradiance of what the side of an object reflects that faces the surface.
fn reflected_by(light: ptr<function, GridLight>, albedo: vec3f, from_object: vec3f) -> vec3f {
    let length = length(from_object);
    if length == 0.0 {
        return vec3f(0.0);
    }
    return albedo * irradiance_from(light, -from_object / length);
}

// The share of a disc in the sky that another covers; half opening angles and the angle between them.
fn covered_share(lamp: f32, sphere: f32, between: f32) -> f32 {
    let inner = abs(lamp - sphere);
    let outer = lamp + sphere;
    let t = saturate((between - inner) / max(outer - inner, 1e-6));
    let areas = vec2f(1.0 - cos(lamp), 1.0 - cos(sphere));
    return (1.0 - t * t * (3.0 - 2.0 * t)) * min(areas.y / max(areas.x, 1e-9), 1.0);
}

// Form factor of a sphere whose middle is `radii` of its radii away, at an angle of the given cosine to the normal.
fn sphere_form_factor(radii: f32, cosine: f32) -> f32 {
    let squared = max(radii * radii, 1.0 + 1e-4);
    let above = 1.0 - squared * cosine * cosine;
    if above <= 0.0 {
        return max(cosine, 0.0) / squared;
    }
    let outside = squared - 1.0;
    let sine_squared = max(1.0 - cosine * cosine, 1e-6);
    let angle = acos(clamp(-cosine * sqrt(outside / sine_squared), -1.0, 1.0));
    let cut = (cosine * angle - sqrt(above * outside)) / squared + atan(sqrt(above / outside));
    return max(cut, 0.0) / HALF_TURN;
}
