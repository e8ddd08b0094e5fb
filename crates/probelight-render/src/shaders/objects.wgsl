// Objects that move through the scene. Needs placements.wgsl, grid.wgsl and all that surface.wgsl needs, and that.

// Each object, in the order of models.
@group(1) @binding(6) var<storage, read> placements: array<Placement>;

struct ObjectVertex {
    @builtin(position) clip_position: vec4f,
    // World position, metres. At the middle of what a triangle covers of a pixel, not outside it.
    @location(0) @interpolate(perspective, centroid) position: vec3f,
    @location(1) @interpolate(perspective, centroid) uv: vec4f,
    @location(2) @interpolate(perspective, centroid) normal: vec3f,
    @location(3) @interpolate(perspective, centroid) tangent: vec4f,
    @location(4) @interpolate(flat) face_normal: vec3f,
}

@vertex
fn object_vertex(
    @location(0) position: vec3f,
    @location(1) uv: vec4f,
    @location(2) normal: vec4f,
    @location(3) tangent: vec4f,
    @location(4) face_normal: vec4f,
    @builtin(instance_index) object: u32,
) -> ObjectVertex {
    let placement = placements[object];
    let placed = placed_point(placement, position);
    return ObjectVertex(
        frame.clip_from_world * vec4f(placed, 1.0),
        placed,
        uv,
        placed_direction(placement, normal.xyz),
        vec4f(placed_direction(placement, tangent.xyz), tangent.w),
        placed_direction(placement, face_normal.xyz),
    );
}

@fragment
fn object_color(vertex: ObjectVertex) -> @location(0) vec4f {
    return vec4f(color_of_object(object_at(vertex)), 1.0);
}

@fragment
fn masked_object_color(vertex: ObjectVertex) -> @location(0) vec4f {
    let surface = object_at(vertex);
    return vec4f(color_of_object(surface), coverage(surface));
}

// Objects are shaded by their vertices' normals even where the scene is not: their light is known for any normal.
fn object_at(vertex: ObjectVertex) -> Surface {
    let corner = SurfaceCorner(vertex.uv, vertex.normal, vertex.tangent, vertex.face_normal);
    var surface = surface_at(corner, vertex.position);
    if frame.shading == SHADING_DIFFUSE {
        surface.normal = normalize(vertex.normal) * surface.side;
    }
    return surface;
}

fn color_of_object(surface: Surface) -> vec3f {
    switch frame.view {
        case VIEW_ALBEDO: { return surface.base_color; }
        case VIEW_NORMALS: { return 0.5 + 0.5 * surface.normal; }
        case VIEW_DIRECT: { return surface.emission + direct_light(surface); }
        // Neither texels nor clusters.
        case VIEW_LIGHTMAP_TEXELS, VIEW_CLUSTERS: { return vec3f(0.1); }
        default: {}
    }
    var light = light_in_air(surface.position, surface.face_normal);
    let irradiance = irradiance_from(&light, surface.normal);
    if frame.view == VIEW_IRRADIANCE {
        return irradiance;
    }
    let reflected = reflected_in_air(surface, &light, irradiance);
    if frame.view == VIEW_INDIRECT {
        return reflected;
    }
    let all = surface.emission + direct_light(surface) + reflected;
    return all * select(1.0, 0.3, frame.view == VIEW_PROBES || frame.view == VIEW_LIGHT_SAMPLES);
}

// What an object reflects of the light in free space. For its gloss the light is taken for a sum of two: that of a lamp where
// the light vector points to ([SED] figure 4), and even light.
fn reflected_in_air(surface: Surface, light: ptr<function, GridLight>, irradiance: vec3f) -> vec3f {
    if frame.shading == SHADING_DIFFUSE {
        return surface.base_color / PI * irradiance;
    }
    let diffuse = diffuse_albedo(surface) / PI * irradiance;
    let to_lamp = light_vector(light);
    let before = irradiance_from(light, to_lamp);
    let behind = irradiance_from(light, -to_lamp);
    let lamp = max(before - behind, vec3f(0.0));
    let mirrored = reflect(-surface.to_eye, surface.normal);
    let towards = max(dot(mirrored, to_lamp), 0.0);
    let even = max(irradiance_from(light, mirrored) - towards * lamp, vec3f(0.0));
    let highlight = max(dot(surface.normal, to_lamp), 0.0) * specular_brdf(surface, to_lamp) * lamp;
    return surface.occlusion * (diffuse + highlight + specular_albedo(surface) / PI * even);
}
