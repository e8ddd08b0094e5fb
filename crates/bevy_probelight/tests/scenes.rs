//! Scenes that come and go, several at once, and light that changes.

mod support;

use std::sync::Arc;

use bevy::asset::LoadState;
use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy_probelight::probelight_asset::BakedScene;
use bevy_probelight::probelight_runtime::{LodLevel, LodSettings};
use bevy_probelight::{
    Probelight, ProbelightInstance, ProbelightScene, ProbelightSettings, ProbelightSky, RenderScenes,
};
use support::{
    cornell, frames_of, has_gpu, headless_app, headless_app_in, read_image, settle, spawn_camera, spawn_scene,
};

fn lightmap_of(app: &App, scene: Entity) -> Handle<Image> {
    app.world().get::<ProbelightInstance>(scene).expect("the scene is shown").lightmap().clone()
}

fn mean(texels: &[Vec3]) -> Vec3 {
    texels.iter().sum::<Vec3>() / texels.len() as f32
}

fn spawn_lamp(app: &mut App, position: Vec3) -> Entity {
    let light = PointLight { intensity: 1000.0, ..default() };
    app.world_mut().spawn((light, Transform::from_translation(position))).id()
}

const LAMP: Vec3 = Vec3::new(1.0, 3.4, 1.6);

fn camera() -> Transform {
    Transform::from_xyz(2.78, 2.73, -6.2).looking_at(Vec3::new(2.78, 2.73, 0.0), Vec3::Y)
}

/// Updates until a file is loaded, and shown or refused.
fn wait_for(app: &mut App, handle: &Handle<ProbelightScene>) -> LoadState {
    for _ in 0..2000 {
        app.update();
        let state = app.world().resource::<AssetServer>().load_state(handle);
        if matches!(state, LoadState::Loaded | LoadState::Failed(_)) {
            app.update();
            return state;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    panic!("loading takes forever");
}

#[test]
fn a_moved_lamp_changes_the_lightmap_in_the_next_frame_and_still_light_costs_nothing() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    spawn_camera(&mut app, camera());
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    let lamp = spawn_lamp(&mut app, LAMP);
    settle(&mut app, scene);
    let lightmap = lightmap_of(&app, scene);
    let still = read_image(&app, &lightmap);
    assert!(mean(&still).min_element() > 0.01, "it is dark: {}", mean(&still));

    let frames = frames_of(&app, scene);
    app.update();
    assert_eq!(frames_of(&app, scene), frames, "still light is computed");
    assert_eq!(read_image(&app, &lightmap), still);

    app.world_mut().get_mut::<Transform>(lamp).unwrap().translation.x = 4.5;
    app.update();
    assert_eq!(lightmap_of(&app, scene), lightmap);
    let moved = read_image(&app, &lightmap);
    let difference =
        still.iter().zip(&moved).map(|(a, b)| (*a - *b).abs()).sum::<Vec3>() / still.len() as f32;
    assert!(difference.max_element() > 0.1 * mean(&still).max_element(), "nothing changed: {difference}");

    // Times are read back some frames later.
    for _ in 0..4 {
        app.update();
    }
    let diagnostics = app.world().resource::<DiagnosticsStore>();
    let measured =
        diagnostics.iter().any(|diagnostic| diagnostic.path().as_str() == "render/probelight/elapsed_cpu");
    assert!(measured, "frames of light are not measured");
}

#[test]
fn the_first_frame_is_nearly_as_bright_as_the_last() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    spawn_lamp(&mut app, LAMP);
    while frames_of(&app, scene).is_none() {
        app.update();
    }
    assert_eq!(frames_of(&app, scene), Some(1));
    let lightmap = lightmap_of(&app, scene);
    let first = mean(&read_image(&app, &lightmap));
    settle(&mut app, scene);
    let last = mean(&read_image(&app, &lightmap));
    assert!((first / last).min_element() > 0.95, "{first} is far from {last}");
}

#[test]
fn looking_around_costs_something_only_with_levels_of_detail() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    spawn_camera(&mut app, camera());
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    settle(&mut app, scene);
    app.update();
    let look_around = |app: &mut App| {
        let before = frames_of(app, scene).unwrap();
        let mut cameras = app.world_mut().query_filtered::<&mut Transform, With<Camera3d>>();
        cameras.single_mut(app.world_mut()).unwrap().translation.x += 0.3;
        app.update();
        frames_of(app, scene).unwrap() - before
    };
    assert_eq!(look_around(&mut app), 0);
    let far = LodLevel { distance: 3.0, rank: Some(8), ..LodLevel::default() };
    let lod = LodSettings { levels: vec![LodLevel::default(), far], ..LodSettings::default() };
    app.insert_resource(ProbelightSettings { lod, ..ProbelightSettings::default() });
    settle(&mut app, scene);
    app.update();
    settle(&mut app, scene);
    app.update();
    assert_eq!(look_around(&mut app), 1);
}

#[test]
fn colour_and_emission_of_materials_are_followed() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    spawn_camera(&mut app, camera());
    settle(&mut app, scene);
    let lightmap = lightmap_of(&app, scene);
    let handle = app.world().get::<Probelight>(scene).unwrap().0.clone();
    let asset = app.world().resource::<Assets<ProbelightScene>>().get(&handle).unwrap();
    let named = |name: &str| {
        let index = asset.baked.scene.materials.iter().position(|material| material.name == name).unwrap();
        asset.materials[index].clone()
    };
    let (lamp, white) = (named("light"), named("white"));
    let before = mean(&read_image(&app, &lightmap));
    let change = |app: &mut App, handle: &Handle<StandardMaterial>, f: &dyn Fn(&mut StandardMaterial)| {
        let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
        f(&mut materials.get_mut(handle).unwrap());
    };
    change(&mut app, &lamp, &|material| material.emissive *= 2.0);
    settle(&mut app, scene);
    let brighter = mean(&read_image(&app, &lightmap));
    assert!((brighter / before - 2.0).abs().max_element() < 0.01, "{brighter} instead of twice {before}");

    change(&mut app, &white, &|material| material.base_color = Color::linear_rgb(0.7, 0.1, 0.1));
    settle(&mut app, scene);
    let redder = mean(&read_image(&app, &lightmap));
    assert!(redder.y / redder.x < 0.9 * brighter.y / brighter.x, "{redder} is no redder than {brighter}");
}

#[test]
fn a_file_is_loaded_dropped_and_loaded_again() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let image = spawn_camera(&mut app, camera());
    spawn_lamp(&mut app, LAMP);
    let mut pictures = Vec::new();
    for _ in 0..2 {
        let handle = app.world().resource::<AssetServer>().load("cornell.plight");
        let scene = app.world_mut().spawn(Probelight(handle.clone())).id();
        assert!(matches!(wait_for(&mut app, &handle), LoadState::Loaded));
        settle(&mut app, scene);
        app.update();
        pictures.push(read_image(&app, &image));
        let parts = app.world().get::<ProbelightInstance>(scene).unwrap().parts().to_vec();
        assert!(parts.iter().all(|part| app.world().get::<Mesh3d>(*part).is_some()));
        app.world_mut().despawn(scene);
        drop(handle);
        for _ in 0..3 {
            app.update();
        }
        assert_eq!(frames_of(&app, scene), None, "its runtime stays");
        assert!(parts.iter().all(|part| app.world().get_entity(*part).is_err()));
        assert_eq!(mean(&read_image(&app, &image)), Vec3::ZERO, "it is still drawn");
    }
    assert!(mean(&pictures[0]).min_element() > 0.0);
    let difference =
        pictures[0].iter().zip(&pictures[1]).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(
        difference < 1e-3 * mean(&pictures[0]).max_element(),
        "the second is not the first: {difference}"
    );
}

#[test]
fn two_scenes_have_light_of_their_own() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    spawn_camera(&mut app, camera());
    app.insert_resource(ProbelightSky::Uniform(Vec3::splat(0.1)));
    let far = Transform::from_xyz(100.0, 0.0, 0.0);
    let [near, other, stretched] = [Transform::IDENTITY, far, far.with_scale(Vec3::new(1.0, 2.0, 1.0))]
        .map(|transform| spawn_scene(&mut app, cornell(), transform));
    spawn_lamp(&mut app, LAMP);
    spawn_lamp(&mut app, LAMP + far.translation + Vec3::X);
    for scene in [near, other, stretched] {
        settle(&mut app, scene);
    }
    let [a, b, c] = [near, other, stretched].map(|scene| read_image(&app, &lightmap_of(&app, scene)));
    assert!(mean(&a).min_element() > 0.01 && mean(&b).min_element() > 0.01);
    assert_ne!(a, b, "both have the light of one");
    // What cannot be lit stays dark, and the rest goes on.
    assert_eq!(mean(&c), Vec3::ZERO);
}

#[test]
fn a_file_that_changes_is_shown_anew() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.plight");
    cornell().write(&path).unwrap();
    let mut app = headless_app_in(folder.path().to_str().unwrap());
    spawn_camera(&mut app, camera());
    spawn_lamp(&mut app, LAMP);
    let handle = app.world().resource::<AssetServer>().load("scene.plight");
    let scene = app.world_mut().spawn(Probelight(handle.clone())).id();
    wait_for(&mut app, &handle);
    settle(&mut app, scene);
    let before = lightmap_of(&app, scene);
    let old_light = mean(&read_image(&app, &before));

    // The same scene painted darker.
    let mut parts = cornell().into_parts();
    for material in &mut Arc::make_mut(&mut parts.scene).materials {
        material.base_color *= 0.2;
    }
    BakedScene::new(parts).unwrap().write(&path).unwrap();
    app.world().resource::<AssetServer>().reload("scene.plight");
    for _ in 0..2000 {
        app.update();
        if lightmap_of(&app, scene) != before {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    settle(&mut app, scene);
    let after = mean(&read_image(&app, &lightmap_of(&app, scene)));
    assert!(after.max_element() < 0.5 * old_light.max_element(), "{after} is no darker than {old_light}");
    assert!(after.min_element() > 0.0);
    let parts = app.world().get::<ProbelightInstance>(scene).unwrap().parts().len();
    assert_eq!(app.world().get::<Children>(scene).unwrap().len(), parts, "children of the old scene stay");
}

#[test]
fn scenes_that_the_renderer_forgot_are_made_anew() {
    if !has_gpu() {
        return;
    }
    let mut app = headless_app();
    let image = spawn_camera(&mut app, camera());
    spawn_lamp(&mut app, LAMP);
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    settle(&mut app, scene);
    app.update();
    let (before, frames) = (read_image(&app, &image), frames_of(&app, scene).unwrap());
    // As at the start on another device.
    app.sub_app_mut(RenderApp).world_mut().insert_resource(RenderScenes::default());
    app.update();
    assert!(frames_of(&app, scene).unwrap() < frames, "it is the old runtime");
    settle(&mut app, scene);
    app.update();
    let after = read_image(&app, &image);
    let apart = before.iter().zip(&after).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(apart < 1e-3 * mean(&before).max_element(), "the second runtime lights otherwise: {apart}");
}

#[test]
fn broken_files_are_refused_by_the_loader() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = headless_app_in(folder.path().to_str().unwrap());
    let mut bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cornell.plight")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(folder.path().join("broken.plight"), bytes).unwrap();
    let handle = app.world().resource::<AssetServer>().load("broken.plight");
    let scene = app.world_mut().spawn(Probelight(handle.clone())).id();
    let state = wait_for(&mut app, &handle);
    assert!(matches!(state, LoadState::Failed(_)), "{state:?}");
    assert!(app.world().get::<ProbelightInstance>(scene).is_none());
}
