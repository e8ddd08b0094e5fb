// Objects that move through the scene. Needs placements.wgsl and surface.wgsl with all that it needs.

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
    @location(5) @interpolate(flat) number: u32,
    @location(6) @interpolate(flat) light_offset: f32,
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
        placement.number,
        placement.light_offset,
    );
}

@fragment
fn object_color(vertex: ObjectVertex) -> @location(0) vec4f {
    return vec4f(color_of_object(object_at(vertex), vertex.number, vertex.light_offset), 1.0);
}

@fragment
fn masked_object_color(vertex: ObjectVertex) -> @location(0) vec4f {
    let surface = object_at(vertex);
    return vec4f(color_of_object(surface, vertex.number, vertex.light_offset), coverage(surface));
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

fn color_of_object(surface: Surface, number: u32, light_offset: f32) -> vec3f {
    switch frame.view {
        case VIEW_ALBEDO: { return surface.base_color; }
        case VIEW_NORMALS: { return 0.5 + 0.5 * surface.normal; }
        case VIEW_DIRECT: { return surface.emission + direct_light(surface); }
        // Neither texels nor clusters.
        case VIEW_LIGHTMAP_TEXELS, VIEW_CLUSTERS: { return vec3f(0.1); }
        default: {}
    }
    var light = light_in_air(surface.position + light_offset * surface.face_normal, surface.face_normal);
    let alone = irradiance_from(&light, surface.normal);
    let others = object_influence(0u, number, surface.position, surface.normal, alone, &light);
    let irradiance = alone * others.left + others.reflected;
    if frame.view == VIEW_IRRADIANCE {
        return irradiance;
    }
    var reflected = surface.base_color / PI * irradiance;
    if frame.shading == SHADING_PHYSICAL {
        reflected = reflected_with_gloss(surface, &light, irradiance).reflected;
    }
    if frame.view == VIEW_INDIRECT {
        return reflected;
    }
    let all = surface.emission + direct_light(surface) + reflected;
    return all * select(1.0, 0.3, frame.view == VIEW_PROBES || frame.view == VIEW_LIGHT_SAMPLES);
}
