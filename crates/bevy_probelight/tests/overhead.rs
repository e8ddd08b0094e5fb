//! What the plugin costs on the CPU, frame by frame. A measurement, run by hand:
//!
//! ```sh
//! PROBELIGHT_SCENE=$PWD/atrium.plight cargo test --release -p bevy_probelight --test overhead -- --ignored --nocapture
//! ```

#![allow(clippy::print_stdout, reason = "it is what the measurement is for")]

mod support;

use std::path::Path;
use std::time::Instant;

use bevy::prelude::*;
use bevy_probelight::ProbelightPlugin;
use bevy_probelight::probelight_asset::BakedScene;
use support::{cornell, has_gpu, headless_app_of, new_scene, settle, spawn_scene};

/// Frames of each app, and how many of them go by before.
const FRAMES: usize = 1000;
const WARM_UP: usize = 150;

fn scene() -> BakedScene {
    match std::env::var_os("PROBELIGHT_SCENE") {
        Some(path) => BakedScene::read(Path::new(&path)).unwrap(),
        None => cornell(),
    }
}

/// Twenty lamps, and a camera that draws nothing, so that the GPU has nothing to do with it.
fn app(add: impl FnOnce(&mut App)) -> App {
    let mut app = headless_app_of(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"), default(), add);
    for i in 0..20 {
        let place = Transform::from_xyz(i as f32 - 10.0, 2.0, 0.3 * i as f32);
        app.world_mut().spawn((PointLight { intensity: 1000.0, ..default() }, place));
    }
    app.world_mut().spawn((Camera3d::default(), Camera { is_active: false, ..default() }));
    app
}

/// A scene's meshes without its light.
fn spawn_meshes(app: &mut App) {
    let scene = new_scene(app, scene());
    for part in &scene.parts {
        let material = scene.materials[part.material].clone();
        app.world_mut().spawn((Mesh3d(part.mesh.clone()), MeshMaterial3d(material)));
    }
}

/// Medians of the frames of some apps, which take turns, milliseconds.
fn medians<const N: usize>(apps: &mut [App; N]) -> [f64; N] {
    let mut times = [const { Vec::new() }; N];
    for frame in 0..WARM_UP + FRAMES {
        for (app, times) in apps.iter_mut().zip(&mut times) {
            let start = Instant::now();
            app.update();
            if frame >= WARM_UP {
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[FRAMES / 2]
    })
}

#[test]
#[ignore = "a measurement, which needs a quiet machine"]
fn what_a_frame_costs_on_the_cpu() {
    if !has_gpu() {
        return;
    }
    let mut bare = app(|_| {});
    let mut idle = app(|app| {
        app.add_plugins(ProbelightPlugin);
    });
    spawn_meshes(&mut bare);
    spawn_meshes(&mut idle);
    let mut lit = app(|app| {
        app.add_plugins(ProbelightPlugin);
    });
    let shown = spawn_scene(&mut lit, scene(), Transform::IDENTITY);
    settle(&mut lit, shown);
    let mut cameras = lit.world_mut().query::<&mut Camera>();
    cameras.iter_mut(lit.world_mut()).for_each(|mut camera| camera.is_active = false);
    let [bare, idle, lit] = medians(&mut [bare, idle, lit]);
    println!("a frame without the plugin        {bare:.3} ms");
    println!("more with it, but no scene        {:.3} ms", idle - bare);
    println!("more with a scene in still light  {:.3} ms", lit - bare);
}
