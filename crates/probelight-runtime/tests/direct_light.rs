//! Direct light on surfels against closed forms: flux arrives as it was sent, however near the wall and however thin the
//! beam.
#![cfg(feature = "cpu")]

mod support;

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use probelight_asset::{BakedScene, LightSample, LightmapFace, LightmapLayout, NONE, Surfel, SurfelGroup};
use probelight_math::glam::{Vec3, vec2};
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Light, Lighting, Object, Placement, Scene};
use support::{add_quad, checked, material, single_probe};

/// Size of the closed room, metres; its floor is at y = 0.
const ROOM: Vec3 = Vec3::new(4.0, 3.0, 5.0);

/// Surfels along the edge of a wall, and texels along the edge of a surfel.
const SURFELS: usize = 8;
const TEXELS: usize = 3;

/// The corners of the walls as seen from inside, counter-clockwise; the floor comes first.
fn walls() -> [[Vec3; 4]; 6] {
    let [x, y, z] = [Vec3::X * ROOM.x, Vec3::Y * ROOM.y, Vec3::Z * ROOM.z];
    let wall = |corner: Vec3, a: Vec3, b: Vec3| [corner, corner + a, corner + a + b, corner + b];
    let o = Vec3::ZERO;
    [wall(o, z, x), wall(y, x, z), wall(o, y, z), wall(x, z, y), wall(o, x, y), wall(z, y, x)]
}

/// A closed white room whose walls have square surfels, each wall a tree of them.
fn room() -> Arc<BakedScene> {
    let side = SURFELS * TEXELS;
    let mut scene = Scene { materials: vec![material(Vec3::splat(0.5), Vec3::ZERO)], ..Scene::default() };
    walls().into_iter().for_each(|corners| add_quad(&mut scene, corners, 0));
    let mut baked = single_probe(scene, None, &vec![1.0; 6 * side * side]);
    let face = |wall: usize, corners: [(usize, usize); 3]| LightmapFace {
        corners: corners.map(|(x, y)| vec2((x * side) as f32, ((wall + y) * side) as f32)),
    };
    let faces = |wall: usize| [face(wall, [(0, 0), (1, 0), (1, 1)]), face(wall, [(0, 0), (1, 1), (0, 1)])];
    baked.lightmap = LightmapLayout {
        width: side as u32,
        height: (6 * side) as u32,
        pages: 1,
        faces: (0..6).flat_map(faces).collect(),
        back_faces: vec![NONE; 12],
        dilation: Vec::new(),
    };
    for wall in 0..6 {
        let [corner, a, _, b] = walls()[wall];
        let area = (a - corner).cross(b - corner).length() / (SURFELS * SURFELS) as f32;
        for surfel in 0..SURFELS * SURFELS {
            let first_sample = baked.light_samples.len() as u32;
            baked.surfels.push(Surfel { first_sample, sample_count: (TEXELS * TEXELS) as u32, area });
            for texel in 0..TEXELS * TEXELS {
                let x = (surfel % SURFELS * TEXELS + texel % TEXELS) as f32 + 0.5;
                let y = (surfel / SURFELS * TEXELS + texel / TEXELS) as f32 + 0.5;
                let at = vec2(x, y) / side as f32;
                let (half, weights) =
                    if at.y <= at.x { (0, vec2(at.x - at.y, at.y)) } else { (1, vec2(at.x, at.y - at.x)) };
                baked.light_samples.push(LightSample::new(
                    (2 * wall + half) as u32,
                    false,
                    weights,
                    [255; 3],
                ));
            }
        }
    }
    for wall in 0..6 {
        let first = wall * SURFELS * SURFELS;
        add_group(&mut baked.surfel_groups, first, [0, 0], [SURFELS; 2]);
    }
    checked(baked)
}

/// The number of the patch of a wall's surfels from `low` up to `high`.
fn add_group(groups: &mut Vec<SurfelGroup>, first: usize, low: [usize; 2], high: [usize; 2]) -> u32 {
    let size = [high[0] - low[0], high[1] - low[1]];
    if size == [1, 1] {
        return (first + low[1] * SURFELS + low[0]) as u32;
    }
    let axis = usize::from(size[1] > size[0]);
    let (mut end, mut start) = (high, low);
    end[axis] = low[axis] + size[axis] / 2;
    start[axis] = end[axis];
    let children = [add_group(groups, first, low, end), add_group(groups, first, start, high)];
    groups.push(SurfelGroup { children, first_weight: 0.5 });
    (6 * SURFELS * SURFELS + groups.len() - 1) as u32
}

/// Flux on each surfel.
fn flux_of(baked: &Arc<BakedScene>, lights: Vec<Light>) -> Vec<f32> {
    let mut runtime = Runtime::new(Arc::clone(baked));
    runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
    runtime.step(&FrameInput::default());
    flux(&runtime)
}

fn flux(runtime: &Runtime) -> Vec<f32> {
    let irradiance = runtime.signals().direct_irradiance().iter();
    irradiance.zip(&runtime.baked().surfels).map(|(irradiance, surfel)| irradiance.x * surfel.area).collect()
}

fn lamp(position: Vec3) -> Light {
    Light::Point { position, intensity: Vec3::ONE, range: None }
}

fn spot(position: Vec3, target: Vec3, outer_degrees: f32) -> Light {
    let outer_angle = outer_degrees.to_radians();
    Light::Spot {
        position,
        direction: (target - position).normalize(),
        intensity: Vec3::ONE,
        inner_angle: 0.5 * outer_angle,
        outer_angle,
        range: None,
    }
}

/// Solid angle of a surfel of the floor from a point above it: four times that of rectangles with a corner below the point.
fn solid_angle_of_floor(x: usize, z: usize, from: Vec3) -> f32 {
    let width = vec2(ROOM.z, ROOM.x) / SURFELS as f32;
    let corner = |i: usize, j: usize| {
        let at = vec2((x + i) as f32, (z + j) as f32) * width - vec2(from.z, from.x);
        (at.x * at.y / (from.y * (at.length_squared() + from.y * from.y).sqrt())).atan()
    };
    corner(1, 1) - corner(0, 1) - corner(1, 0) + corner(0, 0)
}

#[test]
fn a_closed_room_gets_what_its_light_sends_out() {
    let baked = room();
    for (light, sent) in [
        (lamp(Vec3::new(1.3, 1.1, 2.9)), 4.0 * PI),
        (lamp(Vec3::new(1.3, 2.95, 2.9)), 4.0 * PI),
        (lamp(Vec3::new(0.05, 0.05, 0.05)), 4.0 * PI),
        // Inner and outer versine: the full part, and a third of the ramp.
        (spot(Vec3::new(1.0, 1.5, 1.0), Vec3::new(3.0, 0.0, 4.0), 40.0), {
            let [inner, outer] = [20f32, 40.0].map(|degrees| 1.0 - degrees.to_radians().cos());
            TAU * (inner + (outer - inner) / 3.0)
        }),
    ] {
        let arrived: f32 = flux_of(&baked, vec![light.clone()]).iter().sum();
        assert!((arrived / sent - 1.0).abs() < 1e-3, "{light:?}: {arrived} of {sent}");
    }
}

#[test]
fn each_surfel_gets_its_solid_angle_of_a_lamp() {
    let baked = room();
    // What a ray carries: small scenes have the least number of rays.
    let ray = 4.0 * PI / 8192.0;
    for height in [2.5, 1.0, 0.3, 0.05] {
        let position = Vec3::new(1.3, height, 2.9);
        let found = flux_of(&baked, vec![lamp(position)]);
        let mut by_samples = 0f32;
        for (number, found) in found[..SURFELS * SURFELS].iter().enumerate() {
            let expected = solid_angle_of_floor(number % SURFELS, number / SURFELS, position);
            let difference = (found - expected).abs();
            assert!(difference < 0.02 * expected + 1.5 * ray, "{height}: {found} for {expected}");
            // Negative control: the mean over the surfel's samples.
            let surfel = &baked.surfels[number];
            let samples = baked.samples_of(surfel).iter().map(|sample| {
                let (place, normal) = baked.place_of(sample);
                let arriving = lamp(position).illuminate(place).unwrap();
                arriving.irradiance.x * arriving.to_light.dot(normal)
            });
            let mean = samples.sum::<f32>() * surfel.area / surfel.sample_count as f32;
            by_samples = by_samples.max((mean - expected).abs() / expected);
        }
        assert!(height > 0.1 || by_samples > 0.3, "samples alone are off by {by_samples} only");
    }
}

#[test]
fn a_spot_narrower_than_a_surfel_lights_it_alone() {
    let baked = room();
    // The middle of the surfel (2, 3) of the floor.
    let target = Vec3::new(3.5 * ROOM.x, 0.0, 2.5 * ROOM.z) / SURFELS as f32;
    for degrees in [5.0, 2.0, 0.5] {
        let found = flux_of(&baked, vec![spot(Vec3::new(1.0, 2.5, 1.0), target, degrees)]);
        let arrived: f32 = found.iter().sum();
        assert!(found[3 * SURFELS + 2] > 0.999 * arrived && arrived > 0.0, "{degrees}: {found:?}");
    }
}

#[test]
fn objects_take_light_away_and_give_it_back() {
    let baked = room();
    let mut shade = Scene { materials: vec![material(Vec3::ONE, Vec3::ZERO)], ..Scene::default() };
    add_quad(&mut shade, support::horizontal_quad(Vec3::ZERO), 0);
    let mut runtime = Runtime::new(Arc::clone(&baked));
    let lights = vec![lamp(Vec3::new(2.0, 2.0, 2.5)), lamp(Vec3::new(0.5, 0.4, 0.5))];
    runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
    runtime.step(&FrameInput::default());
    let before = flux(&runtime);
    let place = Placement::at(Vec3::new(2.0, 1.0, 2.5));
    let id = runtime.objects_mut().insert(Object::new(Arc::new(shade), place).unwrap());
    runtime.step(&FrameInput::default());
    // The shade is a square of side 2 one metre below the lamp: a sixth of its light, and some of the other's.
    let lost = before.iter().sum::<f32>() - flux(&runtime).iter().sum::<f32>();
    assert!(lost > 0.99 * 4.0 * PI / 6.0 && lost < 1.5 * 4.0 * PI / 6.0, "{lost}");
    runtime.objects_mut().remove(id).unwrap();
    runtime.step(&FrameInput::default());
    assert_eq!(flux(&runtime), before);
}

#[test]
fn light_does_not_depend_on_threads_nor_on_what_was_lit_before() {
    let baked = room();
    let lights = vec![lamp(Vec3::new(1.0, 1.0, 1.0)), spot(Vec3::splat(2.0), Vec3::ZERO, 30.0)];
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| flux_of(&baked, lights.clone()))
    };
    let expected = with_threads(1);
    assert_eq!(expected, with_threads(5));
    let mut runtime = Runtime::new(Arc::clone(&baked));
    let others = [vec![lamp(Vec3::ONE); 3], Vec::new(), vec![lights[1].clone(), lights[0].clone()], lights];
    for lights in others {
        runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
        runtime.step(&FrameInput::default());
    }
    assert_eq!(flux(&runtime), expected);
}
