//! Meshes that are not part of the bake get the light of free space where they are.

mod support;

use std::f32::consts::PI;

use bevy::camera::Exposure;
use bevy::prelude::*;
use bevy_probelight::probelight_math::glam::Vec3 as SceneVec3;
use bevy_probelight::probelight_runtime::FrameInput;
use bevy_probelight::probelight_scene::{Light, Lighting};
use bevy_probelight::{GridLitMaterial, ProbelightInstance, ProbelightMover, ProbelightShadowCaster};
use support::truth::{Truth, relative_error};
use support::{
    SIZE, cornell, frames_of, has_gpu, headless_app, read_image, settle, spawn_camera, spawn_scene,
};

const LAMP: Vec3 = Vec3::new(1.0, 3.4, 1.6);
const RADIUS: f32 = 0.4;
const CANDELA: f32 = 80.0;

/// A white ball without gloss; Bevy's lamp does not light it, as the camera looks at its far side.
fn spawn_ball(app: &mut App, place: Vec3) -> Entity {
    let world = app.world_mut();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(Sphere::new(RADIUS).mesh().ico(20).unwrap());
    let material = StandardMaterial { reflectance: 0.0, perceptual_roughness: 1.0, ..default() };
    let material = world.resource_mut::<Assets<StandardMaterial>>().add(material);
    let ball = (Mesh3d(mesh), MeshMaterial3d(material), Transform::from_translation(place));
    world.spawn((ball, ProbelightMover::default())).id()
}

/// Irradiance on the ball by the picture and by the CPU.
fn compare(
    truth: &Truth,
    picture: &[Vec3],
    camera: &Transform,
    ball: Vec3,
    looked_up: Vec3,
) -> Vec<(Vec3, Vec3)> {
    let exposure = Exposure::default().exposure();
    let height = (PI / 8.0).tan();
    let share = |at: u32| 2.0 * (at as f32 + 0.5) / SIZE as f32 - 1.0;
    let on_ball = |pixel: u32| {
        let local = Vec3::new(share(pixel % SIZE) * height, -share(pixel / SIZE) * height, -1.0);
        let direction = (camera.rotation * local).normalize();
        let to_ball = ball - camera.translation;
        let along = to_ball.dot(direction);
        let squared = RADIUS * RADIUS - (to_ball.length_squared() - along * along);
        // The rim, where the mesh is no ball, is left out; so is what the lamp may light.
        let distance = (squared > 0.2 * RADIUS * RADIUS).then(|| along - squared.sqrt())?;
        let normal = (camera.translation + distance * direction - ball) / RADIUS;
        if normal.dot((LAMP - ball).normalize()) > -0.05 {
            return None;
        }
        let of = |v: Vec3| SceneVec3::from_array(v.to_array());
        let wanted = truth.runtime.irradiance_in_air(of(looked_up + RADIUS * normal), of(normal))?;
        let found = picture[pixel as usize] / exposure * PI;
        Some((found, Vec3::from_array(wanted.to_array())))
    };
    let pairs: Vec<_> = (0..SIZE * SIZE).filter_map(on_ball).collect();
    assert!(pairs.len() > 200, "the camera hardly sees the ball: {}", pairs.len());
    pairs
}

#[test]
fn movers_are_lit_as_the_grid_says_in_their_first_frame() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let place = Vec3::new(4.3, 1.4, 0.6);
    let camera = Transform::from_xyz(5.2, 1.2, -1.2).looking_at(place, Vec3::Y);
    let image = spawn_camera(&mut app, camera);
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    let lamp = PointLight { intensity: 4.0 * PI * CANDELA, range: 1000.0, color: Color::WHITE, ..default() };
    app.world_mut().spawn((lamp, Transform::from_translation(LAMP)));
    settle(&mut app, scene);

    let ball = spawn_ball(&mut app, place);
    app.update();
    assert!(app.world().get::<MeshMaterial3d<GridLitMaterial>>(ball).is_some());
    let picture = read_image(&app, &image);

    let of = |v: Vec3| SceneVec3::from_array(v.to_array());
    let lamp = Light::Point { position: of(LAMP), intensity: SceneVec3::splat(CANDELA), range: None };
    let mut truth = Truth::new(cornell(), Lighting { lights: vec![lamp], ..Lighting::default() });
    truth.runtime.step(&FrameInput { whole_grid: true, ..FrameInput::default() });
    let error = relative_error(&compare(&truth, &picture, &camera, place, place));
    assert!(error < 0.02, "light in free space differs by {error}");
    // A ball elsewhere has other light.
    let elsewhere = relative_error(&compare(&truth, &picture, &camera, place, Vec3::new(1.2, 1.4, 3.0)));
    assert!(elsewhere > 0.1, "another place is not seen: {elsewhere}");
}

#[test]
fn movers_follow_their_materials_and_give_them_back() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    spawn_camera(&mut app, Transform::from_xyz(2.78, 2.73, -6.2).looking_to(Vec3::Z, Vec3::Y));
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    let ball = spawn_ball(&mut app, Vec3::new(4.0, 1.0, 0.6));
    let standard = app.world().get::<MeshMaterial3d<StandardMaterial>>(ball).unwrap().0.clone();
    settle(&mut app, scene);
    let lit = app.world().get::<MeshMaterial3d<GridLitMaterial>>(ball).unwrap().0.clone();
    let red = Color::linear_rgb(0.9, 0.1, 0.1);
    app.world_mut().resource_mut::<Assets<StandardMaterial>>().get_mut(&standard).unwrap().base_color = red;
    for _ in 0..2 {
        app.update();
    }
    assert_eq!(app.world().resource::<Assets<GridLitMaterial>>().get(&lit).unwrap().base.base_color, red);

    // A mover that moves wants a frame of light, one that stands still wants none.
    let frames = frames_of(&app, scene);
    app.update();
    assert_eq!(frames_of(&app, scene), frames);
    app.world_mut().get_mut::<Transform>(ball).unwrap().translation.x = 3.0;
    app.update();
    assert_eq!(frames_of(&app, scene), frames.map(|count| count + 1));

    app.world_mut().despawn(scene);
    for _ in 0..2 {
        app.update();
    }
    assert_eq!(app.world().get::<MeshMaterial3d<StandardMaterial>>(ball).map(|m| &m.0), Some(&standard));
    assert!(app.world().get::<MeshMaterial3d<GridLitMaterial>>(ball).is_none());
}

#[test]
fn shadow_casters_stand_in_the_light_that_bounces() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    let lamp = PointLight { intensity: 4.0 * PI * CANDELA, range: 1000.0, ..default() };
    app.world_mut().spawn((lamp, Transform::from_translation(LAMP)));
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.5, 0.1, 1.5));
    settle(&mut app, scene);
    let lightmap = app.world().get::<ProbelightInstance>(scene).unwrap().lightmap().clone();
    let mean = |app: &App| read_image(app, &lightmap).iter().sum::<Vec3>().element_sum();
    let open = mean(&app);
    // A plate under the lamp, which nothing but its shadow is of.
    let under = Transform::from_translation(LAMP - 0.4 * Vec3::Y);
    let plate = app.world_mut().spawn((Mesh3d(mesh), under, ProbelightShadowCaster)).id();
    settle(&mut app, scene);
    let shaded = mean(&app);
    assert!(shaded < 0.9 * open, "the plate shades nothing: {shaded} of {open}");
    app.world_mut().get_mut::<Transform>(plate).unwrap().translation.y = -50.0;
    settle(&mut app, scene);
    let moved = mean(&app);
    assert!((moved / open - 1.0).abs() < 1e-3, "the plate shades from afar: {moved} of {open}");
    app.world_mut().get_mut::<Transform>(plate).unwrap().translation = under.translation;
    settle(&mut app, scene);
    app.world_mut().despawn(plate);
    settle(&mut app, scene);
    let gone = mean(&app);
    assert!((gone / open - 1.0).abs() < 1e-3, "the plate stays: {gone} of {open}");
}
