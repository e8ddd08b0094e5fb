//! Valid files with parts that light has no use for, and extensions that are read, left out or refused.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use glb::{F32, Glb, U8, warned};
use probelight_math::glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

/// A triangle with a material of 40 % albedo that has an extension, which the file requires.
fn with_material_extension(name: &str, extension: &Value) -> Glb {
    let mut glb = Glb::triangle();
    glb.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorFactor": [0.4, 0.4, 0.4, 1], "metallicFactor": 1},
        "extensions": {name: extension}
    }]);
    glb.primitive()["material"] = json!(0);
    require(&mut glb, name);
    glb
}

fn require(glb: &mut Glb, name: &str) {
    glb.json["extensionsUsed"] = json!([name]);
    glb.json["extensionsRequired"] = json!([name]);
}

fn error_of(glb: &Glb) -> String {
    glb.load().map(|_| "accepted".to_owned()).unwrap_or_else(|error| error.to_string())
}

#[test]
fn parts_that_light_has_no_use_for_are_passed_over() {
    let mut glb = Glb::triangle();
    let numbers = glb.push_accessor(F32, "SCALAR", 3, &[0; 12]);
    for attribute in ["_TEMPERATURE", "_FEATURE_ID_0", "_feature_id", "TEXCOORD_7", "JOINTS_0"] {
        glb.primitive()["attributes"][attribute] = json!(numbers);
    }
    let pointer = json!({"KHR_animation_pointer": {"pointer": "/materials/0/emissiveFactor"}});
    glb.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": pointer}}],
        "samplers": [{"input": numbers, "output": numbers, "interpolation": "SLERP"}]
    }]);
    glb.push("scenes", json!({"name": "empty"}));
    glb.json["samplers"] = json!([{"minFilter": 1, "wrapT": 33071}]);
    glb.json["bufferViews"][0]["target"] = json!(7);
    glb.json["bufferViews"][0]["byteStride"] = json!(0);
    assert_eq!(glb.load().unwrap().corners(0), Glb::triangle().load().unwrap().corners(0));
}

#[test]
fn accessors_without_data_are_zeros() {
    let mut glb = Glb::triangle();
    let zeros = glb.push("accessors", json!({"componentType": F32, "count": 3, "type": "VEC2"}));
    glb.primitive()["attributes"]["TEXCOORD_0"] = json!(zeros);
    assert_eq!(glb.load().unwrap().uv0, [Vec2::ZERO; 3]);

    glb.json["accessors"][0] = json!({"componentType": F32, "count": 1_000_000_000, "type": "VEC3"});
    assert!(error_of(&glb).contains("has no data for them"));
}

#[test]
fn marks_and_padding_around_the_json_do_no_harm() {
    let mut glb = Glb::triangle();
    let data = "AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA";
    glb.json["buffers"] = json!([{"byteLength": 42, "uri": format!("data:;base64,{data}")}]);
    let text = glb.json.to_string();
    for text in [format!("\u{feff}{text}"), format!("{text}\0\0\0")] {
        assert_eq!(glb::load_bytes(text.as_bytes()).unwrap().triangles.len(), 1);
    }
    assert!(glb::load_bytes(format!("{text}x").as_bytes()).is_err());
}

#[test]
fn required_extensions_of_materials_are_left_out_with_a_warning() {
    for name in ["KHR_materials_transmission", "KHR_materials_clearcoat", "KHR_materials_variants"] {
        let scene = with_material_extension(name, &json!({})).load().unwrap();
        assert_eq!(warned(&scene, name), 1, "{:?}", scene.warnings);
        assert!(scene.albedo(0, Vec2::ZERO).abs_diff_eq(Vec3::splat(0.4), 1e-6));
        assert_eq!(scene.materials[0].metallic, 1.0, "{name}");
    }
}

#[test]
fn unlit_materials_are_diffuse() {
    let scene = with_material_extension("KHR_materials_unlit", &json!({})).load().unwrap();
    assert_eq!((scene.materials[0].metallic, scene.materials[0].roughness), (0.0, 1.0));
    assert_eq!(warned(&scene, "KHR_materials_unlit is left out: its materials are taken as diffuse"), 1);
}

#[test]
fn the_diffuse_part_of_specular_glossiness_is_read() {
    let model = json!({"diffuseFactor": [0.1, 0.2, 0.3, 0.9], "glossinessFactor": 0.25});
    let scene = with_material_extension("KHR_materials_pbrSpecularGlossiness", &model).load().unwrap();
    let material = &scene.materials[0];
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 0.9));
    assert_eq!((material.metallic, material.roughness), (0.0, 0.75));
    assert_eq!(warned(&scene, "the diffuse part is read"), 1);
}

#[test]
fn compressed_files_are_refused_with_the_command_that_unpacks_them() {
    for (name, command) in [
        ("EXT_meshopt_compression", "`gltf-transform copy scene.glb unpacked.glb`"),
        ("KHR_draco_mesh_compression", "`gltf-transform copy scene.glb unpacked.glb`"),
        ("KHR_texture_basisu", "`gltf-transform ktxdecompress scene.glb unpacked.glb`"),
    ] {
        let mut glb = Glb::triangle();
        require(&mut glb, name);
        let error = error_of(&glb);
        assert!(error.contains(name) && error.contains(command), "{error}");
        // Not required: the plain data are there too.
        glb.json["extensionsRequired"] = json!([]);
        assert_eq!(glb.load().unwrap().warnings.iter().filter(|w| w.message.contains(name)).count(), 0);
    }
}

#[test]
fn required_extensions_that_change_geometry_are_refused() {
    let mut glb = Glb::triangle();
    require(&mut glb, "ACME_bent_meshes");
    assert_eq!(warned(&glb.load().unwrap(), "ACME_bent_meshes"), 1);
    glb.primitive()["extensions"] = json!({"ACME_bent_meshes": {}});
    assert!(error_of(&glb).contains("requires ACME_bent_meshes"));
    glb.json["extensionsRequired"] = json!([]);
    assert_eq!(warned(&glb.load().unwrap(), "ACME_bent_meshes"), 1);
}

#[test]
fn hidden_nodes_are_left_out_with_their_children() {
    let mut glb = Glb::triangle();
    let visibility = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    glb.json["nodes"] = json!([
        {"mesh": 0, "extensions": visibility(true)},
        {"children": [2], "extensions": visibility(false)},
        {"mesh": 0}
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    require(&mut glb, "KHR_node_visibility");
    let scene = glb.load().unwrap();
    assert_eq!((scene.triangles.len(), warned(&scene, "hidden nodes")), (1, 1));
}

/// Two copies of the triangle by `EXT_mesh_gpu_instancing`: moved, turned by a quarter round x and scaled.
fn instanced() -> Glb {
    let mut glb = Glb::triangle();
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    let moves = glb.push_floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    let turns = glb.push_floats("VEC4", &[0.0, 0.0, 0.0, 1.0, turn, 0.0, 0.0, turn]);
    let scales = glb.push_floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let attributes = json!({"TRANSLATION": moves, "ROTATION": turns, "SCALE": scales});
    glb.json["nodes"][0]["translation"] = json!([0, 10, 0]);
    glb.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    require(&mut glb, "EXT_mesh_gpu_instancing");
    glb
}

#[test]
fn instances_of_the_gpu_extension_are_placed() {
    let scene = instanced().load().unwrap();
    assert_eq!(scene.corners(0), [[1.0, 10.0, 0.0], [3.0, 10.0, 0.0], [1.0, 11.0, 0.0]].map(Vec3::from));
    let turned = [[0.0, 10.0, 5.0], [4.0, 10.0, 5.0], [0.0, 10.0, 7.0]].map(Vec3::from);
    assert!(scene.corners(1).iter().zip(turned).all(|(corner, place)| corner.abs_diff_eq(place, 1e-5)));
    let copies: Vec<u32> = scene.sources.instances.iter().map(|instance| instance.copy).collect();
    assert_eq!(copies, [0, 1]);
}

#[test]
fn broken_instances_of_the_gpu_extension_are_refused() {
    let mut many = instanced();
    many.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({"SCALE": 5});
    many.json["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"componentType": F32, "type": "VEC3", "count": 1_000_000_000}));
    assert!(error_of(&many).contains("claims 1000000000 triangles"), "{}", error_of(&many));
    let mut flat = instanced();
    flat.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(3);
    assert!(
        error_of(&flat).contains("nodes[0]: accessors[3]: Vec3 elements expected"),
        "{}",
        error_of(&flat)
    );
    let bytes = flat.push_accessor(U8, "VEC4", 2, &[0; 8]);
    flat.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({"ROTATION": bytes});
    // Quaternions of no length turn nothing.
    assert_eq!(flat.load().unwrap().geometric_normal(0), Vec3::Z);
}
