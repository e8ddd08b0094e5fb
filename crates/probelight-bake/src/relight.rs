//! What the probes' relight rays meet.

use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;

/// Traces all relight rays; a probe's hits in a row, in the order of `directions`. `None` is the sky.
pub(crate) fn trace_relight_rays(
    tracer: &Tracer,
    probes: &[Vec3],
    directions: &[Vec3],
    progress: &dyn Progress,
) -> Result<Vec<Option<Hit>>, BakeError> {
    progress.begin("tracing relight rays", probes.len() as u64);
    let hits: Vec<Vec<Option<Hit>>> = probes
        .par_iter()
        .map(|probe| {
            if progress.is_cancelled() {
                return Vec::new();
            }
            progress.advance(1);
            directions.iter().map(|direction| tracer.closest_hit(&Ray::new(*probe, *direction))).collect()
        })
        .collect();
    if progress.is_cancelled() {
        return Err(BakeError::Cancelled);
    }
    Ok(hits.into_iter().flatten().collect())
}
