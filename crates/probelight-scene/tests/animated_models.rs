//! What skins and animations make of a model.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[allow(dead_code, reason = "other tests use the rest")]
mod glb;

use std::path::Path;

use glb::{Glb, U8};
use probelight_math::glam::Vec3;
use probelight_scene::{AnimatedModel, SceneError, load_animated_gltf, parse_animated_gltf};
use serde_json::json;

fn load(glb: &Glb) -> Result<AnimatedModel, SceneError> {
    parse_animated_gltf(&glb.bytes(), Path::new("moving.glb"))
}

/// A triangle at a node that turns about the z axis by 90 degrees in two seconds, below one that moves up by 4 in four.
fn rigid() -> Glb {
    let mut glb = Glb::triangle();
    glb.json["nodes"] = json!([{"children": [1], "translation": [1, 0, 0]}, {"mesh": 0}]);
    let times = [glb.push_floats("SCALAR", &[0.0, 2.0]), glb.push_floats("SCALAR", &[0.0, 4.0])];
    let half = std::f32::consts::FRAC_PI_4;
    let turn = glb.push_floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()]);
    let rise = glb.push_floats("VEC3", &[1.0, 0.0, 0.0, 1.0, 4.0, 0.0]);
    glb.json["animations"] = json!([{"name": "move",
        "samplers": [{"input": times[0], "output": turn}, {"input": times[1], "output": rise}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}},
                     {"sampler": 1, "target": {"node": 0, "path": "translation"}}]}]);
    glb
}

/// The triangle with its third corner bound to a second joint, one above the first.
fn skinned() -> Glb {
    let mut glb = rigid();
    glb.json["nodes"] = json!([{"children": [1], "translation": [0, 0, 0]}, {"translation": [0, 1, 0]},
        {"mesh": 0, "skin": 0, "translation": [50, 0, 0]}]);
    glb.json["scenes"] = json!([{"nodes": [0, 2]}]);
    let joints = glb.push_accessor(U8, "VEC4", 3, &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    let weights = glb.push_floats("VEC4", &[2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let mut inverse = [[0.0f32; 16]; 2];
    for (i, matrix) in inverse.iter_mut().enumerate() {
        [0, 5, 10, 15].into_iter().for_each(|k| matrix[k] = 1.0);
        matrix[13] = -(i as f32);
    }
    let inverse = glb.push_floats("MAT4", inverse.as_flattened());
    glb.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    glb.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    glb.json["skins"] = json!([{"joints": [0, 1], "inverseBindMatrices": inverse}]);
    glb
}

fn positions(model: &AnimatedModel, clip: Option<usize>, time: f32) -> Vec<Vec3> {
    let scene = model.pose(clip, time);
    scene.validate().unwrap();
    scene.positions
}

fn assert_at(found: &[Vec3], wanted: [[f32; 3]; 3]) {
    let near = found.iter().zip(wanted).all(|(a, b)| a.abs_diff_eq(Vec3::from(b), 1e-5));
    assert!(near, "{found:?} {wanted:?}");
}

#[test]
fn nodes_move_what_hangs_on_them() {
    let model = load(&rigid()).unwrap();
    assert_eq!(model.clips().collect::<Vec<_>>(), ["move"]);
    assert_eq!((model.clip("move"), model.clip("other"), model.duration(0)), (Some(0), None, 4.0));
    assert_eq!(positions(&model, None, 0.0), model.rest().positions);
    assert_at(&positions(&model, Some(0), 0.0), [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_at(&positions(&model, Some(0), 2.0), [[1.0, 2.0, 0.0], [1.0, 4.0, 0.0], [0.0, 2.0, 0.0]]);
    // The turn is over and stays, and the whole begins anew.
    assert_at(&positions(&model, Some(0), 3.0), [[1.0, 3.0, 0.0], [1.0, 5.0, 0.0], [0.0, 3.0, 0.0]]);
    assert_eq!(positions(&model, Some(0), 4.5), positions(&model, Some(0), 0.5));
}

#[test]
fn joints_move_their_vertices_and_the_node_of_the_mesh_does_not() {
    let model = load(&skinned()).unwrap();
    assert_at(&positions(&model, None, 0.0), [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    // The second joint turns about itself, where its vertex is; the first has moved to x = 1 and up by 2.
    assert_at(&positions(&model, Some(0), 2.0), [[1.0, 2.0, 0.0], [3.0, 2.0, 0.0], [1.0, 3.0, 0.0]]);
    let normal = model.pose(Some(0), 2.0).normals[0];
    assert!(normal.abs_diff_eq(Vec3::Z, 1e-5), "{normal}");
}

#[test]
fn broken_motion_is_refused_by_name_and_only_where_it_matters() {
    for (pointer, value, message) in [
        (
            "/animations/0/samplers/0/input",
            json!(99),
            "animations[0]: it uses an accessor that does not exist",
        ),
        ("/animations/0/samplers/0/output", json!(0), "animations[0]: accessors[0]: Vec4 elements expected"),
        ("/animations/0/channels/0/sampler", json!(7), "animations[0]: a channel has no sampler"),
        ("/animations/0/samplers/1/interpolation", json!("BEZIER"), "is no interpolation"),
        ("/skins/0/joints/1", json!(9), "skins[0]: one of its joints is no node of the scene"),
        ("/skins/0/inverseBindMatrices", json!(0), "skins[0]: accessors[0]: Mat4 elements expected"),
    ] {
        let mut glb = skinned();
        match glb.json.pointer_mut(pointer) {
            Some(place) => *place = value,
            None => glb.json["animations"][0]["samplers"][1]["interpolation"] = value,
        }
        let error = load(&glb).unwrap_err().to_string();
        assert!(error.contains(message) && error.contains("moving.glb"), "{pointer}: {error}");
        glb.load().unwrap();
    }
}

#[test]
fn vertices_of_joints_that_do_not_exist_stay_rigid() {
    let mut glb = skinned();
    glb.json["skins"][0]["joints"] = json!([0]);
    let found = positions(&load(&glb).unwrap(), None, 0.0);
    assert_at(&found, [[50.0, 0.0, 0.0], [52.0, 0.0, 0.0], [50.0, 1.0, 0.0]]);
}

#[test]
fn poses_share_the_images_of_their_model() {
    let model = load_animated_gltf(&glb::asset("../objects/ball.glb")).unwrap();
    let posed = model.pose(None, 0.0);
    assert_eq!((posed.triangles.len(), posed.textures.len()), (1520, 3));
    let images = posed.textures.iter().zip(&model.rest().textures);
    assert!(images.into_iter().all(|(a, b)| std::sync::Arc::ptr_eq(&a.rgba8, &b.rgba8)));
    assert_eq!(posed.positions, model.rest().positions);
}
