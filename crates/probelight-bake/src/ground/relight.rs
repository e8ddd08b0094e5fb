//! What the probes' relight rays meet.

use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::steps::for_each_in_parallel;

/// Traces all relight rays; a probe's hits in a row, in the order of `directions`. `None` is the sky.
pub(crate) fn trace_relight_rays(
    tracer: &Tracer,
    probes: &[Vec3],
    directions: &[Vec3],
    progress: &dyn Progress,
) -> Result<Vec<Option<Hit>>, BakeError> {
    let trace = |probe: &Vec3| -> Vec<Option<Hit>> {
        directions.iter().map(|direction| tracer.closest_hit(&Ray::new(*probe, *direction))).collect()
    };
    Ok(for_each_in_parallel("tracing relight rays", probes.par_iter(), progress, trace)?.concat())
}
