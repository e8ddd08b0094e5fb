//! Objects in a baked scene: what light they get and what shadows they cast.

mod support;

use std::sync::{Arc, LazyLock};

use probelight_asset::{BakedScene, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::{Quat, Vec2, Vec3};
use probelight_runtime::{FrameInput, Runtime, RuntimeError};
use probelight_scene::{Light, Lighting, Object, Placement, Scene};
use probelight_trace::{PathTracer, Silent, Tracer, direct_irradiance};

use support::shapes::{scene_of, solid};
use support::{load, quick};

/// The empty Cornell box with a grid.
static BAKED: LazyLock<Arc<BakedScene>> = LazyLock::new(|| {
    let options = BakeOptions {
        receivers: Some(6000),
        gather_rays: Some(256),
        relight_rays: Some(256),
        grid_vertices: None,
        grid_spacing: Some(0.45),
        ..quick(Method::Hybrid)
    };
    Arc::new(bake(load("cornell_empty.glb"), &options, None, &Silent).unwrap())
});

/// A lamp under the ceiling.
fn lamp() -> Lighting {
    let light = Light::Point { position: Vec3::new(2.8, 4.8, 2.8), intensity: Vec3::splat(9.0), range: None };
    Lighting { lights: vec![light], emissive_scale: 0.0, ..Lighting::default() }
}

fn runtime() -> Runtime {
    let mut runtime = Runtime::new(Arc::clone(&BAKED));
    runtime.set_lighting(lamp()).unwrap();
    runtime
}

/// A grey cube with edges of a metre.
fn cube() -> Arc<Scene> {
    Arc::new(scene_of(vec![(solid(Vec3::splat(-0.5), Vec3::splat(0.5)), false)]))
}

fn cube_at(placement: Placement) -> Object {
    Object::new(cube(), placement).unwrap()
}

fn turned(translation: Vec3) -> Placement {
    Placement { translation, rotation: Quat::from_rotation_y(0.5), scale: 0.8 }
}

/// Relative root mean square error of a standing cube's light over its surface, in and out of its shadows.
fn error_of_standing_cube(placement: Placement) -> f64 {
    let (mut runtime, object) = (runtime(), cube_at(placement));
    runtime.objects_mut().insert(object.clone());
    runtime.converge(1e-4, 100);
    let points: Vec<(Vec3, Vec3)> = (0..12)
        .flat_map(|triangle| {
            [(0.2, 0.2), (0.6, 0.2), (0.2, 0.6), (0.33, 0.33)].map(|at| (triangle, Vec2::from(at)))
        })
        .map(|(triangle, at)| {
            let (position, normal) =
                (object.model().position(triangle, at), object.model().geometric_normal(triangle));
            (object.placement().point(position), object.placement().direction(normal))
        })
        .collect();
    let merged = Arc::new(BAKED.scene.with_objects(&[object]));
    let truth = PathTracer::new(Arc::new(Tracer::new(merged)), lamp());
    let truth = truth.irradiance_of_points(&points, 4096, 5, &Silent).unwrap();
    let (mut squares, mut sum) = (0.0, 0.0);
    for ((position, normal), truth) in points.into_iter().zip(truth) {
        let truth = (truth.delta + truth.area + truth.sky + truth.indirect).as_dvec3().element_sum();
        let direct = direct_irradiance(&runtime.world(), &lamp().lights, position, normal);
        let ours = direct + runtime.irradiance_in_air(position, normal).unwrap();
        squares += (ours.as_dvec3().element_sum() - truth).powi(2);
        sum += truth.powi(2);
    }
    (squares / sum).sqrt()
}

#[test]
fn an_object_is_lit_as_if_it_had_been_there_always() {
    let error = error_of_standing_cube(turned(Vec3::new(2.0, 1.9, 2.4)));
    assert!(error < 0.08, "{error}");
}

#[test]
fn shadows_of_objects_darken_bounced_light() {
    let mut runtime = runtime();
    runtime.converge(1e-4, 100);
    let on_the_ceiling =
        |runtime: &Runtime| runtime.irradiance_at(Vec3::new(1.2, 5.488, 1.2), Vec3::NEG_Y).unwrap().x;
    let open = on_the_ceiling(&runtime);
    // A lid under the lamp.
    let lid = Placement { translation: Vec3::new(2.8, 4.2, 2.8), rotation: Quat::IDENTITY, scale: 1.0 };
    let id = runtime.objects_mut().insert(cube_at(lid));
    runtime.converge(1e-4, 100);
    let covered = on_the_ceiling(&runtime);
    assert!(covered < 0.6 * open, "{covered} of {open}");
    // Out of the light it darkens nothing.
    runtime.objects_mut().place(id, Placement::at(Vec3::new(40.0, 0.0, 0.0))).unwrap();
    runtime.reset();
    runtime.converge(1e-4, 100);
    assert_eq!(on_the_ceiling(&runtime), open);
}

#[test]
fn objects_that_left_leave_no_light_behind() {
    let (mut never, mut left) = (runtime(), runtime());
    let id = left.objects_mut().insert(cube_at(turned(Vec3::splat(2.0))));
    left.converge(1e-3, 20);
    assert!(left.objects().get(id).is_some());
    left.objects_mut().remove(id).unwrap();
    assert!(matches!(left.objects_mut().remove(id), Err(RuntimeError::UnknownObject)));
    for runtime in [&mut never, &mut left] {
        runtime.reset();
        runtime.converge(1e-3, 50);
    }
    assert_eq!(never.irradiance().texels, left.irradiance().texels);
}

#[test]
fn the_first_frame_of_an_object_that_jumps_is_right() {
    let (mut jumped, mut there) = (runtime(), runtime());
    let [here, far] = [Vec3::new(1.0, 1.0, 1.0), Vec3::new(4.2, 3.0, 4.0)];
    let id = jumped.objects_mut().insert(cube_at(turned(here)));
    jumped.converge(1e-4, 100);
    jumped.objects_mut().place(id, turned(far)).unwrap();
    there.objects_mut().insert(cube_at(turned(far)));
    there.converge(1e-4, 100);
    jumped.step(&FrameInput::default());
    let light = |runtime: &Runtime| runtime.irradiance_in_air(far + 0.5 * Vec3::Y, Vec3::Y).unwrap().x;
    // Only what the object's shadow takes from bounced light needs more frames.
    let (first, last) = (light(&jumped), light(&there));
    assert!((first / last - 1.0).abs() < 0.05, "{first} {last}");
}

#[test]
fn only_cells_around_objects_are_computed() {
    let mut runtime = runtime();
    let small = Placement { scale: 0.05, ..Placement::at(Vec3::splat(1.0)) };
    runtime.objects_mut().insert(cube_at(small));
    runtime.step(&FrameInput::default());
    assert!(runtime.irradiance_in_air(Vec3::splat(1.0), Vec3::Y).is_some());
    assert!(runtime.irradiance_in_air(Vec3::new(4.5, 4.5, 4.5), Vec3::Y).is_none());
}

#[test]
fn an_object_far_outside_has_the_light_of_the_border() {
    let mut runtime = runtime();
    let outside = Vec3::new(2.8, 2.0, -50.0);
    runtime.objects_mut().insert(cube_at(Placement::at(outside)));
    runtime.converge(1e-3, 50);
    runtime.step(&FrameInput { whole_grid: true, ..FrameInput::default() });
    let light = |z: f32| runtime.irradiance_in_air(Vec3 { z, ..outside }, Vec3::Z).unwrap().x;
    let border = light(BAKED.grid.origin.z);
    assert!(border > 0.0);
    assert_eq!(light(-50.0), border);
    assert_eq!(light(-1e30), border);
}

#[test]
fn objects_without_a_place_are_refused() {
    let mut runtime = runtime();
    let id = runtime.objects_mut().insert(cube_at(Placement::default()));
    let nowhere = Placement::at(Vec3::NAN);
    assert!(matches!(runtime.objects_mut().place(id, nowhere), Err(RuntimeError::Object(_))));
    assert_eq!(*runtime.objects().get(id).unwrap().placement(), Placement::default());
}
