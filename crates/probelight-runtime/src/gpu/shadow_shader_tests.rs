//! What can be tested of the shadow maps' shader without a GPU.

use super::shaders;
use super::shadow_views::{
    DIRECTIONAL_LIGHT, DIRECTIONAL_VIEWS_PER_SIDE, GUARD_TEXELS, LightRecord, LightsRecord, MAX_SHADOW_VIEWS,
    POINT_LIGHT, SPOT_LIGHT, ShadowViewRecord,
};
use super::wgsl_layout::{compare, constant, fields, parse, write_for_direct3d_and_metal};

#[test]
fn the_shader_is_valid_and_shares_its_structs_and_constants() {
    let module = parse(&shaders::cast_shadows()).unwrap();
    write_for_direct3d_and_metal(&module).unwrap();
    let light = fields!(LightRecord:
        position kind direction first_view intensity cone_scale cos_outer view_count
        inverse_squared_range unused);
    compare(&module, "Light", light, size_of::<LightRecord>()).unwrap();
    let lights = fields!(LightsRecord: list count unused);
    compare(&module, "Lights", lights, size_of::<LightsRecord>()).unwrap();
    let view = fields!(ShadowViewRecord: clip_from_world axis texel_width);
    compare(&module, "ShadowView", view, size_of::<ShadowViewRecord>()).unwrap();
    for (name, value) in [
        ("MAX_LIGHTS", MAX_SHADOW_VIEWS as u32),
        ("MAX_SHADOW_VIEWS", MAX_SHADOW_VIEWS as u32),
        ("DIRECTIONAL_VIEWS_PER_SIDE", DIRECTIONAL_VIEWS_PER_SIDE),
        ("GUARD_TEXELS", GUARD_TEXELS),
        ("DIRECTIONAL_LIGHT", DIRECTIONAL_LIGHT),
        ("POINT_LIGHT", POINT_LIGHT),
        ("SPOT_LIGHT", SPOT_LIGHT),
    ] {
        assert_eq!(constant(&module, name), Some(value), "{name}");
    }
}

#[test]
fn the_comparison_notices_wrong_structs() {
    let view = fields!(ShadowViewRecord: clip_from_world axis texel_width);
    let size = size_of::<ShadowViewRecord>();
    let declared = |body: &str| parse(&format!("struct ShadowView {{ {body} }}")).unwrap();
    let right = declared("clip_from_world: mat4x4f, axis: vec3f, texel_width: f32");
    compare(&right, "ShadowView", view, size).unwrap();
    for wrong in [
        "clip_from_world: mat4x4f, axis: vec3f, width: f32",
        "clip_from_world: mat4x4f, axis: vec4f, texel_width: f32",
        "clip_from_world: mat4x4f, axis: vec3f",
        "axis: vec3f, texel_width: f32, clip_from_world: mat4x4f",
    ] {
        assert!(compare(&declared(wrong), "ShadowView", view, size).is_err(), "{wrong}");
    }
    assert!(compare(&right, "Shadow", view, size).is_err());
    assert!(parse("fn broken() -> f32 { return 1u; }").is_err());
}
