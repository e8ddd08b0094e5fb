//! A grid that is finer in some places than in others: between levels light is continuous, ends at walls, and frames
//! compute all that is read.

mod support;

use std::sync::Arc;

use probelight_asset::{BakedScene, GridBasis, GridBasisKind, GridLobe, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::Vec3;
use probelight_math::sampling::Rng;
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Bounds, Scene};
use probelight_trace::Silent;

use support::grid::{levels, light_of, share_of};
use support::quick;
use support::shapes::{scene_of, solid};

const ROOM: Vec3 = Vec3::new(4.0, 2.5, 3.0);
const WALL: f32 = 0.01;

/// A closed room with thin walls on wide ground.
fn room_on_a_plain() -> Scene {
    let wall = |low: Vec3, high: Vec3| (solid(low, high), false);
    let outer = ROOM + WALL;
    scene_of(vec![
        wall(Vec3::new(-16.0, -0.5, -16.0), Vec3::new(16.0, 0.0, 16.0)),
        wall(Vec3::splat(-WALL).with_y(0.0), Vec3::new(0.0, outer.y, outer.z)),
        wall(Vec3::new(ROOM.x, 0.0, -WALL), outer),
        wall(Vec3::new(0.0, 0.0, -WALL), Vec3::new(ROOM.x, outer.y, 0.0)),
        wall(Vec3::new(0.0, 0.0, ROOM.z), Vec3::new(ROOM.x, outer.y, outer.z)),
        wall(Vec3::new(0.0, ROOM.y, 0.0), Vec3::new(ROOM.x, outer.y, ROOM.z)),
    ])
}

fn baked() -> BakedScene {
    let options = BakeOptions {
        receivers: Some(300),
        gather_rays: Some(16),
        grid_vertices: Some(1200),
        grid_basis: Some(GridBasis { kind: GridBasisKind::Axes6, lobe: GridLobe::Angle }),
        ..quick(Method::Hybrid)
    };
    let baked = bake(Arc::new(room_on_a_plain()), &options, None, &Silent).unwrap();
    assert!(levels(&baked) > 1);
    baked
}

fn is_inside(place: Vec3) -> bool {
    place.cmpgt(Vec3::ZERO).all() && place.cmplt(ROOM).all()
}

fn is_in_wall(place: Vec3) -> bool {
    !is_inside(place) && place.cmpgt(Vec3::splat(-WALL)).all() && place.cmplt(ROOM + WALL).all()
}

/// Places within the grid's bounds and in the air, half of them near the room.
fn places(count: usize) -> impl Iterator<Item = Vec3> {
    let mut rng = Rng::new(7, 0);
    let mut place = move |low: Vec3, high: Vec3| {
        low + (high - low) * Vec3::from_array(std::array::from_fn(|_| rng.next_f32()))
    };
    let wide = (Vec3::new(-16.0, 0.0, -16.0), Vec3::new(16.0, ROOM.y + WALL, 16.0));
    let near = (Vec3::new(-1.0, 0.0, -1.0), (ROOM + 1.0).with_y(wide.1.y));
    (0..count)
        .map(move |i| if i % 2 == 0 { wide } else { near })
        .map(move |(low, high)| place(low, high))
        .filter(|place| !is_in_wall(*place))
}

#[test]
fn no_light_crosses_walls_between_levels_and_none_is_lost() {
    let baked = baked();
    let (inside, everywhere) = (share_of(&baked, is_inside), share_of(&baked, |_| true));
    for place in places(20_000) {
        let (share, all) = (inside(place, Vec3::Y), everywhere(place, Vec3::Y));
        assert!((all - 1.0).abs() < 1e-5, "{place}: {all}");
        assert!((share - f32::from(is_inside(place))).abs() < 1e-5, "{place}: {share}");
    }
}

#[test]
fn light_is_continuous_between_levels() {
    let baked = baked();
    // It changes by 1 in a spacing of the finest level.
    let spacing = baked.grid.spacing.min_element();
    let light = light_of(&baked, |vertex| 100.0 + vertex.dot(Vec3::new(0.6, 0.64, -0.48)) / spacing);
    let step = 1e-3 * spacing;
    let mut steepest = 0.0f32;
    // Ways along x through cells without walls: in those light may end at a wall's plane.
    let coarsest = baked.grid.at_level(2).spacing.z;
    let is_open = |place: &Vec3| place.z < -coarsest || place.z > ROOM.z + coarsest;
    for from in places(2000).filter(is_open) {
        let at = |i: u16| light(from + Vec3::X * (step * f32::from(i)), Vec3::Y);
        for i in 0..1000 {
            steepest = steepest.max((at(i + 1) - at(i)).abs());
        }
    }
    assert!(steepest > 1e-4 && steepest < 0.01, "{steepest}");
}

#[test]
fn frames_compute_all_that_is_read_and_not_much_more() {
    let baked = Arc::new(baked());
    let mut runtime = Runtime::new(Arc::clone(&baked));
    let mut shares = Vec::new();
    for place in places(400) {
        let active = [Bounds { min: place - 0.05, max: place + 0.05 }];
        runtime.step(&FrameInput { active_boxes: &active, ..FrameInput::default() });
        assert!(runtime.irradiance_in_air(place, Vec3::Y).is_some(), "{place}");
        let extents = &runtime.plan().clusters()[baked.lightmap_clusters()..];
        let computed = extents.iter().filter(|extent| extent.receivers > 0).count();
        shares.push(computed as f32 / extents.len() as f32);
    }
    let mean = shares.iter().sum::<f32>() / shares.len() as f32;
    assert!(mean > 0.0 && mean < 0.5, "{mean}");
}
