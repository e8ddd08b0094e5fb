//! Walls in the grid: no vertex lights what lies behind one, and none darkens what lies beside it.

mod support;

use std::sync::Arc;

use probelight_asset::{BakedScene, GridBasis, GridBasisKind, GridLobe, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::Vec3;
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Light, Lighting, Scene};
use probelight_trace::Silent;

use support::grid::share_of;
use support::shapes::{Shape, column, scene_of, sheet, solid, turned};
use support::{load, quick};

const ROOM: Vec3 = Vec3::new(4.0, 3.0, 3.0);

/// A closed room with something in it.
fn room_with(shapes: Vec<(Shape, bool)>) -> Scene {
    let mut all = vec![(turned(solid(Vec3::ZERO, ROOM)), false)];
    all.extend(shapes);
    scene_of(all)
}

/// Only where its vertices lie matters, and the walls between them.
fn bake_grid(scene: Scene, grid_spacing: f32) -> BakedScene {
    let options = BakeOptions {
        receivers: Some(300),
        gather_rays: Some(16),
        grid_spacing: Some(grid_spacing),
        grid_basis: Some(GridBasis { kind: GridBasisKind::Axes6, lobe: GridLobe::Angle }),
        ..quick(Method::Hybrid)
    };
    bake(Arc::new(scene), &options, None, &Silent).unwrap()
}

/// Places all over the room, some of them on surfaces or within a millimetre of them.
fn places() -> impl Iterator<Item = Vec3> {
    let along = |size: f32, i: usize, count: usize| match i {
        0 => 1e-4 * size,
        i if i + 1 == count => size * (1.0 - 1e-4),
        i => size * i as f32 / (count - 1) as f32,
    };
    (0..41 * 13 * 13).map(move |i| {
        Vec3::new(along(ROOM.x, i % 41, 41), along(ROOM.y, i / 41 % 13, 13), along(ROOM.z, i / 41 / 13, 13))
    })
}

#[test]
fn no_weight_crosses_a_wall_of_any_thinness_wherever_it_stands() {
    for (west, east) in [(1.9, 1.901), (2.0, 2.06), (1.73, 1.731), (1.3, 1.36)] {
        let wall = solid(Vec3::new(west, 0.0, 0.0), Vec3::new(east, ROOM.y, ROOM.z));
        let baked = bake_grid(room_with(vec![(wall, false)]), 0.5);
        let lit = share_of(&baked, |vertex| vertex.x < west);
        let near = [west - 0.01, west - 1e-3, east + 1e-3, east + 0.01, east + 0.2];
        let beside = places().step_by(41).flat_map(|p| near.map(|x| Vec3::new(x, p.y, p.z)));
        for place in places().filter(|p| p.x < west || p.x > east).chain(beside) {
            for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y] {
                let (expected, share) = (f32::from(place.x < west), lit(place, normal));
                assert!((share - expected).abs() < 1e-5, "wall at {west}, {place}: {share}");
            }
        }
    }
}

#[test]
fn one_sheet_divides_and_slanted_ones_do_too() {
    let slope = 0.37f32;
    let across = Vec3::new(slope * ROOM.y, ROOM.y, 0.0);
    let sheet = sheet(Vec3::new(1.2, 0.0, 0.0), across, Vec3::Z * ROOM.z);
    let baked = bake_grid(room_with(vec![(sheet, true)]), 0.4);
    let side = |p: Vec3| p.x - 1.2 - slope * p.y;
    let lit = share_of(&baked, |vertex| side(vertex) < 0.0);
    let mut worst = 0.0f32;
    for place in places().filter(|p| side(*p).abs() > 1e-3) {
        let expected = f32::from(side(place) < 0.0);
        worst = worst.max((lit(place, Vec3::Y) - expected).abs());
    }
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn without_the_walls_light_crosses_them() {
    let wall = solid(Vec3::new(1.6, 0.0, 0.0), Vec3::new(1.601, ROOM.y, ROOM.z));
    let mut parts = bake_grid(room_with(vec![(wall, false)]), 0.5).into_parts();
    (parts.grid_cell_blocks, parts.grid_cells, parts.grid_planes) = Default::default();
    let baked = BakedScene::new(parts).unwrap();
    let lit = share_of(&baked, |vertex| vertex.x < 1.6);
    assert!(lit(Vec3::new(1.65, 1.5, 1.5), Vec3::X) > 0.5);
}

/// Weights sum to one wherever light can be, behind columns, too.
#[test]
fn columns_do_not_darken_what_is_around_them() {
    let foot = Vec3::new(2.25, 0.0, 1.75);
    let baked = bake_grid(room_with(vec![(column(foot, 0.14, ROOM.y, 12), false)]), 0.5);
    let lit = share_of(&baked, |_| true);
    let outside = |p: &Vec3| ((p.x - foot.x).powi(2) + (p.z - foot.z).powi(2)).sqrt() > 0.15;
    for place in places().filter(outside) {
        let share = lit(place, Vec3::X);
        assert!((share - 1.0).abs() < 1e-5, "{place}: {share}");
    }
    // Ways bend round it: what lies behind it, seen from some corners of its cell, is lit by all of them.
    let west = share_of(&baked, |vertex| vertex.x < foot.x);
    let behind = west(foot + Vec3::new(0.15, 1.3, 0.0), Vec3::X);
    assert!(behind > 0.1, "{behind}");
}

/// The largest irradiance in the air of the sunlit room A and of the sealed room C of `rooms.glb`.
fn brightest_air(baked: &Arc<BakedScene>, lamp: Vec3) -> [f32; 2] {
    let mut runtime = Runtime::new(baked.clone());
    let lights = vec![Light::Point { position: lamp, intensity: Vec3::splat(20.0), range: None }];
    runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
    let input = FrameInput { whole_grid: true, ..FrameInput::default() };
    for _ in 0..20 {
        runtime.step(&input);
    }
    // Up to a millimetre from the walls between the rooms; room A and room C begin at these x, and are 5 m deep in z.
    [0.4, 6.4].map(|west: f32| {
        let along = |i: usize, from: f32, to: f32| from + (to - from) * i as f32 / 19.0;
        let place = |i: usize| {
            Vec3::new(along(i % 20, west, west + 3.3), along(i / 20 % 20, 0.1, 2.4), along(i / 400, 0.3, 4.7))
        };
        let lit = (0..8000).filter_map(|i| runtime.irradiance_in_air(place(i), Vec3::NEG_X));
        lit.map(Vec3::max_element).fold(0.0, f32::max)
    })
}

#[test]
fn the_air_of_a_sealed_room_stays_dark() {
    let options = BakeOptions { receivers: Some(6000), grid_vertices: Some(3000), ..quick(Method::Hybrid) };
    let baked = Arc::new(bake(load("rooms.glb"), &options, None, &Silent).unwrap());
    assert!(support::grid::levels(&baked) > 1);
    let [lit, sealed] = brightest_air(&baked, Vec3::new(4.2, 2.4, 1.6));
    assert!(lit > 0.1, "room A: {lit}");
    assert!(sealed <= 1e-6 * lit, "room C is lit through its walls: {sealed} of {lit}");
    // Negative control: a lamp within room C is seen there.
    let [dark, lit] = brightest_air(&baked, Vec3::new(8.0, 2.4, 2.5));
    assert!(lit > 0.1 && dark <= 1e-6 * lit, "room C: {lit}, room A: {dark}");
}
