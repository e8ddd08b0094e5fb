//! A device that cannot run frames of light. A test binary of its own: Bevy remembers for the whole process what a device can do.

mod support;

use bevy::prelude::*;
use bevy::render::settings::{WgpuLimits, WgpuSettings};
use bevy_probelight::{ProbelightInstance, ProbelightMover};
use support::{cornell, frames_of, has_gpu, headless_app_with, read_image, spawn_camera, spawn_scene};

#[test]
fn devices_that_lack_what_is_needed_leave_scenes_unlit() {
    if !has_gpu() {
        return;
    }
    let weak = WgpuLimits { max_texture_dimension_2d: 8192, ..WgpuLimits::downlevel_webgl2_defaults() };
    let gpu = WgpuSettings { constrained_limits: Some(weak), ..WgpuSettings::default() };
    let mut app = headless_app_with(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"), gpu);
    let image = spawn_camera(&mut app, Transform::from_xyz(2.8, 2.7, -6.2).looking_to(Vec3::Z, Vec3::Y));
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    app.world_mut().spawn((PointLight::default(), Transform::from_xyz(1.0, 3.4, 1.6)));
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(Sphere::new(0.3));
    let material =
        app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial::default());
    let mover = (
        Mesh3d(mesh),
        MeshMaterial3d(material),
        ProbelightMover::default(),
        Transform::from_xyz(2.0, 1.0, 0.5),
    );
    let mover = app.world_mut().spawn(mover).id();
    // Bevy's own shaders may take some frames to be there.
    let is_dark = |app: &App| read_image(app, &image).iter().all(|texel| *texel == Vec3::ZERO);
    for _ in 0..500 {
        app.update();
        if !is_dark(&app) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(frames_of(&app, scene), None);
    assert!(app.world().get::<MeshMaterial3d<StandardMaterial>>(mover).is_some(), "it reads a grid");
    assert!(app.world().get::<ProbelightInstance>(scene).is_some());
    assert!(!is_dark(&app), "nothing is drawn");
}
