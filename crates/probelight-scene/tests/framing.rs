//! The view of a scene that came without a camera.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{Camera, Scene, Setup};

fn framing_camera(scene: &Scene) -> Camera {
    Setup::from_scene(scene).camera(None).unwrap().clone()
}

/// Distance along a unit direction at which a ray meets a triangle, metres (Möller and Trumbore 1997).
fn hit_distance(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    let from_a = origin - a;
    let u = from_a.dot(across) / determinant;
    let beside = from_a.cross(ab);
    let v = direction.dot(beside) / determinant;
    let distance = ac.dot(beside) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}

/// Share of the picture's surface points that are front faces or double-sided.
fn front_share(scene: &Scene, camera: &Camera) -> f64 {
    let (mut surfaces, mut fronts) = (0, 0);
    for pixel in 0..20 * 15u32 {
        let at = Vec2::new((pixel % 20) as f32 + 0.5, (pixel / 20) as f32 + 0.5) * 32.0;
        let direction = camera.ray_direction(at);
        let nearest = (0..scene.triangles.len())
            .filter_map(|t| Some((hit_distance(camera.position, direction, scene.corners(t))?, t)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, triangle)) = nearest else { continue };
        surfaces += 1;
        let is_front = scene.geometric_normal(triangle).dot(direction) < 0.0;
        fronts += u32::from(is_front || scene.material(triangle).double_sided);
    }
    assert!(surfaces > 20, "the scene is in the picture");
    f64::from(fronts) / f64::from(surfaces)
}

#[test]
fn a_box_is_seen_through_its_open_side() {
    let mut scene = glb::load_asset("cornell.glb");
    let camera = framing_camera(&scene);
    assert!(camera.position.z < scene.bounds().min.z);
    assert!(front_share(&scene, &camera) > 0.95);
    let behind = Camera { position: 2.0 * camera.target - camera.position, ..camera };
    assert!(front_share(&scene, &behind) < 0.1, "the comparison never fails");

    for position in &mut scene.positions {
        *position = Vec3::new(position.z, position.y, -position.x);
    }
    let turned = framing_camera(&scene);
    assert!(turned.position.x < scene.bounds().min.x);
    assert!(front_share(&scene, &turned) > 0.95);
}

#[test]
fn a_closed_room_is_seen_from_inside() {
    let scene = glb::load_asset("furnace.glb");
    let camera = framing_camera(&scene);
    assert!(scene.bounds().contains(camera.position));
    assert_eq!(front_share(&scene, &camera), 1.0);
}

#[test]
fn buildings_are_seen_from_outside() {
    for name in ["rooms.glb", "atrium.glb"] {
        let scene = glb::load_asset(name);
        let camera = framing_camera(&scene);
        assert!(!scene.bounds().contains(camera.position), "{name}");
        assert!(front_share(&scene, &camera) > 0.95, "{name}");
    }
}
