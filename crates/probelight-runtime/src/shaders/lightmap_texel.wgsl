// Writing the irradiance lightmap, a texture named `lightmap`.

/// Largest half float.
const LARGEST: f32 = 65504.0;

/// Stores the irradiance (W/m²) of the texel with index `texel`, and marks it as one that has light.
fn store_texel(texel: u32, value: vec3f) {
    let width = textureDimensions(lightmap).x;
    let limited = clamp(value, vec3f(-LARGEST), vec3f(LARGEST));
    textureStore(lightmap, vec2u(texel % width, texel / width), vec4f(limited, 1.0));
}
