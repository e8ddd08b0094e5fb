//! Faces that are mostly hidden, and faces that nearly touch: what can be seen of them is lit, and nothing more.

mod support;

use std::f32::consts::PI;
use std::sync::Arc;

use probelight_asset::{BakedScene, NONE};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::{EulerRot, Quat, Vec3};
use probelight_math::sampling::{sobol_owen, triangle_from_square};
use probelight_runtime::Runtime;
use probelight_scene::{Lighting, Scene, Sky};
use probelight_trace::{PathTracer, Silent, Tracer};

use support::shapes::{Shape, column, scene_of, solid, turned};

/// A scene and its bake.
struct Case {
    scene: Arc<Scene>,
    baked: BakedScene,
}

impl Case {
    fn new(shapes: Vec<(Shape, bool)>) -> Self {
        let scene = Arc::new(scene_of(shapes));
        let options = BakeOptions { receivers: Some(3000), gather_rays: Some(128), ..BakeOptions::default() };
        let baked = bake(scene.clone(), &options, None, &Silent).unwrap();
        Self { scene, baked }
    }

    /// Irradiance at points and normals under a sky of radiance 1: baked, and in truth.
    fn irradiance(&self, points: &[(Vec3, Vec3)]) -> Vec<(f32, f32)> {
        let lighting = Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() };
        let mut runtime = Runtime::new(Arc::new(self.baked.clone()));
        runtime.set_lighting(lighting.clone()).unwrap();
        runtime.converge(1e-4, 50);
        let path_tracer = PathTracer::new(Arc::new(Tracer::new(self.scene.clone())), lighting);
        let truth = path_tracer.irradiance_of_points(points, 64, 0, &Silent).unwrap();
        let baked =
            points.iter().map(|(position, normal)| runtime.irradiance_at(*position, *normal).unwrap().y);
        baked.zip(truth).map(|(baked, truth)| (baked, (truth.sky + truth.indirect).y)).collect()
    }

    /// Points on all triangles, on both sides of double-sided ones.
    fn points(&self, per_triangle: u32) -> Vec<(Vec3, Vec3)> {
        let sides = |t: usize| if self.scene.material(t).double_sided { vec![1.0, -1.0] } else { vec![1.0] };
        (0..self.scene.triangles.len())
            .flat_map(|t| sides(t).into_iter().map(move |side| (t, side)))
            .flat_map(|(t, side)| (0..per_triangle).map(move |i| (t, side, sobol_owen(i, t as u32))))
            .map(|(t, side, u)| {
                let position = self.scene.position(t, triangle_from_square(u));
                (position, self.scene.geometric_normal(t) * side)
            })
            .collect()
    }

    /// Asserts that nothing is brighter than the sky, and nothing black that is lit in truth.
    #[track_caller]
    fn assert_bounds(&self, per_triangle: u32) {
        let points = self.points(per_triangle);
        for ((position, normal), (baked, truth)) in points.iter().zip(self.irradiance(&points)) {
            assert!(baked <= 1.04 * PI, "{baked} at {position} facing {normal}");
            assert!(baked > 0.0 || truth < 0.1 * PI, "black at {position} facing {normal}, in truth {truth}");
        }
    }

    fn has_lit_back_faces(&self) -> bool {
        self.baked.lightmap.back_faces.iter().any(|face| *face != NONE)
    }
}

fn floor() -> (Shape, bool) {
    (solid(Vec3::new(-3.0, -0.2, -3.0), Vec3::new(3.0, 0.0, 3.0)), false)
}

#[test]
fn corners_of_plinths_under_round_columns_are_lit_and_insides_cost_nothing() {
    let half = 0.3;
    let plinth = solid(Vec3::new(-half, -0.01, -half), Vec3::new(half, 0.2, half));
    let shaft = column(Vec3::new(0.0, 0.19, 0.0), 0.98 * half, 2.5, 24);
    let case = Case::new(vec![floor(), (plinth, false), (shaft, false)]);
    let corners = [-0.93f32, 0.93].map(|x| [-0.93f32, 0.93].map(|z| Vec3::new(x * half, 0.2, z * half)));
    let points: Vec<(Vec3, Vec3)> = corners.into_iter().flatten().map(|p| (p, Vec3::Y)).collect();
    for (baked, truth) in case.irradiance(&points) {
        assert!((baked - truth).abs() < 0.2 * truth, "{baked} instead of {truth}");
    }
    case.assert_bounds(16);
    assert!(!case.has_lit_back_faces(), "the insides of closed solids have light");
    // Negative control: turned round, they would have.
    let turned = Case::new(vec![
        floor(),
        (turned(solid(Vec3::new(-1.0, 1.0, -1.0), Vec3::ONE * 2.0))[2..].to_vec(), false),
    ]);
    assert!(turned.has_lit_back_faces());
}

#[test]
fn slivers_of_half_sunk_columns_are_lit() {
    let leaning = |x: f32| -> Shape {
        let turn = Quat::from_rotation_z(1.2) * Quat::from_rotation_x(0.3);
        let shape = column(Vec3::new(0.0, -0.6, 0.0), 0.3, 1.2, 12);
        shape.into_iter().map(|corners| corners.map(|p| turn * p + Vec3::new(x, 0.02 * x, 0.0))).collect()
    };
    let case = Case::new(vec![floor(), (leaning(-1.5), false), (leaning(0.2), false), (leaning(1.7), false)]);
    case.assert_bounds(64);
}

#[test]
fn leaves_are_lit_on_both_sides_wherever_they_are() {
    let leaf = |i: u32| -> Shape {
        let (u, v) = (sobol_owen(i, 1), sobol_owen(i, 2));
        let turn = Quat::from_euler(EulerRot::XYZ, 6.3 * u.x, 6.3 * u.y, 6.3 * v.x);
        let at = Vec3::new(v.y, 0.7 + u.x, u.y);
        let corners = [(-0.05, 0.0), (0.0, 0.02), (0.05, 0.0), (0.0, -0.02)]
            .map(|(x, y)| turn * Vec3::new(x, y, 0.0) + at);
        vec![[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    };
    let case = Case::new(vec![floor(), ((0..150).flat_map(leaf).collect(), true)]);
    case.assert_bounds(4);
}

#[test]
fn a_room_turned_inside_out_is_reported_and_one_that_is_not_is_not() {
    let room = || solid(Vec3::ZERO, Vec3::new(4.0, 3.0, 5.0));
    let warns = |case: &Case| case.baked.report.warnings.iter().any(|warning| warning.contains("back faces"));
    assert!(warns(&Case::new(vec![(room(), false)])));
    assert!(!warns(&Case::new(vec![(turned(room()), false)])));
    assert!(!warns(&Case::new(vec![floor(), (solid(Vec3::ZERO, Vec3::ONE), false)])));
}
