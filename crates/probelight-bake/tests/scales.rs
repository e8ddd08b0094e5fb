//! Scenes of any size, in any unit and place: the same light, for work that follows what was asked for.

mod support;

use std::f32::consts::PI;
use std::sync::{Arc, Mutex};

use probelight_asset::{BakedScene, Method};
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_math::glam::Vec3;
use probelight_runtime::Runtime;
use probelight_scene::{AlphaMode, Light, Lighting, Scene, Sky};
use probelight_trace::{Progress, Silent};

use support::shapes::{Shape, scene_of, sheet, solid, turned};
use support::{load, quick};

/// A closed room with a block in it, built in some unit and moved away from the origin.
#[derive(Clone, Copy)]
struct Room {
    /// A metre in the room's unit.
    scale: f32,
    /// In the room's unit.
    offset: Vec3,
}

/// Places in the room, metres: on the floor, beside and on the block, on walls and on the ceiling.
const PLACES: [(Vec3, Vec3); 7] = [
    (Vec3::new(0.4, 0.0, 0.5), Vec3::Y),
    (Vec3::new(3.1, 0.0, 4.2), Vec3::Y),
    (Vec3::new(1.6, 0.0, 3.4), Vec3::Y),
    (Vec3::new(1.5, 0.9, 2.2), Vec3::Y),
    (Vec3::new(0.0, 1.3, 2.4), Vec3::X),
    (Vec3::new(2.2, 1.8, 5.0), Vec3::NEG_Z),
    (Vec3::new(3.0, 3.0, 1.0), Vec3::NEG_Y),
];

impl Room {
    fn scene(self) -> Scene {
        let block = solid(Vec3::new(1.0, 0.01, 1.5), Vec3::new(2.2, 0.9, 3.0));
        let mut scene =
            scene_of(vec![(turned(solid(Vec3::ZERO, Vec3::new(4.0, 3.0, 5.0))), false), (block, false)]);
        scene.positions.iter_mut().for_each(|position| *position = self.place(*position));
        scene
    }

    fn place(self, metres: Vec3) -> Vec3 {
        metres * self.scale + self.offset
    }

    fn bake(self) -> BakedScene {
        bake(Arc::new(self.scene()), &quick(Method::Hybrid), None, &Silent).unwrap()
    }

    /// Irradiance at the places under a lamp.
    fn irradiance(self, baked: &BakedScene, lamp: Vec3) -> Vec<f32> {
        let intensity = Vec3::splat(10.0 * self.scale * self.scale);
        let lamp = Light::Point { position: self.place(lamp), intensity, range: None };
        let mut runtime = Runtime::new(Arc::new(baked.clone()));
        runtime.set_lighting(Lighting { lights: vec![lamp], ..Lighting::default() }).unwrap();
        runtime.converge(1e-4, 50);
        let at = |(position, normal): (Vec3, Vec3)| runtime.irradiance_at(self.place(position), normal);
        PLACES.into_iter().map(|place| at(place).unwrap().y).collect()
    }
}

/// Largest difference relative to the mean.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    let mean = a.iter().sum::<f32>() / a.len() as f32;
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / mean
}

const LAMP: Vec3 = Vec3::new(1.3, 2.2, 3.8);

#[test]
fn a_room_is_lit_the_same_in_any_unit_and_place() {
    let metres = Room { scale: 1.0, offset: Vec3::ZERO };
    let baked = metres.bake();
    let expected = metres.irradiance(&baked, LAMP);
    let receivers = baked.receiver_texels.len() as f32;
    let away = |x: f32| Room { offset: Vec3::new(x, 0.0, -0.9 * x), ..metres };
    let built_in = |scale: f32| Room { scale, ..metres };
    for room in [built_in(1e3), built_in(1e-3), built_in(0.1), away(3e3), away(1e4)] {
        let baked = room.bake();
        let found = room.irradiance(&baked, LAMP);
        let name = format!("scale {}, offset {}", room.scale, room.offset);
        assert!(difference(&expected, &found) < 0.1, "{name}: {found:?}, not {expected:?}");
        let ratio = baked.receiver_texels.len() as f32 / receivers;
        assert!((ratio - 1.0).abs() < 0.1, "{name}: {ratio} times the receivers");
    }
    let other = metres.irradiance(&baked, Vec3::new(3.0, 1.0, 1.0));
    assert!(difference(&expected, &other) > 0.1, "another lamp gives other light");
}

fn warnings(shapes: Vec<(Shape, bool)>, receivers: u32) -> (usize, String) {
    let options = BakeOptions { receivers: Some(receivers), ..quick(Method::Hybrid) };
    let baked = bake(Arc::new(scene_of(shapes)), &options, None, &Silent).unwrap();
    (baked.receiver_texels.len(), baked.report.warnings.join("\n"))
}

#[test]
fn places_that_numbers_cannot_tell_apart_are_warned_of() {
    let warnings = |x: f32| {
        let room = Room { scale: 1.0, offset: Vec3::new(x, 0.0, 0.0) };
        room.bake().into_parts().report.warnings.join("\n")
    };
    assert!(warnings(1e5).contains("from the origin"), "{}", warnings(1e5));
    assert_eq!(warnings(0.0), "");
}

#[test]
fn more_pieces_than_receivers_are_few_texels_each_and_warned_of() {
    let block = |i: u32| {
        let low = Vec3::new((i % 20) as f32, 0.0, (i / 20) as f32);
        (solid(low, low + Vec3::splat(0.3)), false)
    };
    let blocks: Vec<_> = (0..200).map(block).collect();
    let (receivers, warned) = warnings(blocks.clone(), 400);
    let sides = 200 * 6;
    assert!((sides / 2..2 * sides).contains(&receivers), "{receivers}");
    assert!(warned.contains("400 receivers were asked for"), "{warned}");
    let (receivers, warned) = warnings(blocks[..3].to_vec(), 6000);
    assert!((5000..7000).contains(&receivers) && warned.is_empty(), "{receivers}: {warned}");
}

/// The shapes baked with so many receivers, under a sky of radiance 1.
fn under_the_sky(shapes: Vec<Shape>, receivers: u32) -> Runtime {
    let scene = scene_of(shapes.into_iter().map(|shape| (shape, false)).collect());
    let options = BakeOptions { receivers: Some(receivers), ..quick(Method::Hybrid) };
    let mut runtime = Runtime::new(Arc::new(bake(Arc::new(scene), &options, None, &Silent).unwrap()));
    runtime.set_lighting(Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() }).unwrap();
    runtime.converge(1e-4, 50);
    runtime
}

#[test]
fn what_is_free_of_small_half_hidden_faces_is_lit() {
    let mut shapes = vec![solid(Vec3::new(-25.0, -0.2, -25.0), Vec3::new(25.0, 0.0, 25.0))];
    let corner = |i: u32| Vec3::new((i % 10) as f32 * 4.0 - 20.0, -0.01, (i / 10) as f32 * 4.0 - 20.0);
    let free = |i: u32| 0.04 + 0.03 * (i % 10) as f32;
    for i in 0..60 {
        let (low, size) = (corner(i), Vec3::new(0.4, 0.41, 0.4));
        let moved = low + Vec3::new(free(i), 0.0, 0.1);
        shapes.extend([solid(low, low + size), solid(moved, moved + size)]);
    }
    let runtime = under_the_sky(shapes, 1500);
    for i in 0..60 {
        let beside = corner(i) + Vec3::new(0.5 * free(i), 0.2, 0.4);
        let found = runtime.irradiance_at(beside, Vec3::Z).unwrap().y;
        assert!(found > 0.1 * PI, "{found} on the free {} m of block {i}", free(i));
        let below = corner(i) + Vec3::new(0.1, 0.0, 0.1);
        assert_eq!(runtime.irradiance_at(below, Vec3::NEG_Y), Some(Vec3::ZERO), "in the floor");
    }
}

#[test]
fn a_strip_of_a_kilometre_is_lit_all_along() {
    let strip = sheet(Vec3::new(-500.0, 0.0, 0.005), Vec3::X * 1000.0, Vec3::Z * -0.01);
    let runtime = under_the_sky(vec![strip], 1500);
    for x in [-499.0, -3.0, 0.5, 321.0] {
        let found = runtime.irradiance_at(Vec3::new(x, 0.0, 0.0), Vec3::Y).unwrap().y;
        assert!((found / PI - 1.0).abs() < 0.02, "{found} at {x}");
    }
}

#[test]
fn glass_alone_is_nothing_to_light() {
    let glass = |alpha: f32| {
        let mut scene = scene_of(vec![(solid(Vec3::ZERO, Vec3::ONE), false)]);
        for material in &mut scene.materials {
            material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            material.base_color.w = alpha;
        }
        bake(Arc::new(scene), &quick(Method::Hybrid), None, &Silent)
    };
    assert!(matches!(glass(0.3), Err(BakeError::NothingToLight { .. })));
    assert!(glass(0.7).is_ok());
}

/// Asks to stop when a stage begins, and notes all stages.
struct StopAt {
    stage: Option<String>,
    begun: Mutex<Vec<String>>,
}

impl StopAt {
    fn new(stage: Option<String>) -> Self {
        Self { stage, begun: Mutex::default() }
    }

    fn bake(&self) -> Result<BakedScene, BakeError> {
        bake(load("cornell.glb"), &quick(Method::Hybrid), None, self)
    }
}

impl Progress for StopAt {
    fn begin(&self, stage: &str, _total: u64) {
        self.begun.lock().unwrap().push(stage.into());
    }

    fn advance(&self, _steps: u64) {}

    fn is_cancelled(&self) -> bool {
        self.stage.as_ref().is_some_and(|stage| self.begun.lock().unwrap().contains(stage))
    }
}

#[test]
fn every_step_can_be_stopped() {
    let patient = StopAt::new(None);
    patient.bake().unwrap();
    let stages = patient.begun.into_inner().unwrap();
    assert!(stages.len() > 10, "{stages:?}");
    for stage in stages {
        let stopped = StopAt::new(Some(stage.clone()));
        assert!(matches!(stopped.bake(), Err(BakeError::Cancelled)), "{stage}");
        let begun = stopped.begun.into_inner().unwrap();
        let after = begun.iter().skip_while(|begun| **begun != stage).count() - 1;
        assert!(after <= 1, "{stage}: {begun:?}");
    }
}
