//! Random points on the scene's front faces.

use probelight_math::glam::Vec3;
use probelight_math::sampling::{Rng, triangle_from_square};
use probelight_scene::Scene;

/// A point on a front face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceSample {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
}

/// `count` points, stratified by area: sample i lies in the i-th of `count` equal shares of the surface.
pub(crate) fn sample_front_faces(scene: &Scene, count: usize, rng: &mut Rng) -> Vec<SurfaceSample> {
    let total = scene.surface_area();
    let mut samples = Vec::with_capacity(count);
    let mut triangle = 0;
    let mut passed = 0f64;
    let mut area = f64::from(scene.area(0));
    for i in 0..count {
        let target = (i as f64 + f64::from(rng.next_f32())) / count as f64 * total;
        while passed + area < target && triangle + 1 < scene.triangles.len() {
            passed += area;
            triangle += 1;
            area = f64::from(scene.area(triangle));
        }
        samples.push(SurfaceSample {
            position: scene.position(triangle, triangle_from_square(rng.next_vec2())),
            normal: scene.geometric_normal(triangle),
        });
    }
    samples
}
