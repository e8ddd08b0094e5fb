//! The examples without a window: each is drawn for some frames and leaves a picture in cargo's folder for temporary files.

#[path = "../examples/attach.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod attach;
#[path = "../examples/bake_in_app.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod bake_in_app;
#[path = "../examples/day_and_night.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod day_and_night;
#[path = "../examples/minimal.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod minimal;
#[path = "../examples/movers.rs"]
#[allow(dead_code, reason = "its main opens a window")]
mod movers;
mod support;

use std::path::Path;
use std::time::Duration;

use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy::time::TimeUpdateStrategy;
use bevy_probelight::probelight_bake::BakeOptions;
use bevy_probelight::{BakeFinished, BakeProgress, BakeScene, Probelight, ProbelightInstance};
use support::{aim_at_image, has_gpu, headless_app, read_bytes, settle};

/// Width and height of the pictures.
const SIZE: u32 = 320;

fn app() -> App {
    let mut app = headless_app();
    // Nothing moves by itself.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    app
}

/// Updates until the scene is there and its light stands still; draws into an image from then on.
fn show(app: &mut App) -> Handle<Image> {
    let mut shown = app.world_mut().query_filtered::<Entity, With<ProbelightInstance>>();
    let mut cameras = app.world_mut().query_filtered::<Entity, With<Camera3d>>();
    for _ in 0..2000 {
        app.update();
        if let (Ok(scene), Ok(camera)) = (shown.single(app.world()), cameras.single(app.world())) {
            settle(app, scene);
            let image = aim_at_image(app, camera, SIZE, TextureFormat::Rgba8UnormSrgb);
            for _ in 0..2 {
                app.update();
            }
            return image;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("the scene never appears");
}

/// Updates until something holds.
fn wait_until(app: &mut App, mut holds: impl FnMut(&App) -> bool) {
    for _ in 0..2000 {
        app.update();
        if holds(app) {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("it never happens");
}

/// Writes what an image shows; returns the mean sRGB value of red, green and blue.
fn write_picture(app: &App, image: &Handle<Image>, name: &str) -> [f64; 3] {
    let bytes = read_bytes(app, image);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
    image::save_buffer(&path, &bytes, SIZE, SIZE, image::ColorType::Rgba8).unwrap();
    std::array::from_fn(|channel| {
        let sum: f64 = bytes.iter().skip(channel).step_by(4).map(|byte| f64::from(*byte)).sum();
        sum / f64::from(SIZE * SIZE)
    })
}

#[test]
fn the_readme_has_the_minimal_example() {
    let example = include_str!("../examples/minimal.rs").replace("pub(crate) ", "");
    let code = example.split_once("\n\n").expect("its first lines say what it is").1;
    assert!(include_str!("../../../README.md").contains(code));
    assert!(code.lines().count() <= 15);
}

#[test]
fn minimal() {
    if !has_gpu() {
        return;
    }
    let mut app = app();
    app.add_systems(Startup, minimal::setup);
    let image = show(&mut app);
    let [red, green, blue] = write_picture(&app, &image, "minimal");
    assert!(red > 40.0 && green > 30.0 && blue > 20.0, "it is dark: {red} {green} {blue}");
}

#[test]
fn attach() {
    if !has_gpu() {
        return;
    }
    let copy = include_bytes!("../assets/cornell.glb");
    assert!(
        copy == include_bytes!("../../../assets/scenes/cornell.glb"),
        "it is not the file that was baked"
    );
    let mut app = app();
    attach::add(&mut app);
    let mut shown = app.world_mut().query::<&ProbelightInstance>();
    let mut is_attached =
        |app: &App| shown.single(app.world()).is_ok_and(|instance| instance.parts().len() == 4);
    wait_until(&mut app, &mut is_attached);
    let image = show(&mut app);
    let mut blueness = Vec::new();
    for (is_painted, name) in [(false, "attach"), (true, "attach_painted")] {
        app.world_mut().resource_mut::<attach::Paint>().0 = is_painted;
        for _ in 0..40 {
            app.update();
        }
        let [red, _, blue] = write_picture(&app, &image, name);
        assert!(red > 15.0, "it is dark");
        blueness.push(blue / red);
    }
    assert!(blueness[1] > 1.3 * blueness[0], "paint makes no difference: {blueness:?}");
}

#[test]
fn day_and_night() {
    if !has_gpu() {
        return;
    }
    let mut app = app();
    day_and_night::add(&mut app);
    app.insert_resource(day_and_night::Clock { hour: 10.0, is_held: true });
    let image = show(&mut app);
    let mut shown = app.world_mut().query_filtered::<Entity, With<ProbelightInstance>>();
    let scene = shown.single(app.world()).unwrap();
    let mut means = Vec::new();
    for (hour, name) in [(10.0, "day"), (17.2, "dusk"), (22.0, "night")] {
        app.world_mut().resource_mut::<day_and_night::Clock>().hour = hour;
        settle(&mut app, scene);
        app.update();
        means.push(write_picture(&app, &image, name));
    }
    assert!(means.iter().all(|mean| mean[0] > 15.0), "it is dark: {means:?}");
    // Blue sky by day, a warm lamp by night.
    assert!(
        means[2][2] / means[2][0] < 0.9 * means[0][2] / means[0][0],
        "night is not warmer than day: {means:?}"
    );
}

#[test]
fn movers() {
    if !has_gpu() {
        return;
    }
    let mut app = app();
    movers::add(&mut app);
    let image = show(&mut app);
    for (turns, name) in [(0.75, "movers_left"), (0.25, "movers_right")] {
        app.world_mut().resource_mut::<movers::Steps>().0 = turns;
        app.update();
        let mean = write_picture(&app, &image, name);
        assert!(mean[0] > 30.0, "it is dark: {mean:?}");
    }
}

#[test]
fn bake_in_app() {
    if !has_gpu() {
        return;
    }
    let mut app = app();
    bake_in_app::add(&mut app);
    app.insert_resource(bake_in_app::Wanted {
        file: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/cornell.glb"),
        options: BakeOptions {
            receivers: Some(3_000),
            gather_rays: Some(128),
            relight_rays: Some(64),
            grid_vertices: Some(0),
            ..BakeOptions::default()
        },
    });
    app.update();
    // A first bake is cancelled: nothing comes of it.
    let mut stages = app.world_mut().query_filtered::<Entity, With<bake_in_app::Stage>>();
    let stage = stages.single(app.world()).unwrap();
    let wanted = app.world().get::<BakeScene>(stage).expect("it bakes").clone();
    app.world_mut().entity_mut(stage).remove::<BakeScene>();
    for _ in 0..5 {
        app.update();
    }
    assert!(app.world().get::<Probelight>(stage).is_none());

    app.world_mut().entity_mut(stage).insert(wanted);
    let mut told = 0;
    for _ in 0..30_000 {
        app.update();
        told += app.world_mut().resource_mut::<Messages<BakeProgress>>().drain().count();
        let finished = app.world_mut().resource_mut::<Messages<BakeFinished>>().drain().next();
        if let Some(finished) = finished {
            finished.result.unwrap();
            break;
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    assert!(told > 3, "no progress");
    let image = show(&mut app);
    let mean = write_picture(&app, &image, "bake_in_app");
    assert!(mean[0] > 15.0, "it is dark: {mean:?}");
}
