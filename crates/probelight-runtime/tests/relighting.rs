//! Lights, sky and materials change between frames.
#![cfg(feature = "cpu")]

mod support;

use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::{FrameInput, Runtime, RuntimeError};
use probelight_scene::{Light, Lighting, Sky};
use support::{SMALL, SMALL_PAPER, all_lights, checked, random_room};

fn new_runtime(baked: &Arc<BakedScene>) -> Runtime {
    let mut runtime = Runtime::new(baked.clone());
    runtime.set_lighting(all_lights()).unwrap();
    runtime
}

fn after_three_steps(runtime: &mut Runtime) -> Vec<Vec3> {
    for _ in 0..3 {
        runtime.step(&FrameInput::default());
    }
    runtime.irradiance().texels.clone()
}

/// Applies a change to a runtime that has run: the light is another one, and that of a fresh runtime. Emitters
/// and the sky have signals of their own in one of the rooms, not in the other.
fn check_change(change: impl Fn(&mut Runtime)) {
    for size in [SMALL, SMALL_PAPER] {
        let baked = checked(random_room(size));
        let mut fresh = new_runtime(&baked);
        change(&mut fresh);
        let expected = after_three_steps(&mut fresh);

        let mut changed = new_runtime(&baked);
        let before = after_three_steps(&mut changed);
        change(&mut changed);
        changed.reset();
        let after = after_three_steps(&mut changed);
        assert!(before != after, "the change does nothing");
        assert!(after == expected, "something of the old state is left");
    }
}

#[test]
fn moved_lights_change_the_light() {
    check_change(|runtime| {
        let mut lighting = runtime.lighting().clone();
        lighting.lights.pop();
        runtime.set_lighting(lighting).unwrap();
    });
}

#[test]
fn another_sky_changes_the_light() {
    check_change(|runtime| {
        let sky = Sky::Uniform(Vec3::new(1.0, 0.0, 2.0));
        runtime.set_lighting(Lighting { sky, ..runtime.lighting().clone() }).unwrap();
    });
}

#[test]
fn emission_and_its_scale_change_the_light() {
    check_change(|runtime| runtime.set_emission(1, Vec3::new(0.0, 7.0, 0.0)).unwrap());
    check_change(|runtime| {
        runtime.set_lighting(Lighting { emissive_scale: 0.0, ..runtime.lighting().clone() }).unwrap();
    });
}

#[test]
fn base_color_changes_the_light() {
    check_change(|runtime| runtime.set_base_color(0, Vec3::new(0.1, 0.9, 0.0)).unwrap());
}

#[test]
fn changes_reach_the_next_frame_without_reset() {
    let baked = checked(random_room(SMALL));
    let mut runtime = new_runtime(&baked);
    runtime.step(&FrameInput::default());
    let dark = Lighting { emissive_scale: 0.0, ..Lighting::default() };
    for black in 0..baked.scene.materials.len() {
        runtime.set_base_color(black, Vec3::ZERO).unwrap();
    }
    runtime.set_lighting(dark).unwrap();
    runtime.step(&FrameInput::default());
    assert!(runtime.irradiance().texels.iter().all(|e| *e == Vec3::ZERO));
}

#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let baked = checked(random_room(SMALL));
    let run = |threads: usize, lighting: Lighting| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut runtime = new_runtime(&baked);
            runtime.set_lighting(lighting).unwrap();
            let texels = after_three_steps(&mut runtime);
            texels.iter().map(|e| e.to_array().map(f32::to_bits)).collect::<Vec<_>>()
        })
    };
    let one = run(1, all_lights());
    assert!(one == run(2, all_lights()));
    assert!(one == run(5, all_lights()));
    let slightly_brighter = Lighting { emissive_scale: 1.500_001, ..all_lights() };
    assert!(one != run(1, slightly_brighter), "the comparison notices nothing");
}

#[test]
fn impossible_materials_are_refused() {
    let baked = checked(random_room(SMALL));
    let mut runtime = new_runtime(&baked);
    let unknown = runtime.set_base_color(9, Vec3::ONE);
    assert!(matches!(unknown, Err(RuntimeError::UnknownMaterial { material: 9, count: 2 })));
    for color in [Vec3::NAN, Vec3::new(0.0, -0.1, 0.0), Vec3::INFINITY] {
        assert!(matches!(runtime.set_emission(0, color), Err(RuntimeError::InvalidColor { .. })));
        assert!(matches!(runtime.set_base_color(0, color), Err(RuntimeError::InvalidColor { .. })));
    }
}

#[test]
fn light_that_cannot_be_is_refused_and_changes_nothing() {
    let baked = checked(random_room(SMALL));
    let mut runtime = new_runtime(&baked);
    let before = after_three_steps(&mut runtime);
    runtime.reset();
    let point = |position, intensity| Lighting {
        lights: vec![Light::Point { position, intensity, range: None }],
        ..Lighting::default()
    };
    let sun = |direction| Lighting {
        lights: vec![Light::Directional { direction, irradiance: Vec3::ONE }],
        ..Lighting::default()
    };
    let sky = |radiance| Lighting { sky: Sky::Uniform(radiance), ..Lighting::default() };
    let emission = |emissive_scale| Lighting { emissive_scale, ..Lighting::default() };
    for wrong in [
        point(Vec3::ZERO, Vec3::new(0.0, f32::NAN, 1.0)),
        point(Vec3::ZERO, Vec3::INFINITY),
        point(Vec3::ZERO, Vec3::new(0.0, -1.0, 1.0)),
        point(Vec3::NAN, Vec3::ONE),
        sun(Vec3::ZERO),
        sun(Vec3::NAN),
        sky(Vec3::new(f32::NAN, 0.0, 0.0)),
        sky(-Vec3::X),
        emission(f32::NAN),
        emission(-1.0),
    ] {
        let refused = runtime.set_lighting(wrong.clone());
        assert!(matches!(refused, Err(RuntimeError::Lighting(_))), "{wrong:?}");
    }
    assert!(after_three_steps(&mut runtime) == before, "a refused lighting left something behind");
    runtime.set_lighting(sun(Vec3::NEG_Y)).unwrap();
}
