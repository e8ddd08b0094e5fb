//! Irradiance at world positions: the right surface, the right side.
#![cfg(feature = "cpu")]

mod support;

use probelight_asset::{LightmapFace, NONE};
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::Scene;
use support::{add_quad, checked, horizontal_quad, material, single_probe, uniform_sky};

/// A face whose triangle lies entirely in one texel.
fn face(texel: usize) -> LightmapFace {
    LightmapFace { corners: [Vec2::new(texel as f32 + 0.5, 0.5); 3] }
}

/// Distance between the two quads of the thin wall.
const THICKNESS: f32 = 1e-3;

/// A sheet with light on both sides (1 above, 2 below), and beside it a thin wall of two quads that face
/// outwards (4 above, 8 below) and have no light on their inner sides. The sky's radiance is 1.
fn sheet_and_wall() -> Runtime {
    let mut scene = Scene { materials: vec![material(Vec3::ONE, Vec3::ZERO)], ..Scene::default() };
    add_quad(&mut scene, horizontal_quad(Vec3::ZERO), 0);
    add_quad(&mut scene, horizontal_quad(Vec3::X * 5.0), 0);
    let mut below = horizontal_quad(Vec3::X * 5.0 - Vec3::Y * THICKNESS);
    below.reverse();
    add_quad(&mut scene, below, 0);
    let mut baked = single_probe(scene, None, &[1.0, 2.0, 4.0, 8.0]);
    baked.lightmap.faces = [0, 0, 2, 2, 3, 3, 1, 1].map(face).to_vec();
    baked.lightmap.back_faces = vec![6, 7, NONE, NONE, NONE, NONE];
    let mut runtime = Runtime::new(checked(baked));
    runtime.set_lighting(uniform_sky(Vec3::ONE)).unwrap();
    runtime.step(&FrameInput::default());
    runtime
}

/// Irradiance at a position on the side towards `normal`, as a whole number.
fn light_at(position: Vec3, normal: Vec3) -> Option<f32> {
    sheet_and_wall().irradiance_at(position, normal).map(|e| (e.x * 1e4).round() * 1e-4)
}

#[test]
fn each_side_of_a_sheet_has_its_own_light() {
    let inside = Vec3::new(0.3, 0.0, 0.1);
    assert_eq!(light_at(inside, Vec3::Y), Some(1.0));
    assert_eq!(light_at(inside, -Vec3::Y), Some(2.0));
    let tilted = Vec3::new(0.5, 1.0, 0.0).normalize();
    assert_eq!(light_at(inside, tilted), Some(1.0));
}

#[test]
fn sides_of_a_thin_wall_are_told_apart() {
    let (above, below) = (Vec3::new(5.2, 0.0, 0.3), Vec3::new(5.2, -THICKNESS, 0.3));
    assert_eq!(light_at(above, Vec3::Y), Some(4.0));
    assert_eq!(light_at(below, -Vec3::Y), Some(8.0));
    // The sides that face each other inside the wall have no light of their own.
    assert_eq!(light_at(above, -Vec3::Y), Some(0.0));
    assert_eq!(light_at(below, Vec3::Y), Some(0.0));
}

#[test]
fn positions_may_be_rounded_but_not_far_off() {
    assert_eq!(light_at(Vec3::new(0.3, 5e-4, 0.1), Vec3::Y), Some(1.0));
    assert_eq!(light_at(Vec3::new(0.3, -5e-4, 0.1), Vec3::Y), Some(1.0));
    assert_eq!(light_at(Vec3::new(0.3, 0.5, 0.1), Vec3::Y), None);
    assert_eq!(light_at(Vec3::new(2.5, 0.0, 0.1), Vec3::Y), None);
    assert_eq!(light_at(Vec3::new(0.3, 0.0, 0.1), Vec3::X), None);
    assert_eq!(light_at(Vec3::NAN, Vec3::Y), None);
}
