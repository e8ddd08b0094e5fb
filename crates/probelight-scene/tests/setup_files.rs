//! Setup files: what they mean, and what is refused.
#![cfg(all(feature = "files", feature = "gltf"))]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{Bounds, Light, SceneError, Setup, Sky};
use serde_json::{Value, json};

fn evening() -> Value {
    json!({
        "version": 1, "name": "evening", "scene": "room.glb", "use_emissive": true, "emissive_scale": 2.5,
        "lights": [
            {"type": "point", "position": [0, 2, 0], "intensity": [9, 8, 7], "range": 6.5},
            {"type": "spot", "position": [1, 2, 3], "direction": [0, -4, 0], "intensity": [1, 2, 3],
             "inner_deg": 30, "outer_deg": 60},
            {"type": "directional", "direction": [3, -4, 0], "irradiance": [3, 2, 1]},
            {"type": "sky", "radiance": [0.1, 0.2, 0.3]}
        ],
        "cameras": [
            {"name": "front", "position": [0, 1, 5], "target": [0, 1, 0], "up": [0, 2, 0],
             "vfov_deg": 90, "width": 640, "height": 480},
            {"name": "side", "position": [5, 1, 0], "target": [0, 1, 0], "up": [0, 1, 0],
             "vfov_deg": 40, "width": 64, "height": 48}
        ],
        "eval_bounds": [[-1, 0, -1], [1, 2, 1]]
    })
}

fn load_text(text: &str) -> Result<Setup, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("setup.json");
    std::fs::write(&path, text).unwrap();
    Setup::load(&path)
}

#[test]
fn every_field_is_read_in_its_unit() {
    let setup = load_text(&evening().to_string()).unwrap();
    assert_eq!((setup.name.as_str(), setup.scene.as_str()), ("evening", "room.glb"));
    assert_eq!(setup.lighting.emissive_scale, 2.5);
    assert_eq!(setup.lighting.sky, Sky::Uniform(Vec3::new(0.1, 0.2, 0.3)));
    let [point, spot, sun] = &setup.lighting.lights[..] else { panic!("{:?}", setup.lighting) };
    let intensity = Vec3::new(9.0, 8.0, 7.0);
    assert_eq!(*point, Light::Point { position: Vec3::new(0.0, 2.0, 0.0), intensity, range: Some(6.5) });
    let Light::Spot { direction, inner_angle, outer_angle, range: None, .. } = spot else {
        panic!("{spot:?}")
    };
    assert_eq!(*direction, Vec3::NEG_Y);
    assert!((inner_angle - std::f32::consts::FRAC_PI_6).abs() < 1e-6);
    assert!((outer_angle - std::f32::consts::FRAC_PI_3).abs() < 1e-6);
    let Light::Directional { direction, irradiance } = sun else { panic!("{sun:?}") };
    assert!(direction.abs_diff_eq(Vec3::new(0.6, -0.8, 0.0), 1e-6));
    assert_eq!(*irradiance, Vec3::new(3.0, 2.0, 1.0));
    assert!((setup.cameras[0].vertical_fov - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    let bounds = Bounds { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) };
    assert_eq!(setup.eval_bounds, Some(bounds));
}

#[test]
fn what_is_written_is_read_again() {
    let mut value = evening();
    value["materials"] = json!([
        {"name": "wall", "base_color": [0.1, 0.2, 0.3]}, {"name": "lamp", "emission": [9, 8, 7]}
    ]);
    value["objects"] = json!([
        {"file": "chair.glb", "position": [1, 2, 3], "yaw_deg": 40, "scale": 2.0},
        {"file": "door.glb", "door": true, "position": [1, 0, 0]},
        {"file": "fox.glb", "clip": "Walk", "path": [
            {"time": 0, "position": [0, 1, 0]}, {"time": 2, "position": [0, 1, 3], "yaw_deg": -120}
        ]}
    ]);
    let setup = load_text(&value.to_string()).unwrap();
    assert_eq!(setup.materials.len(), 2);
    let again = load_text(&setup.to_json()).unwrap();
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    for (a, b) in setup.cameras.iter().zip(&again.cameras) {
        assert!(a.position == b.position && near(a.vertical_fov, b.vertical_fov), "{b:?}");
    }
    for (a, b) in setup.objects.iter().zip(&again.objects) {
        assert_eq!((&a.file, &a.clip, a.keyframes.len()), (&b.file, &b.clip, b.keyframes.len()));
        assert_eq!((a.is_door, a.is_door), (b.is_door, a.file.ends_with("door.glb")));
        for (a, b) in a.keyframes.iter().zip(&b.keyframes) {
            assert!(a.time == b.time && a.placement.rotation.angle_between(b.placement.rotation) < 1e-3);
            assert_eq!(
                (a.placement.translation, a.placement.scale),
                (b.placement.translation, b.placement.scale)
            );
        }
    }
    assert_eq!((&setup.materials, setup.eval_bounds), (&again.materials, again.eval_bounds));
    assert_eq!((&setup.lighting.sky, setup.lighting.emissive_scale), (&again.lighting.sky, 2.5));
    assert_eq!(setup.lighting.lights.len(), again.lighting.lights.len());
    assert_eq!(setup.lighting.lights[0], again.lighting.lights[0]);
    let Light::Spot { inner_angle, outer_angle, .. } = again.lighting.lights[1] else { panic!() };
    assert!(near(inner_angle, 30f32.to_radians()) && near(outer_angle, 60f32.to_radians()));
    let dark =
        Setup { lighting: probelight_scene::Lighting { emissive_scale: 0.0, ..setup.lighting }, ..setup };
    assert_eq!(load_text(&dark.to_json()).unwrap().lighting.emissive_scale, 0.0);
}

#[test]
fn names_and_motions_of_lights_are_read_and_written() {
    let with = |motions: [Value; 5]| {
        let mut value = evening();
        let lamp = json!({"type": "point", "position": [0, 2, 0], "intensity": [9, 8, 7]});
        let sun = json!({"type": "directional", "direction": [0, -1, 0], "irradiance": [4, 4, 4]});
        value["lights"] = [&lamp, &sun, &lamp, &lamp, &lamp].map(Clone::clone).into();
        for (light, motion) in value["lights"].as_array_mut().unwrap().iter_mut().zip(motions) {
            light["motion"] = motion;
        }
        value["lights"][3]["name"] = json!("ceiling");
        value["lights"][4].as_object_mut().unwrap().remove("motion");
        load_text(&value.to_string())
    };
    let motions = [
        json!({"type": "circle", "radius": 2, "period": 12}),
        json!({"type": "day", "period": 40}),
        json!({"type": "flicker", "strength": 0.4}),
        json!({"type": "keyframes", "keyframes": [{"time": 0}, {"time": 2, "position": [4, 2, 0]}]}),
        json!(null),
    ];
    let setup = with(motions.clone()).unwrap();
    assert_eq!(setup.light_tracks.len(), 4, "the last one has neither");
    assert_eq!(setup.light_tracks[3].name, "ceiling");
    let Light::Point { position, intensity, .. } = setup.lighting_at(1.0).lights[3] else { panic!() };
    assert_eq!((position, intensity), (Vec3::new(2.0, 2.0, 0.0), Vec3::new(9.0, 8.0, 7.0)));
    assert_eq!(setup.lighting_at(1.0).lights[4], setup.lighting.lights[4]);
    let again = load_text(&setup.to_json()).unwrap();
    assert_eq!((setup.light_tracks, setup.lighting), (again.light_tracks, again.lighting));

    let refused = |light: usize, motion: Value, wanted: &str| {
        let mut motions = motions.clone();
        motions[light] = motion;
        let error = with(motions).unwrap_err().to_string();
        assert!(error.contains(&format!("lights[{light}]")) && error.contains(wanted), "{error}");
    };
    refused(0, json!({"type": "day", "period": 40}), "only directional lights");
    refused(0, json!({"type": "spiral"}), "circle, day, flicker, keyframes");
    refused(0, json!({"type": "circle", "period": 0}), "period");
    refused(2, json!({"type": "flicker", "strength": 2}), "from 0 to 1");
    refused(3, json!({"type": "keyframes", "keyframes": []}), "at least one");
    refused(3, json!({"type": "keyframes", "keyframes": [{"time": 1}, {"time": 1}]}), "times must grow");
    refused(3, json!({"type": "keyframes", "keyframes": [{"time": 1, "direction": [1, 0, 0]}]}), "direction");
}

#[test]
fn emissive_switch_and_optional_fields() {
    let mut setup = evening();
    setup["use_emissive"] = json!(false);
    assert_eq!(load_text(&setup.to_string()).unwrap().lighting.emissive_scale, 0.0);
    setup["use_emissive"] = json!(true);
    setup.as_object_mut().unwrap().remove("emissive_scale");
    setup.as_object_mut().unwrap().remove("eval_bounds");
    setup["lights"] =
        json!([{"type": "sky", "zenith": [1, 0, 0], "horizon": [0, 1, 0], "ground": [0, 0, 1]}]);
    let setup = load_text(&setup.to_string()).unwrap();
    assert_eq!((setup.lighting.emissive_scale, setup.eval_bounds), (1.0, None));
    assert_eq!(setup.lighting.sky, Sky::Gradient { zenith: Vec3::X, horizon: Vec3::Y, ground: Vec3::Z });
}

#[test]
fn cameras_are_found_by_name() {
    let setup = load_text(&evening().to_string()).unwrap();
    assert_eq!(setup.camera(None).unwrap().name, "front");
    assert_eq!(setup.camera(Some("side")).unwrap().width, 64);
    let error = setup.camera(Some("back")).unwrap_err().to_string();
    assert_eq!(error, "setup \"evening\" has no camera \"back\"; it has: front, side");
    assert!(Setup::default().camera(None).is_err());
}

/// The same of objects.
fn spoilt_objects() -> Vec<(&'static str, Value, &'static str)> {
    vec![
        ("/objects", json!([{"position": [0, 0, 0]}]), "objects[0].file is missing"),
        ("/objects", json!([{"file": "a.glb"}]), "objects[0].position is missing"),
        ("/objects", json!([{"file": "a.glb", "position": [0, 0, 0], "door": 1}]), "objects[0].door"),
        (
            "/objects",
            json!([{"file": "a.glb", "position": [0, 0, 0], "scale": 0}]),
            "objects[0]: its scale is 0",
        ),
        (
            "/objects",
            json!([{"file": "a.glb", "path": []}]),
            "objects[0].path: a path needs at least one keyframe",
        ),
        (
            "/objects",
            json!([{"file": "a.glb", "path": [{"time": 1, "position": [0, 0, 0]}, {"time": 1, "position": [0, 0, 0]}]}]),
            "objects[0].path[1]: times must grow",
        ),
    ]
}

/// Where to write which value, and what the error then says. `null` removes the field.
fn spoilt_fields() -> Vec<(&'static str, Value, &'static str)> {
    vec![
        ("/version", json!(2), "version: only version 1"),
        ("/version", Value::Null, "version is missing"),
        ("/name", json!(3), "name: a string expected, found 3"),
        ("/lights", json!({}), "lights: an array expected, found an object"),
        ("/lights", Value::Null, "lights is missing"),
        ("/use_emissive", json!("yes"), "use_emissive: true or false expected, found a string"),
        ("/emissive_scale", json!(-1), "emissive_scale: a number from 0"),
        ("/colour", json!(1), "colour is not a known field; allowed here: version, name, scene"),
        ("/lights/0/type", json!("laser"), "lights[0].type: \"laser\" is no type of light; allowed: point"),
        ("/lights/0/type", Value::Null, "lights[0].type is missing"),
        ("/lights/0/radius", json!(1), "lights[0].radius is not a known field; allowed here: type, position"),
        ("/lights/0/position", json!([1, 2]), "lights[0].position: an array of three numbers"),
        ("/lights/0/position/1", json!("x"), "lights[0].position[1]: a number expected"),
        ("/lights/0/position/1", json!(1e300), "lights[0].position[1]: a number of at most 3.4e38"),
        ("/lights/0/intensity", json!([1, -2, 3]), "lights[0].intensity: light must not be negative"),
        ("/lights/0/range", json!(0), "lights[0]: its range is 0 m; it must be positive, or absent"),
        ("/lights/1/range", json!(-2), "lights[1]: its range is -2 m"),
        ("/lights/2/range", json!(2), "lights[2].range is not a known field"),
        ("/lights/1/direction", json!([0, 0, 0]), "lights[1].direction: the zero vector is no direction"),
        ("/lights/1/inner_deg", json!(61), "lights[1].inner_deg: a number from 0 to 60 expected, found 61"),
        ("/lights/1/outer_deg", json!(181), "lights[1].outer_deg: a number from 0 to 180"),
        ("/lights/2/direction", Value::Null, "lights[2].direction is missing"),
        ("/lights/2/intensity", json!([1, 1, 1]), "lights[2].intensity is not a known field"),
        ("/lights/2", json!({"type": "sky", "radiance": [1, 1, 1]}), "lights[3]: there can be only one sky"),
        ("/lights/3/radiance", Value::Null, "lights[3]: a sky needs either radiance, or zenith"),
        ("/lights/3/zenith", json!([1, 1, 1]), "lights[3].zenith is not a known field"),
        ("/cameras/0", json!(7), "cameras[0]: an object expected, found 7"),
        ("/cameras/0/name", json!("side"), "cameras[1]: there is already a camera \"side\""),
        ("/cameras/0/up", json!([0, 0, 1]), "cameras[0]: its up is parallel to the view direction"),
        ("/cameras/0/target", json!([0, 1, 5]), "cameras[0]: its position and target are the same point"),
        (
            "/cameras/0/vfov_deg",
            json!(180),
            "cameras[0]: its vertical field of view is 180°; 0.01° to 179° are",
        ),
        (
            "/cameras/0/width",
            json!(0),
            "cameras[0]: its image is 0 × 480 pixels; 1 to 16384 a side are allowed",
        ),
        ("/cameras/0/height", json!(20_000), "cameras[0]: its image is 640 × 20000 pixels"),
        ("/cameras/1/width", json!(1.5), "cameras[1].width: a whole number"),
        ("/eval_bounds", json!([[0, 0, 0]]), "eval_bounds: two corners expected"),
        ("/eval_bounds/0", json!([2, 0, 0]), "eval_bounds: the first corner must not exceed"),
    ]
}

#[test]
fn each_wrong_field_is_named_with_what_is_allowed() {
    for (pointer, value, message) in spoilt_fields().into_iter().chain(spoilt_objects()) {
        let mut setup = evening();
        let (parent, name) = pointer.rsplit_once('/').unwrap();
        match setup.pointer_mut(parent).unwrap() {
            Value::Object(members) if value.is_null() => drop(members.remove(name)),
            Value::Object(members) => drop(members.insert(name.into(), value)),
            Value::Array(values) => values[name.parse::<usize>().unwrap()] = value,
            other => panic!("{pointer} points into {other}"),
        }
        let error = load_text(&setup.to_string()).unwrap_err().to_string();
        assert!(error.contains(message) && error.contains("setup.json"), "{pointer}: {error}");
    }
}

#[test]
fn objects_move_between_their_keyframes() {
    let mut setup = evening();
    let key = |time: f32, x: f32, yaw: f32| json!({"time": time, "position": [x, 0, 0], "yaw_deg": yaw});
    setup["objects"] = json!([
        {"file": "a.glb", "clip": "Walk", "path": [key(1.0, 0.0, 0.0), key(3.0, 4.0, 90.0)]},
        {"file": "b.glb", "position": [1, 2, 3], "scale": 2}
    ]);
    let setup = load_text(&setup.to_string()).unwrap();
    let [moving, still] = &setup.objects[..] else { panic!("{:?}", setup.objects) };
    let x = |time: f32| moving.placement(time).translation.x;
    assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(x), [0.0, 0.0, 2.0, 4.0, 4.0]);
    let forward = moving.placement(2.0).direction(Vec3::X);
    assert!(forward.abs_diff_eq(Vec3::new(0.5f32.sqrt(), 0.0, -0.5f32.sqrt()), 1e-6), "{forward}");
    assert_eq!((moving.clip.as_deref(), moving.end()), (Some("Walk"), 3.0));
    assert_eq!(
        (still.placement(5.0).translation, still.placement(5.0).scale),
        (Vec3::new(1.0, 2.0, 3.0), 2.0)
    );
}

#[test]
fn what_is_no_json_is_refused() {
    for text in ["", "[]", "{", "nonsense", "{\"version\": NaN}", &"[".repeat(100_000)] {
        assert!(matches!(load_text(text), Err(SceneError::Setup { .. })), "{text}");
    }
    let missing = Setup::load(std::path::Path::new("/no/such/setup.json")).unwrap_err();
    assert!(missing.to_string().contains("cannot read /no/such/setup.json"), "{missing}");
}

#[test]
fn scenes_without_a_setup_get_a_view_and_light() {
    let lit = Setup::from_scene(&glb::load_asset("cornell.glb"));
    assert!(lit.lighting.sky.is_black() && lit.lighting.emissive_scale == 1.0);
    let scene = glb::load_asset("rooms.glb");
    let setup = Setup::from_scene(&scene);
    assert!(!setup.lighting.sky.is_black());
    let camera = setup.camera(None).unwrap();
    // Every vertex lies inside the picture: no further from its axis than the top edge.
    let size = Vec2::new(camera.width as f32, camera.height as f32);
    let axis = camera.ray_direction(size * 0.5);
    let limit = axis.dot(camera.ray_direction(Vec2::new(size.x * 0.5, 0.0)));
    let inside = |position: &Vec3| (*position - camera.position).normalize().dot(axis) >= limit;
    assert!(scene.positions.iter().all(inside));
    let mut moved = camera.clone();
    moved.position = camera.position.lerp(camera.target, 0.6);
    let inside = |position: &Vec3| (*position - moved.position).normalize().dot(axis) >= limit;
    assert!(!scene.positions.iter().all(inside), "the comparison never fails");
}
