// Surfaces of the scene. Needs lights.wgsl, shadow_maps.wgsl, and soft_light.wgsl with all that it needs.

@vertex
fn surface_vertex(
    @location(0) position: vec3f,
    @location(1) uv: vec4f,
    @location(2) normal: vec4f,
    @location(3) tangent: vec4f,
    @location(4) face_normal: vec4f,
    @builtin(vertex_index) index: u32,
) -> SurfaceVertex {
    let clip_position = frame.clip_from_world * vec4f(position, 1.0);
    let barycentric = vec3f(vec3u(index % 3u) == vec3u(0u, 1u, 2u));
    return SurfaceVertex(
        clip_position, barycentric, uv, normal.xyz, tangent, face_normal.xyz, index / 3u,
    );
}

// A shader for each way to find the soft light: what a picture does not show is not looked up, and drivers in software take
// seconds to compile what looks into the grid. Of masked surfaces, alpha becomes the share of a pixel's samples that are
// covered.

@fragment
fn surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_of_lightmap(surface)), 1.0);
}

@fragment
fn masked_surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_of_lightmap(surface)), coverage(surface));
}

@fragment
fn surface_color_with_objects(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_with_objects(surface)), 1.0);
}

@fragment
fn masked_surface_color_with_objects(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_with_objects(surface)), coverage(surface));
}

@fragment
fn bumpy_surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_on_bumps(surface)), 1.0);
}

@fragment
fn masked_bumpy_surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_on_bumps(surface)), coverage(surface));
}

@fragment
fn glossy_surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_on_gloss(surface)), 1.0);
}

@fragment
fn masked_glossy_surface_color(vertex: SurfaceVertex) -> @location(0) vec4f {
    let surface = scene_surface(vertex);
    return vec4f(color_of_view(surface, light_on_gloss(surface)), coverage(surface));
}

fn color_of_view(surface: Surface, soft: SoftLight) -> vec3f {
    switch frame.view {
        case VIEW_DIRECT: { return surface.emission + direct_light(surface); }
        case VIEW_INDIRECT: { return soft.reflected; }
        case VIEW_IRRADIANCE: { return soft.irradiance; }
        case VIEW_ALBEDO: { return surface.base_color; }
        case VIEW_NORMALS: { return 0.5 + 0.5 * surface.normal; }
        case VIEW_LIGHTMAP_TEXELS: { return texel_of(surface); }
        case VIEW_CLUSTERS: { return cluster_of(surface); }
        default: {}
    }
    let all = surface.emission + direct_light(surface) + soft.reflected;
    return all * select(1.0, 0.3, frame.view == VIEW_PROBES || frame.view == VIEW_LIGHT_SAMPLES);
}

// What a surface reflects of the light that comes straight from the analytic lights.
fn direct_light(surface: Surface) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < lights.count; i++) {
        let light = lights.list[i];
        let arriving = illuminate(light, surface.position);
        let cosine = dot(surface.normal, arriving.to_light);
        let faces_light = dot(surface.face_normal, arriving.to_light) > 0.0 && cosine > 0.0;
        if faces_light && any(arriving.irradiance > vec3f(0.0)) {
            let visible = light_visibility_for_eye(light, surface.position, surface.face_normal);
            sum += visible * cosine * arriving.irradiance * brdf(surface, arriving.to_light);
        }
    }
    return sum;
}

// The lightmap's texels as they are, as a chessboard; blue where a side has none.
fn texel_of(surface: Surface) -> vec3f {
    if surface.lightmap_position.x < 0.0 {
        return vec3f(0.0, 0.0, 0.2);
    }
    let texel = vec2u(surface.lightmap_position);
    let light = max(textureLoad(lightmap, texel, 0).xyz, vec3f(0.0));
    return light * select(1.0, 0.7, ((texel.x + texel.y) & 1u) == 1u);
}

// One colour for each cluster, darker where the surface is seen at a slant; grey without one.
fn cluster_of(surface: Surface) -> vec3f {
    let slant = 0.4 + 0.6 * dot(surface.face_normal, surface.to_eye);
    if surface.lightmap_position.x < 0.0 {
        return vec3f(0.1) * slant;
    }
    return textureLoad(cluster_colors, vec2u(surface.lightmap_position), 0).xyz * slant;
}
