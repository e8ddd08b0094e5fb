//! The rays a bake shoots, made once and then only traced.

use probelight_math::glam::Vec3;
use probelight_math::sampling::{
    Rng, cosine_hemisphere_from_square, sobol_owen, triangle_from_square, world_from_tangent,
};
use probelight_scene::Scene;
use probelight_trace::{Ray, Tracer};

/// Rays for each receiver, as consecutive as a bake shoots them.
const RAYS_PER_RECEIVER: u32 = 256;

/// Visibility segments for each gather ray's hit.
const PROBES_PER_HIT: usize = 4;

/// Cosine-distributed rays from `receivers` random points of the scene's surface, evenly by area.
pub(crate) fn gather_rays(tracer: &Tracer, receivers: u32) -> Vec<Ray> {
    let scene = tracer.scene();
    let cumulative = cumulative_areas(scene);
    let mut rng = Rng::new(1, 0);
    let mut rays = Vec::with_capacity((receivers * RAYS_PER_RECEIVER) as usize);
    for receiver in 0..receivers {
        let wanted = f64::from(rng.next_f32()) * cumulative[cumulative.len() - 1];
        let triangle = cumulative.partition_point(|sum| *sum <= wanted).min(cumulative.len() - 1);
        let at = triangle_from_square(rng.next_vec2());
        let normal = tracer.front_normal(triangle as u32);
        let origin = tracer.off_surface(scene.position(triangle, at), normal);
        let frame = world_from_tangent(normal);
        rays.extend(
            (0..RAYS_PER_RECEIVER).map(|ray| {
                Ray::new(origin, frame * cosine_hemisphere_from_square(sobol_owen(ray, receiver)))
            }),
        );
    }
    rays
}

/// Segments from the hits of every eighth of the gather rays to places near the receiver that a probe may
/// take; `max_distance` is 1 and the direction has the segment's length.
pub(crate) fn visibility_segments(tracer: &Tracer, gather_rays: &[Ray]) -> Vec<Ray> {
    let reach = tracer.scene().bounds().diagonal() * 0.1;
    let mut rng = Rng::new(2, 0);
    let mut segments = Vec::new();
    for of_receiver in gather_rays.chunks(RAYS_PER_RECEIVER as usize) {
        let probes: [Vec3; PROBES_PER_HIT] = std::array::from_fn(|i| {
            let ray = of_receiver[i * 61];
            let free = tracer.closest_hit(&ray).map_or(reach, |hit| hit.distance.min(reach));
            ray.origin + ray.direction * (free * (0.1 + 0.8 * rng.next_f32()))
        });
        for ray in of_receiver.iter().step_by(8) {
            let Some(hit) = tracer.closest_hit(ray) else { continue };
            let origin = tracer.off_surface(ray.origin + ray.direction * hit.distance, hit.normal);
            segments.extend(probes.iter().map(|probe| Ray {
                origin,
                direction: *probe - origin,
                max_distance: 1.0,
            }));
        }
    }
    segments
}

fn cumulative_areas(scene: &Scene) -> Vec<f64> {
    let mut sum = 0.0;
    (0..scene.triangles.len())
        .map(|t| {
            sum += f64::from(scene.area(t));
            sum
        })
        .collect()
}
