// The sky behind the scene. Needs frame.wgsl.

struct SkyVertex {
    @builtin(position) clip_position: vec4f,
    @location(0) ndc: vec2f,
}

// A triangle that covers the image, infinitely far away.
@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> SkyVertex {
    let ndc = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return SkyVertex(vec4f(ndc, 0.0, 1.0), ndc);
}

@fragment
fn sky_color(vertex: SkyVertex) -> @location(0) vec4f {
    let direction = normalize(frame.forward + vertex.ndc.x * frame.right + vertex.ndc.y * frame.up);
    let end = select(frame.ground, frame.zenith, direction.y >= 0.0);
    return vec4f(mix(frame.horizon.xyz, end.xyz, abs(direction.y)), 1.0);
}
