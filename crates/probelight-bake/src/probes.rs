//! Where to measure light.
//!
//! Candidates are empty voxels next to surfaces. Those inside solids are rejected by what they see. The
//! rest are thinned, the most open first: a candidate is dropped if a probe nearer than its own spacing
//! already sees it. A wall between the two keeps both, so every room gets probes. The spacing follows the
//! local free distance, because radiance changes faster in tight places.

use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::Vec3;
use probelight_trace::{Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::options::Wishes;
use crate::point_grid::PointGrid;
use crate::receivers::Receiver;
use crate::sides::LitSides;
use crate::voxels::VoxelGrid;

/// Rays that look around a candidate.
const LOOK_RAYS: usize = 128;

/// Spacing as a share of the local free distance.
const SPACING_PER_FREE_DISTANCE: f32 = 0.6;

/// Distance to the nearest surface as a share of the spacing. A probe close to a bright surface sees it fill
/// half the sphere with a hard edge, which rings in the bands that a probe has.
const CLEARANCE_PER_SPACING: f32 = 0.15;

/// Candidates seeing more unlit sides than this are inside solids.
const MAX_UNLIT_SHARE: f32 = 0.2;

/// Nearest probes among which a receiver must see one.
const PROBES_TRIED_PER_RECEIVER: usize = 12;

/// A place that may become a probe.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    position: Vec3,
    /// Median distance to what it sees, metres.
    free_distance: f32,
    /// Distance to the nearest surface it sees, metres.
    clearance: f32,
}

/// Places probes for the scene and its receivers.
pub(crate) fn place_probes(
    tracer: &Tracer,
    wishes: &Wishes,
    lit_sides: &LitSides,
    receivers: &[Receiver],
    progress: &dyn Progress,
) -> Result<Vec<Vec3>, BakeError> {
    let (widest, smallest) = (wishes.widest_spacing, wishes.smallest_spacing);
    let grid = VoxelGrid::new(tracer.scene(), smallest * 0.5);
    let places = grid.empty_near_surfaces(if wishes.has_uniform_spacing() { 2 } else { 4 });
    progress.begin("placing probes", places.len() as u64);
    let mut candidates: Vec<Candidate> = places
        .par_iter()
        .filter_map(|(position, _)| {
            progress.advance(1);
            look_around(tracer, lit_sides, *position)
        })
        .collect();
    if progress.is_cancelled() {
        return Err(BakeError::Cancelled);
    }
    candidates.sort_by(|a, b| b.free_distance.total_cmp(&a.free_distance));
    let mut probes = PointGrid::new(smallest);
    for candidate in candidates {
        let spacing = (candidate.free_distance * SPACING_PER_FREE_DISTANCE).clamp(smallest, widest);
        let is_clear = candidate.clearance >= CLEARANCE_PER_SPACING * spacing;
        if is_clear
            && !probes.any_within(candidate.position, spacing, |p| tracer.is_visible(p, candidate.position))
        {
            probes.insert(candidate.position);
        }
    }
    cover_receivers(tracer, widest, receivers, &mut probes);
    Ok(probes.positions)
}

/// Judges a place by what it sees; `None` if it lies inside a solid or sees nothing at all.
fn look_around(tracer: &Tracer, lit_sides: &LitSides, position: Vec3) -> Option<Candidate> {
    let mut distances = Vec::with_capacity(LOOK_RAYS);
    let mut unlit = 0;
    for ray in 0..LOOK_RAYS {
        let direction = spherical_fibonacci(ray, LOOK_RAYS);
        if let Some(hit) = tracer.closest_hit(&Ray::new(position, direction)) {
            distances.push(hit.distance);
            unlit += usize::from(!lit_sides.is_lit(&hit));
        } else {
            distances.push(f32::INFINITY);
        }
    }
    distances.sort_by(f32::total_cmp);
    let sees_surface = distances[0].is_finite();
    let in_air = unlit as f32 <= MAX_UNLIT_SHARE * LOOK_RAYS as f32;
    (sees_surface && in_air).then(|| Candidate {
        position,
        free_distance: distances[LOOK_RAYS / 2],
        clearance: distances[0],
    })
}

/// Adds a probe in front of every receiver that sees none of those around it.
fn cover_receivers(tracer: &Tracer, spacing: f32, receivers: &[Receiver], probes: &mut PointGrid) {
    let unseen: Vec<&Receiver> =
        receivers.par_iter().filter(|receiver| !sees_a_probe(tracer, receiver, probes)).collect();
    for receiver in unseen {
        // Probes added for an earlier receiver often serve this one too.
        if sees_a_probe(tracer, receiver, probes) {
            continue;
        }
        let origin = receiver.ray_origin(tracer);
        let ray = Ray { max_distance: spacing, ..Ray::new(origin, receiver.normal) };
        let free = tracer.closest_hit(&ray).map_or(spacing, |hit| hit.distance);
        probes.insert(origin + receiver.normal * (0.5 * free));
    }
}

fn sees_a_probe(tracer: &Tracer, receiver: &Receiver, probes: &PointGrid) -> bool {
    let origin = receiver.ray_origin(tracer);
    probes
        .nearest(origin, PROBES_TRIED_PER_RECEIVER)
        .into_iter()
        .map(|probe| probes.positions[probe as usize])
        .any(|probe| (probe - origin).dot(receiver.normal) > 0.0 && tracer.is_visible(origin, probe))
}
