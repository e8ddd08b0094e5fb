// Stage 6: a coarser level of the lightmap from the next finer one.
//
// Texels without light (alpha 0) do not take part, so that charts do not darken towards their borders.

@group(0) @binding(0) var finer: texture_2d<f32>;
@group(0) @binding(1) var coarser: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<storage, read_write> flags: FrameFlags;

@compute @workgroup_size(8, 8)
fn reduce_lightmap(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarser)) || atomicLoad(&flags.any_touched) == 0u {
        return;
    }
    let last = textureDimensions(finer) - 1u;
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let texel = textureLoad(finer, min(2u * id.xy + vec2u(i % 2u, i / 2u), last), 0);
        sum += vec4f(texel.xyz * texel.w, texel.w);
    }
    let has_light = sum.w > 0.0;
    textureStore(coarser, id.xy, select(vec4f(0.0), vec4f(sum.xyz / max(sum.w, 1.0), 1.0), has_light));
}
