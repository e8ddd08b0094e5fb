//! Irradiance read back from a picture of Bevy's against Probelight's own runtime on the CPU: units, texture coordinates, and
//! that the light is the present one.

mod support;

use std::f32::consts::PI;

use bevy::camera::Exposure;
use bevy::prelude::*;
use bevy_probelight::probelight_math::glam::{Vec2, Vec3 as SceneVec3};
use bevy_probelight::probelight_scene::{Light, Lighting, Sky};
use bevy_probelight::{ProbelightIgnore, ProbelightSky};
use support::truth::{Truth, relative_error};
use support::{
    SIZE, cornell, has_gpu, headless_app, make_diffuse, read_image, settle, spawn_camera, spawn_scene,
};

/// Luminous intensity of the lamp, candela.
const CANDELA: SceneVec3 = SceneVec3::new(40.0, 30.0, 20.0);

fn lighting(position: SceneVec3) -> Lighting {
    let of = |v: Vec3| SceneVec3::from_array(v.to_array());
    let lamp = Light::Point { position, intensity: CANDELA, range: None };
    let spot = Light::Spot {
        position: of(SPOT),
        direction: of(SPOT_DIRECTION.normalize()),
        intensity: CANDELA,
        inner_angle: 0.3,
        outer_angle: 0.5,
        range: None,
    };
    let sun = Light::Directional { direction: of(SUN.normalize()), irradiance: SceneVec3::splat(6.0) };
    Lighting {
        lights: vec![lamp, spot, sun],
        sky: Sky::Uniform(SceneVec3::new(0.2, 0.4, 0.8)),
        ..Lighting::default()
    }
}

/// A lamp like that in Bevy, whose own light on surfaces is left out of the picture.
fn lamp(position: Vec3) -> impl Bundle {
    let light = PointLight {
        color: Color::linear_rgb(1.0, CANDELA.y / CANDELA.x, CANDELA.z / CANDELA.x),
        intensity: 4.0 * PI * CANDELA.x,
        range: 1000.0,
        affects_lightmapped_mesh_diffuse: false,
        ..default()
    };
    (light, Transform::from_translation(position))
}

/// A spot like that.
fn spot(position: Vec3, direction: Vec3) -> impl Bundle {
    let light = SpotLight {
        color: Color::linear_rgb(1.0, CANDELA.y / CANDELA.x, CANDELA.z / CANDELA.x),
        intensity: 4.0 * PI * CANDELA.x,
        range: 1000.0,
        inner_angle: 0.3,
        outer_angle: 0.5,
        affects_lightmapped_mesh_diffuse: false,
        ..default()
    };
    (light, Transform::from_translation(position).looking_to(direction, Vec3::Y))
}

/// A sun like that.
fn sun(direction: Vec3) -> impl Bundle {
    let light = DirectionalLight {
        color: Color::WHITE,
        illuminance: 6.0,
        affects_lightmapped_mesh_diffuse: false,
        ..default()
    };
    (light, Transform::default().looking_to(direction, Vec3::Y))
}

const SPOT: Vec3 = Vec3::new(4.0, 3.0, 0.5);
const SPOT_DIRECTION: Vec3 = Vec3::new(-0.5, -1.0, 1.0);
/// Through the open side of the box.
const SUN: Vec3 = Vec3::new(0.3, -0.5, 1.0);
const LAMP: Vec3 = Vec3::new(1.0, 3.4, 1.6);

/// Irradiance by the picture and by the CPU, where the camera sees what reflects.
fn compare(
    truth: &Truth,
    picture: &[Vec3],
    camera: &Transform,
    scene: &Transform,
    shift: Vec2,
) -> Vec<(Vec3, Vec3)> {
    let exposure = Exposure::default().exposure();
    let compared = |pixel: u32| {
        let hit = truth.hit(camera, scene, pixel)?;
        let color = truth.color(&hit);
        let wanted = truth.irradiance(&hit, shift)?;
        // Bevy's pictures hold exposure · colour · E / π.
        (color != Vec3::ZERO).then(|| (picture[pixel as usize] / (color * exposure) * PI, wanted))
    };
    let pairs: Vec<_> = (0..SIZE * SIZE).filter_map(compared).collect();
    assert!(pairs.len() as u32 > SIZE * SIZE / 2, "the camera hardly sees the scene: {}", pairs.len());
    pairs
}

fn draw(camera: &Transform, scene: &Transform) -> Vec<Vec3> {
    let mut app = headless_app();
    app.insert_resource(ProbelightSky::Uniform(Vec3::new(0.2, 0.4, 0.8)));
    let image = spawn_camera(&mut app, *camera);
    let shown = spawn_scene(&mut app, cornell(), *scene);
    make_diffuse(&mut app, shown);
    // An ignored light, and a hidden one, change nothing.
    let place = |local: Vec3| scene.transform_point(local);
    app.world_mut().spawn((lamp(place(Vec3::new(4.0, 1.0, 1.0))), ProbelightIgnore));
    app.world_mut().spawn((lamp(place(Vec3::new(4.0, 1.0, 2.0))), Visibility::Hidden));
    app.world_mut().spawn(lamp(place(LAMP)));
    app.world_mut().spawn(spot(place(SPOT), scene.rotation * SPOT_DIRECTION));
    app.world_mut().spawn(sun(scene.rotation * SUN));
    settle(&mut app, shown);
    app.update();
    read_image(&app, &image)
}

#[test]
fn pictures_hold_the_irradiance_of_our_own_runtime() {
    if !has_gpu() {
        return;
    }
    let camera = Transform::from_xyz(2.78, 2.73, -6.2).looking_at(Vec3::new(2.78, 2.73, 0.0), Vec3::Y);
    let here = Transform::IDENTITY;
    let picture = draw(&camera, &here);
    let truth = Truth::new(cornell(), lighting(SceneVec3::from_array(LAMP.to_array())));
    let error = relative_error(&compare(&truth, &picture, &camera, &here, Vec2::ZERO));
    assert!(error < 0.01, "irradiance differs by {error}");

    // Beside the place, and under another lamp, the comparison must fail.
    let beside = relative_error(&compare(&truth, &picture, &camera, &here, Vec2::new(3.0, 0.0)));
    assert!(beside > 0.02, "a shift of the lightmap is not seen: {beside}");
    let other = Truth::new(cornell(), lighting(SceneVec3::new(3.0, 3.4, 1.6)));
    let other = relative_error(&compare(&other, &picture, &camera, &here, Vec2::ZERO));
    assert!(other > 0.05, "another lamp is not seen: {other}");
}

#[test]
fn a_scene_that_was_moved_turned_and_scaled_is_lit_alike() {
    if !has_gpu() {
        return;
    }
    let scene = Transform::from_xyz(-3.0, 1.0, 20.0)
        .with_rotation(Quat::from_rotation_y(0.6))
        .with_scale(Vec3::splat(2.0));
    let place = |local: Vec3| scene.transform_point(local);
    let (eye, target) = (place(Vec3::new(2.78, 2.73, -6.2)), place(Vec3::new(2.78, 2.73, 0.0)));
    let camera = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    let picture = draw(&camera, &scene);
    // Twice as far away, a lamp lights a quarter.
    let mut lighting = lighting(SceneVec3::from_array(LAMP.to_array()));
    for light in &mut lighting.lights {
        if let Light::Point { intensity, .. } | Light::Spot { intensity, .. } = light {
            *intensity /= 4.0;
        }
    }
    let truth = Truth::new(cornell(), lighting);
    let error = relative_error(&compare(&truth, &picture, &camera, &scene, Vec2::ZERO));
    assert!(error < 0.01, "irradiance differs by {error}");
}
