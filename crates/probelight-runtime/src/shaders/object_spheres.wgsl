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
    unused: array<u32, 2>,
}

@group(3) @binding(6) var<storage, read> object_spheres: array<ObjectSphere>;

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

// On a surface of the scene whose light in free space is looked up where it is needed.
fn object_influence_on_scene(position: vec3f, normal: vec3f) -> ObjectInfluence {
    var first = 0u;
    while first < grid.sphere_count && !is_near(first, NO_OBJECT, position) {
        first++;
    }
    if first == grid.sphere_count || grid.rows == 0u {
        return ObjectInfluence(vec3f(1.0), vec3f(0.0));
    }
    var light = light_in_air(position, normal);
    return object_influence(first, NO_OBJECT, position, normal, &light);
}

fn is_near(index: u32, own: u32, position: vec3f) -> bool {
    let offset = object_spheres[index].center - position;
    let reach = object_spheres[index].reach;
    return object_spheres[index].object != own && dot(offset, offset) < reach * reach;
}

// That of the spheres from the first one on. `own` is the object that the surface belongs to, `light` the light there
// without objects.
fn object_influence(
    first: u32,
    own: u32,
    position: vec3f,
    normal: vec3f,
    light: ptr<function, GridLight>,
) -> ObjectInfluence {
    var lamp = Lamp(normal, 0.0, vec3f(0.0));
    var any_near = false;
    var hidden = 0.0;
    var lamp_left = 1.0;
    var lamp_hidden = 0.0;
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
            lamp = lamp_of(light, normal);
        }
        let sphere = object_spheres[i];
        if sphere.object != object {
            reflected += reflected_by(light, albedo, from_object);
            lamp_left *= max(1.0 - lamp_hidden, 0.0);
            lamp_hidden = 0.0;
            object = sphere.object;
            albedo = vec3f(0.0);
            from_object = vec3f(0.0);
        }
        let offset = sphere.center - position;
        let distance = max(length(offset), 1e-30);
        let direction = offset / distance;
        let strength = OPACITY - OPACITY * smoothstep(FADE_FROM, 1.0, distance / sphere.reach);
        let radii = max(distance / max(sphere.radius, 1e-30), 1.0);
        let share = strength * sphere_form_factor(radii, dot(normal, direction));
        hidden += sphere.hides * share;
        albedo += share * sphere.albedo;
        from_object += share * direction;
        let between = acos(clamp(dot(lamp.direction, direction), -1.0, 1.0));
        lamp_hidden += sphere.hides * strength * covered_share(acos(lamp.cosine), asin(1.0 / radii), between);
    }
    reflected += reflected_by(light, albedo, from_object);
    lamp_left *= max(1.0 - lamp_hidden, 0.0);
    let all = max(irradiance_from(light, normal), vec3f(1e-30));
    let of_lamp = min(lamp.flux * max(dot(normal, lamp.direction), 0.0) / all, vec3f(1.0));
    return ObjectInfluence(of_lamp * lamp_left + (1.0 - of_lamp) * max(1.0 - hidden, 0.0), reflected);
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
    return (1.0 - t * t * (3.0 - 2.0 * t)) * min((1.0 - cos(sphere)) / (1.0 - cos(lamp)), 1.0);
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
    return max(cut, 0.0) / 3.14159265;
}
