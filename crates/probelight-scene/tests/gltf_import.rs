//! What well-formed glTF files become.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use glb::{F32, Glb, U8, U16, U32, load_asset, warned};
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{AlphaMode, Light, Scene, load_gltf};
use serde_json::json;

const UP_NORMALS: [f32; 9] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];

fn with_normals() -> Glb {
    let mut glb = Glb::triangle();
    let normals = glb.push_floats("VEC3", &UP_NORMALS);
    glb.primitive()["attributes"]["NORMAL"] = json!(normals);
    glb
}

/// The triangle with an upright image over it: u to the right, v down.
fn with_upright_uvs() -> Glb {
    let mut glb = with_normals();
    let uvs = glb.push_floats("VEC2", &[0.0, 1.0, 2.0, 1.0, 0.0, 0.0]);
    glb.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    glb
}

fn bitangent(scene: &Scene, vertex: usize) -> Vec3 {
    let tangent = scene.tangents[vertex];
    scene.normals[vertex].cross(tangent.truncate()) * tangent.w
}

#[test]
fn cornell_box_is_as_published() {
    let scene = load_asset("cornell.glb");
    assert_eq!(scene.triangles.len(), 32);
    assert_eq!(scene.warnings, []);
    let emitters = scene.emissive_triangles();
    assert_eq!(emitters.len(), 2);
    for triangle in emitters {
        let triangle = triangle as usize;
        assert_eq!(scene.emission(triangle, Vec2::splat(0.25)), Vec3::new(17.0, 12.0, 4.0));
        assert!(scene.geometric_normal(triangle).abs_diff_eq(Vec3::NEG_Y, 1e-6));
    }
    for (albedo, walls) in [
        (Vec3::new(0.725, 0.71, 0.68), 26),
        (Vec3::new(0.63, 0.065, 0.05), 2),
        (Vec3::new(0.14, 0.45, 0.091), 2),
    ] {
        let same = |t: &usize| scene.albedo(*t, Vec2::ZERO).abs_diff_eq(albedo, 1e-6);
        assert_eq!((0..32).filter(same).count(), walls, "{albedo}");
    }
}

#[test]
fn every_scene_of_the_repository_loads_without_warnings() {
    for (name, triangles) in [("cornell_empty", 12), ("furnace", 12), ("rooms", 840), ("atrium", 76_700)] {
        let scene = load_asset(&format!("{name}.glb"));
        assert_eq!((scene.triangles.len(), scene.warnings.as_slice()), (triangles, [].as_slice()), "{name}");
        assert!(scene.normals.iter().all(|normal| normal.is_normalized()));
        let perpendicular = |v: usize| scene.tangents[v].truncate().dot(scene.normals[v]).abs() < 1e-3;
        assert!((0..scene.positions.len()).all(perpendicular), "{name}");
    }
}

#[test]
fn mirroring_keeps_the_front_face_and_the_texture() {
    let original = with_upright_uvs().load().unwrap();
    assert!(original.tangents[0].abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-6));
    for scale in [[-1.0, 1.0, 1.0], [1.0, -2.0, 1.0], [1.0, 1.0, -3.0], [-1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]]
    {
        let mut glb = with_upright_uvs();
        glb.json["nodes"][0]["scale"] = json!(scale);
        let scene = glb.load().unwrap();
        let scale = Vec3::from(scale);
        let front = Vec3::Z * scale.z.signum();
        assert!(scene.geometric_normal(0).abs_diff_eq(front, 1e-6), "{scale}");
        assert!(scene.normals[0].abs_diff_eq(front, 1e-6), "{scale}");
        assert!(scene.tangents[0].truncate().abs_diff_eq(Vec3::X * scale.x.signum(), 1e-6), "{scale}");
        assert!(bitangent(&scene, 0).abs_diff_eq(Vec3::Y * scale.y.signum(), 1e-6), "{scale}");
    }
}

#[test]
fn normals_follow_uneven_scales_and_flattening() {
    let mut glb = Glb::triangle();
    let slope = Vec3::new(0.0, -1.0, 1.0).normalize();
    let normals = glb.push_floats("VEC3", &[slope.to_array(); 3].concat());
    glb.primitive()["attributes"]["NORMAL"] = json!(normals);
    glb.json["nodes"][0]["scale"] = json!([1, 1, 4]);
    let scene = glb.load().unwrap();
    assert!(scene.normals[0].abs_diff_eq(Vec3::new(0.0, -4.0, 1.0).normalize(), 1e-6));

    for scale in [1e-9, 1e9] {
        let mut glb = with_normals();
        glb.json["nodes"][0]["scale"] = json!([scale, scale, -scale]);
        let scene = glb.load().unwrap();
        assert_eq!((scene.normals[0], scene.geometric_normal(0)), (Vec3::NEG_Z, Vec3::NEG_Z));
    }

    let mut flat = with_normals();
    flat.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    assert_eq!(flat.load().unwrap().normals[0], Vec3::Z);
}

#[test]
fn instances_are_flattened_with_their_parents_transforms() {
    let mut glb = Glb::triangle();
    let turn = std::f32::consts::FRAC_1_SQRT_2;
    glb.json["nodes"] = json!([
        {"translation": [10, 0, 0], "children": [1, 2]},
        {"mesh": 0, "translation": [0, 1, 0]},
        {"mesh": 0, "rotation": [0, turn, 0, turn], "scale": [2, 2, 2]},
        {"mesh": 0}
    ]);
    glb.json["scenes"][0]["nodes"] = json!([0, 3]);
    let scene = glb.load().unwrap();
    assert_eq!((scene.triangles.len(), scene.positions.len()), (3, 9));
    assert_eq!(scene.corners(0), [[10.0, 1.0, 0.0], [12.0, 1.0, 0.0], [10.0, 2.0, 0.0]].map(Vec3::from));
    assert!(scene.corners(1)[1].abs_diff_eq(Vec3::new(10.0, 0.0, -4.0), 1e-5));
    assert!(scene.geometric_normal(1).abs_diff_eq(Vec3::X, 1e-6));
    assert!((scene.surface_area() - 6.0).abs() < 1e-5);
}

#[test]
fn missing_default_scene_means_the_first_or_all_roots() {
    let mut glb = Glb::triangle();
    glb.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(glb.load().unwrap().triangles.len(), 1);
    glb.json.as_object_mut().unwrap().remove("scenes");
    glb.json["nodes"] = json!([{"mesh": 0}, {"children": [0]}, {"mesh": 0}]);
    assert_eq!(glb.load().unwrap().triangles.len(), 2);
}

#[test]
fn vertices_without_normals_get_their_own_flat_ones() {
    let mut glb = Glb::triangle();
    let positions = glb.push_floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
    let indices = glb.push_accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
    *glb.primitive() = json!({"attributes": {"POSITION": positions}, "indices": indices});
    let scene = glb.load().unwrap();
    assert_eq!(scene.positions.len(), 6);
    for triangle in 0..2 {
        for vertex in scene.triangles[triangle] {
            assert_eq!(scene.normals[vertex as usize], scene.geometric_normal(triangle));
        }
    }
}

#[test]
fn strips_fans_and_every_index_type_give_triangles() {
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    for (mode, order) in [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        for (component, size) in [(U8, 1), (U16, 2), (U32, 4)] {
            let mut glb = Glb::triangle();
            let positions = glb.push_floats("VEC3", &square);
            let bytes: Vec<u8> = order.iter().flat_map(|i: &u32| i.to_le_bytes()[..size].to_vec()).collect();
            let indices = glb.push_accessor(component, "SCALAR", 4, &bytes);
            *glb.primitive() =
                json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode});
            let scene = glb.load().unwrap();
            assert_eq!(scene.triangles.len(), 2);
            assert!((scene.surface_area() - 1.0).abs() < 1e-6);
            assert!((0..2).all(|triangle| scene.geometric_normal(triangle) == Vec3::Z), "mode {mode}");
        }
    }
}

#[test]
fn what_is_not_used_is_counted() {
    let mut glb = with_normals();
    let colors = glb.push_floats("VEC3", &[1.0; 9]);
    glb.primitive()["attributes"]["COLOR_0"] = json!(colors);
    glb.primitive()["targets"] = json!([{"POSITION": 0}]);
    for mode in 0..4 {
        let primitive = json!({"attributes": {"POSITION": 0}, "mode": mode});
        glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    glb.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"camera": 0}]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1]);
    glb.json["skins"] = json!([{"joints": [0]}]);
    let lens = json!({"xmag": 1, "ymag": 1, "zfar": 1, "znear": 0});
    glb.json["cameras"] = json!([{"type": "orthographic", "orthographic": lens}]);
    glb.json["extensionsUsed"] = json!(["EXT_instance_features"]);
    let scene = glb.load().unwrap();
    for (text, count) in [
        ("vertex colours", 1),
        ("morph targets", 1),
        ("points or lines", 4),
        ("skinned", 1),
        ("orthographic", 1),
        ("EXT_instance_features", 1),
    ] {
        assert_eq!(warned(&scene, text), count, "{text}: {:?}", scene.warnings);
    }
}

#[test]
fn harmless_defects_are_repaired_and_counted() {
    let mut glb = Glb::triangle();
    let normals = glb.push_floats("VEC3", &[0.0, 0.0, 0.0, f32::NAN, 0.0, 1.0, 0.0, 0.0, 5.0]);
    let uvs = glb.push_floats("VEC2", &[0.0, 0.0, f32::INFINITY, 0.0, 0.0, 1.0]);
    let indices = glb.push_accessor(U8, "SCALAR", 9, &[0, 1, 2, 0, 0, 1, 2, 2, 2]);
    *glb.primitive() = json!({
        "attributes": {"POSITION": 0, "NORMAL": normals, "TEXCOORD_0": uvs},
        "indices": indices, "material": 0
    });
    glb.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorFactor": [2, 0.5, -1, 1]}, "emissiveFactor": [-1, 0, 0]
    }]);
    let scene = glb.load().unwrap();
    assert_eq!(scene.triangles.len(), 1);
    assert_eq!(scene.normals, [Vec3::Z; 3]);
    assert_eq!(scene.materials[0].base_color, Vec4::new(1.0, 0.5, 0.0, 1.0));
    assert_eq!(scene.materials[0].emission, Vec3::ZERO);
    for (text, count) in [("without area", 2), ("normals", 2), ("coordinates", 1), ("clamped", 1)] {
        assert_eq!(warned(&scene, text), count, "{text}: {:?}", scene.warnings);
    }
}

#[test]
fn normalized_and_second_texture_coordinates_are_read() {
    let mut glb = with_normals();
    let bytes = glb.push_accessor(U8, "VEC2", 3, &[0, 255, 51, 0, 0, 0]);
    let words: Vec<u8> = [65535u16, 0, 0, 13107, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    let shorts = glb.push_accessor(U16, "VEC2", 3, &words);
    for accessor in [bytes, shorts] {
        glb.json["accessors"][accessor]["normalized"] = json!(true);
    }
    glb.primitive()["attributes"]["TEXCOORD_0"] = json!(bytes);
    glb.primitive()["attributes"]["TEXCOORD_1"] = json!(shorts);
    // A second mesh without a second set gets zeros.
    glb.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}}]}));
    glb.push("nodes", json!({"mesh": 1}));
    glb.json["scenes"][0]["nodes"] = json!([1, 0]);
    let scene = glb.load().unwrap();
    let corner = |corner: usize| scene.triangles[1][corner] as usize;
    assert_eq!(scene.uv0[corner(0)], Vec2::Y);
    assert!(scene.uv0[corner(1)].abs_diff_eq(Vec2::new(0.2, 0.0), 1e-6));
    assert_eq!(scene.uv1[corner(0)], Vec2::X);
    assert!(scene.uv1[corner(1)].abs_diff_eq(Vec2::new(0.0, 0.2), 1e-6));
    assert_eq!(scene.uv1[scene.triangles[0][0] as usize], Vec2::ZERO);
}

#[test]
fn sparse_values_replace_base_values_and_zeros() {
    let mut glb = Glb::triangle();
    let indices = glb.push_view(&[1]);
    let values = glb.push_view(&[5.0f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
    let sparse = json!({
        "count": 1, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}
    });
    glb.json["accessors"][0]["sparse"] = sparse.clone();
    let scene = glb.load().unwrap();
    assert_eq!(scene.corners(0), [Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0), Vec3::Y]);

    let normals = json!({"componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse});
    let normals = glb.push("accessors", normals);
    glb.primitive()["attributes"]["NORMAL"] = json!(normals);
    assert_eq!(glb.load().unwrap().normals, [Vec3::Z, Vec3::X, Vec3::Z]);
}

#[test]
fn interleaved_attributes_are_read() {
    let mut glb = Glb::triangle();
    let rows: [[f32; 6]; 3] = [[0., 0., 0., 0., 1., 0.], [1., 0., 0., 1., 0., 0.], [0., 1., 0., 0., 0., 1.]];
    let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    let view = glb.push_view(&bytes);
    glb.json["bufferViews"][view]["byteStride"] = json!(24);
    glb.json["accessors"][0]["bufferView"] = json!(view);
    let normals = json!({
        "bufferView": view, "byteOffset": 12, "componentType": F32, "type": "VEC3", "count": 3
    });
    let normals = glb.push("accessors", normals);
    glb.primitive()["attributes"]["NORMAL"] = json!(normals);
    let scene = glb.load().unwrap();
    assert_eq!(scene.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.normals, [Vec3::Y, Vec3::X, Vec3::Z]);
}

#[test]
fn lights_and_cameras_are_placed_in_the_world() {
    let mut glb = Glb::triangle();
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 8, "range": 3},
        {"type": "directional", "intensity": 3},
        {"type": "spot", "intensity": 2, "range": 0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}},
        {"type": "point", "intensity": -1}
    ]}});
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let light = |light: u32| json!({"KHR_lights_punctual": {"light": light}});
    let quarter_turn = std::f32::consts::FRAC_1_SQRT_2;
    glb.json["nodes"] = json!([
        {"mesh": 0, "translation": [1, 2, 3], "scale": [2, 2, 2], "children": [1, 2, 3, 4, 5]},
        {"extensions": light(0), "translation": [1, 0, 0]},
        {"extensions": light(1), "rotation": [-quarter_turn, 0, 0, quarter_turn]},
        {"extensions": light(2)},
        {"extensions": light(3)},
        {"camera": 0, "name": "eye"}
    ]);
    glb.json["cameras"] = json!([{
        "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}
    }]);
    let scene = glb.load().unwrap();
    let [point, sun, spot] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    let intensity = Vec3::new(8.0, 4.0, 2.0);
    assert_eq!(*point, Light::Point { position: Vec3::new(3.0, 2.0, 3.0), intensity, range: Some(3.0) });
    let Light::Directional { direction, irradiance } = sun else { panic!("{sun:?}") };
    assert!(direction.abs_diff_eq(Vec3::NEG_Y, 1e-6) && *irradiance == Vec3::splat(3.0));
    let Light::Spot { direction, inner_angle, outer_angle, range: None, .. } = spot else {
        panic!("{spot:?}")
    };
    assert_eq!((*direction, *inner_angle, *outer_angle), (Vec3::NEG_Z, 0.1, 0.5));
    assert_eq!([warned(&scene, "lights whose colour"), warned(&scene, "range of 0")], [1, 1]);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.width, camera.height), ("eye", 768, 512));
    let centre = camera.ray_direction(Vec2::new(384.0, 256.0));
    assert!(centre.abs_diff_eq(Vec3::NEG_Z, 1e-5));
}

#[test]
fn materials_keep_alpha_emission_and_sides() {
    let mut glb = Glb::triangle();
    glb.json["materials"] = json!([
        {"alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true},
        {"alphaMode": "BLEND", "emissiveFactor": [1, 0.5, 0],
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}}
    ]);
    let scene = glb.load().unwrap();
    let [masked, blended, default] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    assert_eq!((masked.alpha_mode, masked.double_sided), (AlphaMode::Mask { cutoff: 0.3 }, true));
    assert_eq!(blended.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(blended.emission, Vec3::new(10.0, 5.0, 0.0));
    assert_eq!(warned(&scene, "alpha-blended"), 1);
    assert_eq!(scene.material(0), default);
    assert!(scene.emissive_triangles().is_empty());
}

#[test]
fn content_hash_sees_what_light_sees() {
    let scene = with_upright_uvs().load().unwrap();
    let hash = scene.content_hash();
    let changed = |change: fn(&mut Scene)| {
        let mut copy = scene.clone();
        change(&mut copy);
        copy.content_hash()
    };
    assert_eq!(hash, with_upright_uvs().load().unwrap().content_hash());
    assert_eq!(hash, changed(|s| s.warnings.clear()));
    assert_eq!(
        hash,
        changed(|s| s.lights.push(Light::Point { position: Vec3::X, intensity: Vec3::X, range: None }))
    );
    assert_eq!(hash, changed(|s| s.materials[0].name.push('x')));
    assert_ne!(hash, changed(|s| s.positions[0].x += 1e-6));
    assert_ne!(hash, changed(|s| s.triangles[0].rotate_left(1)));
    assert_ne!(hash, changed(|s| s.materials[0].base_color.y = 0.5));
    assert_ne!(hash, changed(|s| s.materials[0].double_sided = true));
    assert_ne!(hash, changed(|s| s.uv1 = s.uv0.clone()));
}

#[test]
fn text_files_find_their_buffers_beside_them_or_inside() {
    let glb = Glb::triangle();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my data.bin"), &glb.binary).unwrap();
    use base64::Engine;
    let inside = base64::engine::general_purpose::STANDARD.encode(&glb.binary);
    for uri in ["my%20data.bin".into(), format!("data:application/octet-stream;base64,{inside}")] {
        let mut json = glb.json.clone();
        json["buffers"] = json!([{"byteLength": glb.binary.len(), "uri": uri}]);
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        assert_eq!(load_gltf(&path).unwrap().triangles.len(), 1);
    }
}
