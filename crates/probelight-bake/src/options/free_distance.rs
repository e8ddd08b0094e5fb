//! The scale of a scene's spaces: how far light travels from one surface to the next.

use probelight_math::sampling::{Rng, cosine_hemisphere_from_square, sobol_owen, world_from_tangent};
use probelight_trace::{Ray, Tracer};
use rayon::prelude::*;

use crate::surface_samples::sample_front_faces;

/// Median distance that light travels from a surface to the next, metres. Where no surface sees another, a third of
/// the scene's diagonal.
pub(crate) fn typical_free_distance(tracer: &Tracer) -> f32 {
    let samples = sample_front_faces(tracer.scene(), 4096, &mut Rng::new(0, 17));
    let mut distances: Vec<f32> = samples
        .par_iter()
        .enumerate()
        .filter_map(|(i, sample)| {
            let local = cosine_hemisphere_from_square(sobol_owen(i as u32, 23));
            let ray = Ray::new(
                sample.position + sample.normal * tracer.offset(),
                world_from_tangent(sample.normal) * local,
            );
            tracer.closest_hit(&ray).filter(|hit| !hit.is_back_face).map(|hit| hit.distance)
        })
        .collect();
    distances.sort_by(f32::total_cmp);
    let diagonal = || tracer.scene().bounds().size().length();
    distances.get(distances.len() / 2).copied().unwrap_or_else(|| diagonal() / 3.0)
}
