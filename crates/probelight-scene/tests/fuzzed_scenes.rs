//! Files damaged at random, or everywhere in turn, never cause a panic.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use glb::{Glb, U8, load_bytes};
use proptest::prelude::*;
use serde_json::{Value, json};

#[test]
fn deep_nesting_does_not_exhaust_the_stack() {
    let mut glb = Glb::triangle();
    let depth = 100_000;
    let mut nodes: Vec<_> = (1..depth).map(|child| json!({"children": [child]})).collect();
    nodes.push(json!({"mesh": 0, "translation": [0, 1, 0]}));
    glb.json["nodes"] = json!(nodes);
    let scene = glb.load().unwrap();
    assert_eq!(scene.bounds().min.y, 1.0);
}

/// A scene with something of everything that is read.
fn rich_scene() -> Glb {
    let mut glb = Glb::triangle();
    let normals = glb.push_floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = glb.push_floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    let uvs = glb.push_accessor(U8, "VEC2", 3, &[0, 0, 255, 0, 0, 255]);
    let (sparse_indices, sparse_values) = (glb.push_view(&[1]), glb.push_view(&[0; 12]));
    let mut image = std::io::Cursor::new(Vec::new());
    image::RgbaImage::new(2, 2).write_to(&mut image, image::ImageFormat::Png).unwrap();
    glb.add_image(image.get_ref());
    glb.json["accessors"][normals]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": sparse_indices, "byteOffset": 0, "componentType": U8},
        "values": {"bufferView": sparse_values, "byteOffset": 0}
    });
    glb.json["accessors"][uvs]["normalized"] = json!(true);
    glb.json["bufferViews"][0]["byteStride"] = json!(12);
    glb.json["buffers"] = json!([{"byteLength": glb.binary.len()}]);
    *glb.primitive() = json!({
        "attributes": {"POSITION": 0, "NORMAL": normals, "TANGENT": tangents, "TEXCOORD_0": uvs,
                       "COLOR_0": normals},
        "indices": 1, "material": 0, "mode": 4, "targets": [{"POSITION": 0}]
    });
    let transform = json!({"KHR_texture_transform": {
        "offset": [0, 1], "rotation": 1, "scale": [2, 2], "texCoord": 0
    }});
    let slot = json!({"index": 0, "texCoord": 0, "extensions": transform});
    glb.json["materials"] = json!([{
        "name": "all", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.5,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 1,
                                 "baseColorTexture": slot, "metallicRoughnessTexture": slot},
        "normalTexture": slot, "occlusionTexture": slot, "emissiveTexture": slot,
        "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}
    }]);
    glb.json["samplers"] = json!([{"wrapS": 10497, "wrapT": 10497}]);
    glb.json["textures"][0]["sampler"] = json!(0);
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "color": [1, 1, 1], "intensity": 2, "range": 3,
         "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}
    ]}});
    glb.json["cameras"] = json!([{
        "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 9, "aspectRatio": 1.5}
    }]);
    glb.json["skins"] = json!([{"joints": [1]}]);
    glb.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "children": [1], "translation": [0, 0, 1], "rotation": [0, 0, 0, 1],
         "scale": [1, 1, 1]},
        {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
         "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    glb
}

/// JSON pointers to every value inside `value`.
fn pointers(value: &Value, prefix: &str, found: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(members) => members.iter().map(|(name, value)| (name.clone(), value)).collect(),
        Value::Array(values) => values.iter().enumerate().map(|(i, value)| (i.to_string(), value)).collect(),
        _ => Vec::new(),
    };
    for (name, child) in children {
        let pointer = format!("{prefix}/{name}");
        pointers(child, &pointer, found);
        found.push(pointer);
    }
}

#[test]
fn no_wrong_value_anywhere_makes_it_panic() {
    let glb = rich_scene();
    assert_eq!(glb.load().unwrap().textures.len(), 1);
    let mut places = Vec::new();
    pointers(&glb.json, "", &mut places);
    assert!(places.len() > 200);
    let wrong =
        json!([null, 0, 1, 2, 7, -1, 0.5, 1e38, 1_000_000_000, u64::MAX, "", "%FF", true, [], [0], {}]);
    for place in places {
        for value in wrong.as_array().unwrap() {
            let mut spoilt = Glb { json: glb.json.clone(), binary: glb.binary.clone() };
            *spoilt.json.pointer_mut(&place).unwrap() = value.clone();
            if let Ok(scene) = spoilt.load() {
                assert!(scene.validate().is_ok(), "{place} = {value}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn flipped_bytes_never_panic(flips in prop::collection::vec((0usize..6124, any::<u8>()), 1..6)) {
        let mut bytes = std::fs::read(glb::asset("cornell.glb")).unwrap();
        for (at, value) in flips {
            bytes[at] = value;
        }
        if let Ok(scene) = load_bytes(&bytes) {
            prop_assert!(scene.validate().is_ok());
        }
    }

    #[test]
    fn flipped_digits_never_panic(flips in prop::collection::vec((0usize..2000, b'0'..=b'9'), 1..4)) {
        let mut bytes = std::fs::read(glb::asset("cornell.glb")).unwrap();
        let digits: Vec<usize> = (20..bytes.len()).filter(|at| bytes[*at].is_ascii_digit()).collect();
        for (which, digit) in flips {
            bytes[digits[which % digits.len()]] = digit;
        }
        let _ = load_bytes(&bytes);
    }

    #[test]
    fn truncated_files_are_refused(length in 0usize..6124) {
        let bytes = std::fs::read(glb::asset("cornell.glb")).unwrap();
        prop_assert!(load_bytes(&bytes[..length]).is_err());
    }
}
