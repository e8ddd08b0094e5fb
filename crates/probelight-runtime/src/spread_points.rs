//! Points spread evenly over surfaces, to tell their shape.

use probelight_math::glam::Vec2;
use probelight_math::sampling::sobol_owen;
use probelight_scene::Scene;

/// Spreads `count` points evenly over some triangles: a triangle and barycentric weights of its second and third corner each.
/// None where there is no area.
pub(crate) fn spread_points(scene: &Scene, triangles: &[usize], count: u32) -> Vec<(usize, Vec2)> {
    let ends = triangles.iter().scan(0.0, |sum, triangle| {
        *sum += f64::from(scene.area(*triangle));
        Some(*sum)
    });
    let ends: Vec<f64> = ends.collect();
    let Some(total) = ends.last().filter(|area| **area > 0.0) else { return Vec::new() };
    let point = |i: u32| {
        let at = (f64::from(i) + 0.5) / f64::from(count) * total;
        let triangle = triangles[ends.partition_point(|end| *end < at).min(ends.len() - 1)];
        let barycentric = sobol_owen(i, 0);
        (triangle, if barycentric.element_sum() > 1.0 { 1.0 - barycentric } else { barycentric })
    };
    (0..count).map(point).collect()
}
