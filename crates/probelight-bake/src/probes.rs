//! Where to measure light.
//!
//! Candidates are empty voxels next to surfaces. Those inside solids are rejected by what they see. The
//! rest are thinned, the most open first: a candidate is dropped if a probe nearer than its own spacing
//! already sees it. A wall between the two keeps both, so every room gets probes. The spacing follows the
//! local free distance, because radiance changes faster in tight places.

use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::{IVec3, Vec3};
use probelight_trace::{Progress, Ray, Tracer};
use rayon::prelude::*;
use std::collections::HashMap;

use crate::BakeError;
use crate::options::Resolved;
use crate::receivers::Receiver;
use crate::sides::LitSides;
use crate::voxels::VoxelGrid;

/// Rays that look around a candidate.
const LOOK_RAYS: usize = 128;

/// Spacing as a share of the local free distance.
const SPACING_PER_FREE_DISTANCE: f32 = 0.6;

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
}

/// Places probes for the scene and its receivers.
pub(crate) fn place_probes(
    tracer: &Tracer,
    resolved: &Resolved,
    lit_sides: &LitSides,
    receivers: &[Receiver],
    progress: &dyn Progress,
) -> Result<Vec<Vec3>, BakeError> {
    let (widest, uniform_spacing) = (resolved.settings.probe_spacing, resolved.uniform_spacing);
    let smallest = resolved.smallest_spacing();
    let grid = VoxelGrid::new(tracer.scene(), smallest * 0.5);
    let places = grid.empty_near_surfaces(if uniform_spacing { 2 } else { 4 });
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
    let mut probes = ProbeSet::new(smallest);
    for candidate in candidates {
        let spacing = if uniform_spacing {
            widest
        } else {
            (candidate.free_distance * SPACING_PER_FREE_DISTANCE).clamp(smallest, widest)
        };
        if !probes.any_within(candidate.position, spacing, |p| tracer.is_visible(p, candidate.position)) {
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
    (sees_surface && in_air).then(|| Candidate { position, free_distance: distances[LOOK_RAYS / 2] })
}

/// Adds a probe in front of every receiver that sees none of those around it.
fn cover_receivers(tracer: &Tracer, spacing: f32, receivers: &[Receiver], probes: &mut ProbeSet) {
    let unseen: Vec<&Receiver> =
        receivers.par_iter().filter(|receiver| !sees_a_probe(tracer, receiver, probes)).collect();
    for receiver in unseen {
        // Probes added for an earlier receiver often serve this one too.
        if sees_a_probe(tracer, receiver, probes) {
            continue;
        }
        let origin = receiver.position + receiver.normal * tracer.offset();
        let ray = Ray { max_distance: spacing, ..Ray::new(origin, receiver.normal) };
        let free = tracer.closest_hit(&ray).map_or(spacing, |hit| hit.distance);
        probes.insert(origin + receiver.normal * (0.5 * free));
    }
}

fn sees_a_probe(tracer: &Tracer, receiver: &Receiver, probes: &ProbeSet) -> bool {
    let origin = receiver.position + receiver.normal * tracer.offset();
    probes
        .nearest(origin, PROBES_TRIED_PER_RECEIVER)
        .into_iter()
        .map(|probe| probes.positions[probe as usize])
        .any(|probe| (probe - origin).dot(receiver.normal) > 0.0 && tracer.is_visible(origin, probe))
}

/// Probe positions with a hash grid for neighbour queries.
pub(crate) struct ProbeSet {
    cell: f32,
    /// Positions in order of insertion.
    pub(crate) positions: Vec<Vec3>,
    cells: HashMap<IVec3, Vec<u32>>,
    low: IVec3,
    high: IVec3,
}

impl ProbeSet {
    /// An empty set for queries of about `cell` metres.
    pub(crate) fn new(cell: f32) -> Self {
        Self { cell, positions: Vec::new(), cells: HashMap::new(), low: IVec3::MAX, high: IVec3::MIN }
    }

    /// A set of given positions.
    pub(crate) fn of(positions: &[Vec3], cell: f32) -> Self {
        let mut set = Self::new(cell);
        for position in positions {
            set.insert(*position);
        }
        set
    }

    fn cell_of(&self, position: Vec3) -> IVec3 {
        (position / self.cell).floor().as_ivec3()
    }

    fn insert(&mut self, position: Vec3) {
        let cell = self.cell_of(position);
        self.low = self.low.min(cell);
        self.high = self.high.max(cell);
        self.cells.entry(cell).or_default().push(self.positions.len() as u32);
        self.positions.push(position);
    }

    /// Whether a probe within `radius` of `centre` satisfies `test`.
    fn any_within(&self, centre: Vec3, radius: f32, test: impl Fn(Vec3) -> bool) -> bool {
        let reach = (radius / self.cell).ceil() as i32;
        let middle = self.cell_of(centre);
        cube(middle - reach, middle + reach).filter_map(|cell| self.cells.get(&cell)).flatten().any(|p| {
            let position = self.positions[*p as usize];
            position.distance_squared(centre) < radius * radius && test(position)
        })
    }

    /// The `count` probes nearest to a point, nearest first.
    pub(crate) fn nearest(&self, centre: Vec3, count: usize) -> Vec<u32> {
        let middle = self.cell_of(centre);
        let farthest = (middle - self.low).max(self.high - middle).max_element().max(0);
        let mut found: Vec<(f32, u32)> = Vec::new();
        for shell in 0..=farthest {
            // Everything in this shell is at least this far away.
            let shell_distance = (shell - 1).max(0) as f32 * self.cell;
            if found.len() >= count {
                found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                if found[count - 1].0 <= shell_distance * shell_distance {
                    break;
                }
            }
            for cell in shell_cells(middle, shell) {
                for p in self.cells.get(&cell).into_iter().flatten() {
                    found.push((self.positions[*p as usize].distance_squared(centre), *p));
                }
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(count);
        found.into_iter().map(|(_, p)| p).collect()
    }
}

/// All cells of a box, corners included.
fn cube(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    (low.z..=high.z).flat_map(move |z| {
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z)))
    })
}

/// The cells at Chebyshev distance `shell` from `middle`.
fn shell_cells(middle: IVec3, shell: i32) -> impl Iterator<Item = IVec3> {
    cube(middle - shell, middle + shell).filter(move |cell| (*cell - middle).abs().max_element() == shell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::sampling::Rng;

    #[test]
    fn nearest_agrees_with_a_full_search() {
        let mut rng = Rng::new(3, 4);
        let mut point = || 10.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let positions: Vec<Vec3> = (0..300).map(|_| point()).collect();
        let set = ProbeSet::of(&positions, 0.7);
        for _ in 0..50 {
            let centre = point() * 1.5;
            let mut all: Vec<u32> = (0..300).collect();
            all.sort_by(|a, b| {
                let d = |i: &u32| positions[*i as usize].distance_squared(centre);
                d(a).total_cmp(&d(b))
            });
            assert_eq!(set.nearest(centre, 17), all[..17]);
        }
        assert_eq!(set.nearest(Vec3::ZERO, 1000).len(), 300);
    }
}
