//! The transport matrix A of a cluster: how much of each signal arrives at each receiver.
//!
//! A gather ray that ends on a near surface takes its radiance from the patch it met. One that ends far away,
//! at y, takes it from the probes that see y, in proportion to their weights; the direction Ψ from the probe
//! to y says which value of the probe's spherical function that is (\[SED\] eq. 3). A ray that leaves the
//! scene takes the value of the sky's spherical function. Summed over cosine-distributed rays with weight π/N
//! each, this is \[SED\] eq. 4 with the cosine that belongs to irradiance. A vertex of the grid has several rows from the
//! same rays, each of which takes its own share of them.

pub(crate) mod gather;
pub(crate) mod patch_choice;
pub(crate) mod probe_choice;
mod row_accumulator;
pub(crate) mod view;

use probelight_math::glam::Vec3;
use probelight_math::sh::Basis;
use probelight_trace::{Ray, Tracer};

use crate::ground::site::Place;
use crate::light::emitters::Emitters;
use crate::light::form_factors::EmitterSampling;
use crate::transport::gather::{GatherHit, GatherRay};
use crate::transport::patch_choice::PatchChoice;
use crate::transport::row_accumulator::{FinishedRows, RowAccumulator, nth_row};
use crate::transport::view::{SeenHalf, View};

/// A cluster's uncompressed transport.
#[derive(Clone, Debug, Default)]
pub(crate) struct Transport {
    /// Two estimates of A from half of the rays each, steradians. Row-major, one row per receiver (a texel has one, a vertex of the grid several); scalar
    /// signals, then the probes' coefficients in the asset's band-major order.
    pub(crate) halves: [Vec<f32>; 2],
    /// Number of columns.
    pub(crate) columns: usize,
    /// The scalar signals of the leading columns, in the asset's numbering.
    pub(crate) signals: Vec<u32>,
    /// Number of rays taken from the probe that sees nearest to their end, because none sees it.
    pub(crate) approximated_rays: u64,
    /// Number of rays lost: no probe shares any sight with the receiver, or they end inside solids.
    pub(crate) uncovered_rays: u64,
}

impl Transport {
    /// Removes scalar signals that no receiver of the cluster takes light from.
    pub(crate) fn drop_unused_signals(&mut self) {
        let is_used: Vec<bool> = (0..self.columns)
            .map(|c| {
                let mut values = self.halves.iter().flat_map(|half| half[c..].iter().step_by(self.columns));
                c >= self.signals.len() || values.any(|v| *v != 0.0)
            })
            .collect();
        for half in &mut self.halves {
            let mut column = is_used.iter().cycle();
            half.retain(|_| column.next().is_some_and(|used| *used));
        }
        let mut column = is_used.iter();
        self.signals.retain(|_| column.next().is_some_and(|used| *used));
        self.columns = is_used.iter().filter(|used| **used).count();
    }
}

/// The scalar signals that a cluster may draw on.
pub(crate) struct ScalarSignals<'a> {
    pub(crate) patches: &'a PatchChoice,
    pub(crate) emitters: &'a Emitters,
    pub(crate) sampling: EmitterSampling,
    pub(crate) sky: &'a Basis,
    /// Number of the first emitter's signal in the asset's numbering.
    pub(crate) first_emitter_signal: u32,
    /// Distance up to which surfaces are taken from patches, metres; without it, all.
    pub(crate) near_radius: Option<f32>,
}

impl ScalarSignals<'_> {
    /// The signals of the columns, in the asset's numbering.
    pub(crate) fn numbers(&self) -> Vec<u32> {
        let others = (self.emitters.signals.len() + self.sky.len()) as u32;
        let first = self.first_emitter_signal;
        self.patches.patches.iter().copied().chain(first..first + others).collect()
    }

    fn first_sky_column(&self) -> usize {
        self.patches.patches.len() + self.emitters.signals.len()
    }

    /// Share of a hit's light that is taken from patches: 1 near, 0 far away, smooth between, so that no line
    /// shows where probes take over.
    pub(crate) fn near_share(&self, distance: f32) -> f32 {
        let Some(radius) = self.near_radius else { return 1.0 };
        let t = ((HANDOVER_END - distance / radius) / (HANDOVER_END - HANDOVER_START)).clamp(0.0, 1.0);
        (3.0 - 2.0 * t) * t * t
    }
}

/// Where probes begin to take over from patches and where they have, as shares of the near radius.
const HANDOVER_START: f32 = 0.75;
const HANDOVER_END: f32 = 1.25;

/// What is needed to judge where a receiver's light comes from.
pub(crate) struct TransportBuilder<'a> {
    pub(crate) tracer: &'a Tracer,
    pub(crate) basis: &'a Basis,
    /// Signals besides the probes; none in the paper's method.
    pub(crate) scalars: Option<ScalarSignals<'a>>,
    /// Positions of the cluster's probes, metres.
    pub(crate) probes: Vec<Vec3>,
    /// Distance at which a probe's weight reaches zero (\[SL\]'s support radius), metres.
    pub(crate) support_radius: f32,
    /// [`BlurBalance::coverage`](crate::light::blur_balance::BlurBalance) of these probes; none in the paper's method.
    pub(crate) coverage: Vec<f32>,
}

/// \[SL\]'s kernel: 1 at the probe, 0 at and beyond the support radius, smooth at both ends.
pub(crate) fn support_kernel(distance: f32, radius: f32) -> f32 {
    let t = (distance / radius).min(1.0);
    (2.0 * t - 3.0) * t * t + 1.0
}

/// Once the probes tried hold this share of the weight that could still come, the rest is not tested.
const NEGLIGIBLE_REST: f32 = 0.02;

/// How much more light patches may bring than the rays that meet them would under even light: surfels may be brighter than
/// their patch. Below the inverse of any albedo up to 0.9, so that no crevice multiplies its own light by bounces.
const LARGEST_PATCH_SUM: f32 = 1.1;

/// Nearest distance that still raises a probe's weight, as a share of the support radius; keeps 1/d² finite.
const NEAREST_SHARE: f32 = 0.01;

/// A ray's end that probes serve.
struct FarEnd {
    hit: GatherHit,
    /// From the place, unit.
    direction: Vec3,
    /// Steradians of the place's lobe.
    weight: f32,
}

/// The part of a place's rows that does not come from probes.
struct ScalarRows<'a> {
    /// Row by row.
    patches: Vec<f32>,
    /// Row by row.
    emitters: Vec<f32>,
    sky: FinishedRows<'a>,
}

impl TransportBuilder<'_> {
    /// Adds a place's rows to both halves, each from one half of its view.
    pub(crate) fn add_rows(&self, place: &Place<'_>, view: &View, transport: &mut Transport) {
        for (half, seen) in view.halves.iter().enumerate() {
            self.add_half_rows(place, seen, half, transport);
        }
    }

    fn add_half_rows(&self, place: &Place<'_>, seen: &SeenHalf, half: usize, transport: &mut Transport) {
        let (scalars, far) = match &self.scalars {
            Some(scalars) => {
                let (rows, far) = self.scalar_rows(scalars, place, seen, half, transport);
                (Some(rows), far)
            }
            None => (None, seen.rays.iter().map(|ray| self.far_end(ray, 1.0)).collect()),
        };
        let of_probes = self.rows_of_probes(place, &far, transport);
        let (rows, columns) = (place.reception.rows(), &mut transport.halves[half]);
        for row in 0..rows {
            if let Some(ScalarRows { patches, emitters, sky }) = &scalars {
                columns.extend_from_slice(nth_row(patches, row, rows));
                columns.extend_from_slice(nth_row(emitters, row, rows));
                sky.append(row, columns);
            }
            of_probes.append(row, columns);
        }
        let scalars = self.scalars.as_ref().map_or(0, |s| s.first_sky_column() + s.sky.len());
        transport.columns = scalars + self.probes.len() * self.basis.len();
    }

    /// A share of what a ray brings, for probes.
    fn far_end(&self, ray: &GatherRay, share: f32) -> FarEnd {
        FarEnd { hit: ray.end(self.tracer), direction: ray.direction, weight: ray.weight * share }
    }

    /// The part of the rows that does not come from probes, and what is left for these.
    fn scalar_rows<'b>(
        &self,
        scalars: &ScalarSignals<'b>,
        place: &Place<'_>,
        seen: &SeenHalf,
        half: usize,
        transport: &mut Transport,
    ) -> (ScalarRows<'b>, Vec<FarEnd>) {
        let mut far = Vec::new();
        let rows = place.reception.rows();
        let (patches, emitters) = (scalars.patches.patches.len(), scalars.emitters.signals.len());
        // What the lobe brings from each patch, and of that each row.
        let mut lobe = vec![0.0; patches];
        let mut of_patches = vec![0.0; rows * patches];
        let mut near_rays = 0.0;
        let mut sky = RowAccumulator::new(scalars.sky, 1, rows, &[]);
        for (ray, surfel) in seen.rays.iter().zip(&seen.surfels) {
            let weight = ray.weight;
            let factors = place.reception.factors(ray.direction);
            let Some(hit) = ray.hit else {
                sky.add(0, ray.direction, weight, &factors);
                continue;
            };
            let near = scalars.near_share(hit.distance);
            if near < 1.0 {
                far.push(self.far_end(ray, 1.0 - near));
            }
            match scalars.patches.column(*surfel) {
                Some((column, share)) => {
                    let share = weight * near * share;
                    lobe[column] += share;
                    near_rays += weight * near;
                    let column_of_rows = of_patches[column..].iter_mut().step_by(patches);
                    column_of_rows.zip(factors).for_each(|(sum, factor)| *sum += factor * share);
                }
                None if near > 0.0 => transport.uncovered_rays += 1,
                None => {}
            }
        }
        let limit = within_limit(&lobe, LARGEST_PATCH_SUM * near_rays);
        of_patches.iter_mut().for_each(|sum| *sum *= limit);
        let mut of_emitters = vec![0.0; rows * emitters];
        let sampling = &scalars.sampling;
        scalars.emitters.add_form_factors(self.tracer, place, sampling, half, &seen.rays, &mut of_emitters);
        (ScalarRows { patches: of_patches, emitters: of_emitters, sky: sky.finish() }, far)
    }

    /// The part of the rows that comes from probes.
    fn rows_of_probes(
        &self,
        place: &Place<'_>,
        ends: &[FarEnd],
        transport: &mut Transport,
    ) -> FinishedRows<'_> {
        let rows = place.reception.rows();
        let mut accumulator = RowAccumulator::new(self.basis, self.probes.len(), rows, &self.coverage);
        let kernels: Vec<f32> = self
            .probes
            .iter()
            .map(|p| support_kernel(p.distance(place.site.position), self.support_radius))
            .collect();
        let mut has_seen = vec![false; self.probes.len()];
        let mut unserved = Vec::new();
        for end in ends {
            let seen = self.seeing_probes(&end.hit, &kernels);
            let factors = place.reception.factors(end.direction);
            let total: f32 = seen.iter().map(|(_, weight, _)| weight).sum();
            if total <= 0.0 {
                unserved.push(end);
            }
            for (probe, weight, direction) in seen {
                has_seen[probe] = true;
                accumulator.add(probe, direction, end.weight * weight / total, &factors);
            }
        }
        for end in unserved {
            match self.nearest_sight(&end.hit, &has_seen) {
                Some((probe, direction)) => {
                    let factors = place.reception.factors(end.direction);
                    accumulator.add(probe, direction, end.weight, &factors);
                    transport.approximated_rays += 1;
                }
                None => transport.uncovered_rays += 1,
            }
        }
        accumulator.finish()
    }

    /// The probes that see the end of a ray: (index, weight, direction from the probe).
    fn seeing_probes(&self, hit: &GatherHit, kernels: &[f32]) -> Vec<(usize, f32, Vec3)> {
        let mut candidates: Vec<(usize, f32, Vec3)> = (0..self.probes.len())
            .filter_map(|probe| {
                let (weight, direction) = self.weight_and_direction(probe, hit)?;
                Some((probe, weight * kernels[probe], direction))
            })
            .filter(|(_, weight, _)| *weight > 0.0)
            .collect();
        candidates.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut rest: f32 = candidates.iter().map(|(_, weight, _)| weight).sum();
        let mut sum = 0.0;
        candidates.retain(|(probe, weight, _)| {
            if sum > 0.0 && rest < NEGLIGIBLE_REST * sum {
                return false;
            }
            rest -= weight;
            let sees = self.sees(*probe, hit);
            sum += if sees { *weight } else { 0.0 };
            sees
        });
        candidates
    }

    /// Weight without the receiver's kernel, and direction from the probe; `None` if the surface faces away.
    /// The finer a probe resolves the surface around y, the more it counts: cosθ_y / |y − p|².
    fn weight_and_direction(&self, probe: usize, hit: &GatherHit) -> Option<(f32, Vec3)> {
        match hit {
            GatherHit::Sky(direction) => Some((1.0, *direction)),
            GatherHit::Surface { position, normal } => {
                let offset = *position - self.probes[probe];
                let squared = offset.length_squared();
                let direction = offset / squared.sqrt().max(f32::MIN_POSITIVE);
                let cosine = -normal.dot(direction);
                let nearest = NEAREST_SHARE * self.support_radius;
                (cosine > 0.0).then(|| (cosine / squared.max(nearest * nearest), direction))
            }
        }
    }

    fn sees(&self, probe: usize, hit: &GatherHit) -> bool {
        let from = self.probes[probe];
        match hit {
            GatherHit::Sky(direction) => !self.tracer.is_occluded(&Ray::new(from, *direction)),
            GatherHit::Surface { position, .. } => self.tracer.is_visible(*position, from),
        }
    }

    /// For a ray whose end no probe sees: the probe that, looking towards it, sees a surface nearest to it.
    /// Only probes that share some sight with the receiver count, so that no light crosses a wall.
    fn nearest_sight(&self, hit: &GatherHit, has_seen: &[bool]) -> Option<(usize, Vec3)> {
        (0..self.probes.len())
            .filter(|probe| has_seen[*probe])
            .map(|probe| {
                let from = self.probes[probe];
                let (direction, wanted) = match hit {
                    GatherHit::Sky(direction) => (*direction, f32::INFINITY),
                    GatherHit::Surface { position, .. } => {
                        let offset = *position - from;
                        let distance = offset.length().max(f32::MIN_POSITIVE);
                        (offset / distance, distance)
                    }
                };
                let seen =
                    self.tracer.closest_hit(&Ray::new(from, direction)).map_or(f32::INFINITY, |h| h.distance);
                // Between sky rays the probe that sees farthest is best.
                let miss = if wanted.is_finite() { (wanted - seen).abs() } else { 1.0 / (1.0 + seen) };
                (miss, probe, direction)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, probe, direction)| (probe, direction))
    }
}

/// The factor, at most 1, that brings the sum of some values down to `limit`.
fn within_limit(values: &[f32], limit: f32) -> f32 {
    let sum: f32 = values.iter().sum();
    if sum > limit { limit / sum } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use probelight_scene::Scene;

    use super::*;

    #[test]
    fn kernel_is_one_at_the_probe_and_vanishes_smoothly() {
        assert_eq!(support_kernel(0.0, 2.0), 1.0);
        assert_eq!(support_kernel(1.0, 2.0), 0.5);
        assert_eq!(support_kernel(2.0, 2.0), 0.0);
        assert_eq!(support_kernel(9.0, 2.0), 0.0);
        assert!(support_kernel(1.99, 2.0) < 1e-3);
    }

    fn share_at(near_radius: Option<f32>, distance: f32) -> f32 {
        let scene = Scene::default();
        let emitters = Emitters::default();
        let signals = ScalarSignals {
            patches: &PatchChoice::default(),
            emitters: &emitters,
            sampling: emitters.sampling(&scene.bounds()),
            sky: &Basis::new(0),
            first_emitter_signal: 0,
            near_radius,
        };
        signals.near_share(distance)
    }

    #[test]
    fn patches_hand_over_to_probes_smoothly() {
        let share = |distance: f32| share_at(Some(2.0), distance);
        assert_eq!([0.0, 2.0 * HANDOVER_START].map(share), [1.0; 2]);
        assert_eq!([2.0 * HANDOVER_END, 1e9].map(share), [0.0; 2]);
        assert!((share(2.0) - 0.5).abs() < 1e-6, "half at the radius itself");
        let steps: Vec<f32> = (0..=400).map(|i| share(0.01 * i as f32)).collect();
        assert!(steps.is_sorted_by(|a, b| a >= b));
        let steepest = steps.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f32::max);
        // A cubic's steepest slope is 3/2 of the mean one.
        assert!(steepest <= 1.51 * 0.01 / (2.0 * (HANDOVER_END - HANDOVER_START)), "{steepest}");
        assert_eq!(share_at(None, 1e9), 1.0, "without a radius, patches serve all distances");
    }

    #[test]
    fn sums_are_limited_and_smaller_ones_stay() {
        let limited = |limit| within_limit(&[1.0, 3.0], limit);
        assert_eq!([2.0, 5.0].map(limited), [0.5, 1.0]);
    }

    #[test]
    fn unused_signals_leave_both_halves_and_probes_stay() {
        // Columns: three scalar signals, of which the second is used in one half only, and two of probes.
        let mut transport = Transport {
            halves: [vec![0.0, 0.0, 3.0, 0.0, 5.0, 0.0, 0.0, 8.0, 0.0, 0.0], {
                let mut half = vec![0.0; 10];
                half[1] = 2.0;
                half
            }],
            columns: 5,
            signals: vec![10, 20, 30],
            ..Transport::default()
        };
        transport.drop_unused_signals();
        assert_eq!((transport.columns, &transport.signals[..]), (4, &[20, 30][..]));
        assert_eq!(transport.halves[0], [0.0, 3.0, 0.0, 5.0, 0.0, 8.0, 0.0, 0.0]);
        assert_eq!(transport.halves[1], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
