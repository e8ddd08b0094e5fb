
// Luminance that a surface sends to the eye from the soft light of free space, cd/m².
fn soft_light(in: PbrInput) -> vec3f {
    let position = (scene_from_world * vec4f(in.world_position.xyz, 1.0)).xyz;
    let facing = normalize((scene_from_world * vec4f(in.world_normal, 0.0)).xyz);
    let normal = normalize((scene_from_world * vec4f(in.N, 0.0)).xyz);
    let mirrored = normalize((scene_from_world * vec4f(reflect(-in.V, in.N), 0.0)).xyz);
    // The grid holds E / π.
    var light = light_in_air(position, facing);
    let color = in.material.base_color.rgb;
    let metallic = in.material.metallic;
    let transmission = in.material.specular_transmission;
    let diffuse_color = calculate_diffuse_color(color, metallic, transmission, in.material.diffuse_transmission);
    let diffuse = diffuse_color * irradiance_from(&light, normal);
    let reflectance = calculate_F0(color, metallic, in.material.reflectance);
    let n_dot_v = max(dot(in.N, in.V), 0.0001);
    // Nothing reflects less than two percent; materials with less are meant to have no gloss.
    let has_gloss = saturate(dot(reflectance, vec3f(50.0 * 0.33)));
    let gloss = has_gloss * EnvBRDFApprox(reflectance, F_AB(in.material.perceptual_roughness, n_dot_v));
    return (diffuse + gloss * irradiance_from(&light, mirrored)) * in.diffuse_occlusion;
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    pbr_input.material.base_color = alpha_discard(pbr_input.material, pbr_input.material.base_color);
    var out: FragmentOutput;
    if (pbr_input.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        let soft = soft_light(pbr_input);
        // Everything soft is in the grid: no ambient light, no diffuse light of environment maps on top.
        pbr_input.diffuse_occlusion = vec3f(0.0);
        out.color = apply_pbr_lighting(pbr_input) + vec4f(view.exposure * soft, 0.0);
    } else {
        out.color = pbr_input.material.base_color;
    }
    out.color = main_pass_post_lighting_processing(pbr_input, out.color);
    return out;
}
