//! Doors: objects that open and shut ways for light between rooms.

mod support;

use std::sync::{Arc, LazyLock};

use probelight_asset::{BakedScene, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::{Quat, Vec3};
use probelight_runtime::{FrameInput, LodPreset, Runtime};
use probelight_scene::{Light, Lighting, Object, Placement, Scene};
use probelight_trace::{PathTracer, Silent, Tracer};

use support::quick;
use support::shapes::{scene_of, solid, turned};

/// Two rooms with a wall between them, and an opening in it.
static ROOMS: LazyLock<Arc<BakedScene>> = LazyLock::new(|| {
    let wall = |from: Vec3, to: Vec3| (solid(from, to), false);
    let scene = scene_of(vec![
        (turned(solid(Vec3::ZERO, Vec3::new(6.0, 2.6, 4.0))), false),
        wall(Vec3::new(2.95, 0.0, 0.0), Vec3::new(3.05, 2.6, 1.5)),
        wall(Vec3::new(2.95, 0.0, 2.5), Vec3::new(3.05, 2.6, 4.0)),
        wall(Vec3::new(2.95, 2.1, 1.5), Vec3::new(3.05, 2.6, 2.5)),
    ]);
    let options = BakeOptions {
        receivers: Some(8000),
        gather_rays: Some(256),
        relight_rays: Some(512),
        grid_vertices: None,
        grid_spacing: Some(0.5),
        ..quick(Method::Hybrid)
    };
    Arc::new(bake(Arc::new(scene), &options, None, &Silent).unwrap())
});

/// A lamp in the western room, away from the opening.
fn lamp() -> Lighting {
    let light = Light::Point { position: Vec3::new(1.2, 2.0, 0.8), intensity: Vec3::splat(9.0), range: None };
    Lighting { lights: vec![light], emissive_scale: 0.0, ..Lighting::default() }
}

fn runtime() -> Runtime {
    let mut runtime = Runtime::new(Arc::clone(&ROOMS));
    runtime.set_lighting(lamp()).unwrap();
    runtime
}

/// A panel that fills the opening, and a little more, on its eastern side; its hinge is its origin.
fn panel() -> Arc<Scene> {
    Arc::new(scene_of(vec![(solid(Vec3::new(-0.02, 0.0, 0.0), Vec3::new(0.02, 2.12, 1.04)), false)]))
}

/// The panel, turned open by an angle, radians.
fn door(angle: f32) -> Object {
    Object::new(panel(), at_hinge(angle)).unwrap().as_door()
}

fn at_hinge(angle: f32) -> Placement {
    Placement { rotation: Quat::from_rotation_y(angle), ..Placement::at(Vec3::new(3.08, -0.005, 1.48)) }
}

/// Places on all walls, the floor and the ceiling of a room, off its corners.
fn places(is_east: bool) -> Vec<(Vec3, Vec3)> {
    let (low, high) = (Vec3::ZERO, Vec3::new(6.0, 2.6, 4.0));
    let shift = if is_east { 3.2 } else { 0.2 };
    let (along_x, along_z) = ([0.3, 1.0, 1.7, 2.3].map(|x| x + shift), [0.5, 1.2, 2.0, 2.8, 3.5]);
    let floors = along_x.into_iter().flat_map(|x| {
        along_z
            .into_iter()
            .flat_map(move |z| [(Vec3::new(x, low.y, z), Vec3::Y), (Vec3::new(x, high.y, z), Vec3::NEG_Y)])
    });
    let walls = along_x.into_iter().flat_map(|x| {
        [0.6, 1.3, 2.0]
            .into_iter()
            .flat_map(move |y| [(Vec3::new(x, y, low.z), Vec3::Z), (Vec3::new(x, y, high.z), Vec3::NEG_Z)])
    });
    floors.chain(walls).collect()
}

/// Mean irradiance of a room.
fn mean_light(runtime: &Runtime, is_east: bool) -> f32 {
    let places = places(is_east);
    let light = |(position, normal): &(Vec3, Vec3)| runtime.irradiance_at(*position, *normal).unwrap().x;
    places.iter().map(light).sum::<f32>() / places.len() as f32
}

/// The same by the path tracer, with the door as a part of the scene.
fn true_mean_light(door: Option<&Object>, is_east: bool) -> f32 {
    let scene = Arc::new(ROOMS.scene.with_objects(&door.cloned().into_iter().collect::<Vec<_>>()));
    let truth = PathTracer::new(Arc::new(Tracer::new(scene)), lamp());
    let places = places(is_east);
    let truth = truth.irradiance_of_points(&places, 1024, 5, &Silent).unwrap();
    truth.iter().map(|light| light.indirect.x).sum::<f32>() / places.len() as f32
}

#[test]
fn a_door_that_shuts_keeps_light_out_and_lets_it_in_again() {
    let mut runtime = runtime();
    runtime.converge(1e-4, 100);
    let open = runtime.irradiance().texels.clone();
    let [west, east] = [false, true].map(|is_east| mean_light(&runtime, is_east));
    let truth = true_mean_light(None, true);
    assert!((east / truth - 1.0).abs() < 0.1, "{east} {truth}");

    let id = runtime.objects_mut().insert(door(0.0));
    runtime.converge(1e-5, 200);
    let [west_shut, east_shut] = [false, true].map(|is_east| mean_light(&runtime, is_east));
    // What is left comes within a cluster's width of the door, which is coarse here.
    assert!(east_shut < 0.08 * east, "{east_shut} of {east}");
    let truth = true_mean_light(Some(&door(0.0)), false);
    assert!((west_shut / truth - 1.0).abs() < 0.1, "{west_shut} {truth}, {west} while it is open");

    runtime.objects_mut().remove(id).unwrap();
    runtime.reset();
    runtime.converge(1e-4, 100);
    assert_eq!(runtime.irradiance().texels, open);
}

#[test]
fn a_door_that_stands_ajar_lets_as_much_light_in_as_it_should() {
    let mut runtime = runtime();
    let id = runtime.objects_mut().insert(door(0.0));
    for angle in [0.5f32, 1.0, 1.5] {
        runtime.objects_mut().place(id, at_hinge(angle)).unwrap();
        runtime.converge(1e-4, 100);
        let (ours, truth) = (mean_light(&runtime, true), true_mean_light(Some(&door(angle)), true));
        assert!((ours / truth - 1.0).abs() < 0.2, "{angle}: {ours} {truth}");
    }
}

#[test]
fn light_does_not_wait_when_a_door_moves() {
    let (mut waiting, mut whole) = (runtime(), runtime());
    let mut lod = LodPreset::Exact.settings();
    lod.changes.threshold = 0.005;
    waiting.set_lod(lod).unwrap();
    let ids = [&mut waiting, &mut whole].map(|runtime| runtime.objects_mut().insert(door(1.5)));
    let steps = |runtime: &mut Runtime, frames: usize| {
        for _ in 0..frames {
            runtime.step(&FrameInput::default());
        }
        mean_light(runtime, true)
    };
    let [before, _] = [&mut waiting, &mut whole].map(|runtime| steps(runtime, 40));
    waiting.objects_mut().place(ids[0], at_hinge(0.0)).unwrap();
    whole.objects_mut().place(ids[1], at_hinge(0.0)).unwrap();
    let [ours, exact] = [&mut waiting, &mut whole].map(|runtime| steps(runtime, 1));
    assert!(exact < 0.7 * before, "{exact} {before}");
    assert!((ours / exact - 1.0).abs() < 0.02, "{ours} {exact}");
}

#[test]
fn what_is_no_door_keeps_out_the_light_of_lamps_only() {
    let mut runtime = runtime();
    runtime.converge(1e-4, 100);
    let open = mean_light(&runtime, true);
    runtime.objects_mut().insert(Object::new(panel(), at_hinge(0.0)).unwrap());
    runtime.converge(1e-4, 100);
    let behind = mean_light(&runtime, true);
    assert!(behind > 0.4 * open && behind < open, "{behind} of {open}");
}
