//! Where to measure light.
//!
//! Candidates are surveyed places that see light ([`crate::air`]). They are thinned, the most open first: a candidate is dropped if a probe nearer than its own spacing
//! already sees it. A wall between the two keeps both, so every room gets probes. The spacing follows the
//! local free distance, because radiance changes faster in tight places.

use probelight_math::glam::Vec3;
use probelight_trace::{Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::limits::PROBES_TRIED_IN_PLACING;
use crate::air::point_tree::PointTree;
use crate::air::{Air, LitSides};
use crate::ground::receivers::Receiver;
use crate::options::Wishes;
use crate::steps::for_each_in_parallel;

/// Spacing as a share of the local free distance.
const SPACING_PER_FREE_DISTANCE: f32 = 0.6;

/// Distance to the nearest surface as a share of the spacing. A probe close to a bright surface sees it fill
/// half the sphere with a hard edge, which rings in the bands that a probe has.
const CLEARANCE_PER_SPACING: f32 = 0.15;

/// Places probes for the scene and its receivers.
pub(crate) fn place_probes(
    air: &Air<'_>,
    wishes: &Wishes,
    lit_sides: &LitSides,
    receivers: &[Receiver],
    progress: &dyn Progress,
) -> Result<Vec<Vec3>, BakeError> {
    let tracer = air.tracer();
    let (widest, smallest) = (wishes.widest_spacing, wishes.smallest_spacing);
    let mut candidates = air.places_for_probes(lit_sides);
    progress.begin("placing probes", candidates.len() as u64);
    candidates.sort_by(|a, b| b.free_distance.total_cmp(&a.free_distance));
    let mut probes = PointTree::default();
    for candidate in candidates {
        if progress.is_cancelled() {
            return Err(BakeError::Cancelled);
        }
        progress.advance(1);
        let spacing = (candidate.free_distance * SPACING_PER_FREE_DISTANCE).clamp(smallest, widest);
        let is_clear = candidate.clearance >= CLEARANCE_PER_SPACING * spacing;
        if is_clear
            && !probes.any_within(candidate.position, spacing, |p| tracer.is_visible(p, candidate.position))
        {
            probes.insert(candidate.position);
        }
    }
    cover_receivers(tracer, widest, receivers, &mut probes, progress)?;
    Ok(probes.positions)
}

/// Adds a probe in front of every receiver that sees none of those around it.
fn cover_receivers(
    tracer: &Tracer,
    spacing: f32,
    receivers: &[Receiver],
    probes: &mut PointTree,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    let sees = |receiver: &Receiver| sees_a_probe(tracer, receiver, probes);
    let sighted =
        for_each_in_parallel("looking for receivers without probe", receivers.par_iter(), progress, sees)?;
    for (receiver, _) in receivers.iter().zip(sighted).filter(|(_, sees)| !sees) {
        if progress.is_cancelled() {
            return Err(BakeError::Cancelled);
        }
        // Probes added for an earlier receiver often serve this one too.
        if sees_a_probe(tracer, receiver, probes) {
            continue;
        }
        let origin = receiver.ray_origin(tracer);
        let ray = Ray { max_distance: spacing, ..Ray::new(origin, receiver.normal) };
        let free = tracer.closest_hit(&ray).map_or(spacing, |hit| hit.distance);
        probes.insert(origin + receiver.normal * (0.5 * free));
    }
    Ok(())
}

fn sees_a_probe(tracer: &Tracer, receiver: &Receiver, probes: &PointTree) -> bool {
    let origin = receiver.ray_origin(tracer);
    let is_before = |probe: Vec3| (probe - origin).dot(receiver.normal) > 0.0;
    probes.nearest_visible(tracer, origin, PROBES_TRIED_IN_PLACING, is_before).next().is_some()
}
