//! Random but plausible lightings of the scene, and what each makes of the signals.
//!
//! The compression keeps what matters under light that may really occur. Each lighting is one source: a lamp or a
//! spot in open space, a sun, a sky, an emitter. Since light adds up, their second moments hold for all mixtures.
//! Bounces are computed on the surfels alone, with a few rays each.

use std::f32::consts::{FRAC_1_PI, PI};

use half::f16;
use probelight_asset::{GAIN_STEPS, LightSample, NONE};
use probelight_math::color::{linear_from_srgb8, luminance};
use probelight_math::directions::weighted_basis;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_math::sh::coefficient_count;
use probelight_trace::{Progress, Ray, Tracer, direct_irradiance};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::Outpost;
use crate::ground::Groundwork;
use crate::ground::sample_point::SurfacePoint;
use crate::light::LightSources;
use crate::light::random_lights::{Lighting, draw_lightings, kind_weights};
use crate::light::surfels::SurfelTree;
use crate::steps::for_each_in_parallel;

/// Rays per surfel for bounced light, and bounces.
const RAYS: u32 = 64;
const BOUNCES: usize = 4;

/// The signals of a scene under each of many lightings. All lightings have the same mean surfel radiance, 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightEnsemble {
    /// Number of lightings.
    pub(crate) count: usize,
    /// Per scalar signal, then per lighting.
    scalars: Vec<f32>,
    /// Per probe and coefficient, then per lighting.
    probes: Vec<f32>,
    /// Per surfel group, then per lighting: standard deviation of its surfels' radiance.
    deviations: Vec<f16>,
    /// How much each lighting counts; 1 on average.
    weights: Vec<f32>,
}

impl LightEnsemble {
    /// A scalar signal under each lighting.
    pub(crate) fn scalar(&self, signal: usize) -> &[f32] {
        &self.scalars[signal * self.count..][..self.count]
    }

    /// A probe's coefficient (numbered through all probes) under each lighting.
    pub(crate) fn coefficient(&self, coefficient: usize) -> &[f32] {
        &self.probes[coefficient * self.count..][..self.count]
    }

    /// How much each lighting counts; 1 on average.
    pub(crate) fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Variance of the radiance of a group's surfels under each lighting.
    pub(crate) fn variances(&self, group: usize) -> impl Iterator<Item = f32> {
        self.deviations[group * self.count..][..self.count].iter().copied().map(variance)
    }
}

/// What the ensemble is made from.
#[derive(Clone, Copy)]
struct Input<'a> {
    /// Lamps may hang where its probes are.
    ground: &'a Groundwork,
    sources: &'a LightSources,
}

impl LightEnsemble {
    /// Draws the lightings and lights the surfels and probes with each.
    pub(crate) fn light(
        ground: &Groundwork,
        sources: &LightSources,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let input = Input { ground, sources };
        let lightings = draw_lightings(ground, &sources.emitters);
        let (count, surfels) = (lightings.len(), input.sources.surfels.surfels.len());
        // One list for all, as those below: many small ones would not be given back.
        let mut unbounced = vec![0.0; surfels * count];
        let light = |(surfel, unbounced)| LitSurfel::light(input, &lightings, surfel, unbounced);
        let surfels_to_light = (0..surfels).into_par_iter().zip(unbounced.par_chunks_mut(count.max(1)));
        let bounces = for_each_in_parallel("lighting with random lights", surfels_to_light, progress, light)?;
        let mut radiance = bounce(&unbounced, &bounces, count);
        drop((unbounced, bounces));
        let scales = normalize(&mut radiance, &input.sources.surfels.sizes[..surfels], count);
        let weights = kind_weights(&lightings);
        let mut ensemble = Self { count, scalars: radiance, weights, ..Self::default() };
        ensemble.add_groups(&input.sources.surfels);
        let sky = sky_of_directions(&input.ground.directions, &lightings, &scales);
        ensemble.probes = ensemble.light_probes(input, &sky);
        ensemble.add_emitters_and_sky(input, &lightings, &scales, &sky);
        Ok(ensemble)
    }

    /// Appends the groups' radiance.
    fn add_groups(&mut self, tree: &SurfelTree) {
        let (count, surfels) = (self.count, tree.surfels.len());
        self.scalars.reserve_exact(tree.groups.len() * count);
        self.deviations.reserve_exact(tree.groups.len() * count);
        for group in &tree.groups {
            let w = group.first_weight;
            let [a, b] = group.children.map(|child| child as usize * count);
            for i in 0..count {
                let [first, second] = [self.scalars[a + i], self.scalars[b + i]];
                let within = |child: usize| match child.checked_sub(surfels * count) {
                    Some(group) => variance(self.deviations[group + i]),
                    None => 0.0,
                };
                let between = w * (1.0 - w) * (first - second).powi(2);
                let deviation = (w * within(a) + (1.0 - w) * within(b) + between).sqrt();
                self.scalars.push(w * first + (1.0 - w) * second);
                self.deviations.push(f16::from_f32(deviation.min(f16::MAX.to_f32())));
            }
        }
    }

    /// The probes' coefficients from the surfels' radiance.
    fn light_probes(&self, input: Input<'_>, sky: &[f32]) -> Vec<f32> {
        let (count, rays) = (self.count, input.ground.directions.len());
        let coefficients = coefficient_count(input.ground.settings.sh_degree as usize);
        let table = weighted_basis(&input.ground.directions, input.ground.settings.sh_degree as usize);
        let sky = input.ground.settings.sky_degree.is_none().then_some(sky);
        // One list for all: it is the largest of the bake.
        let mut probes = vec![0.0; input.ground.probes.positions.len() * coefficients * count];
        probes
            .par_chunks_mut(coefficients * count)
            .zip(input.sources.relight_surfels.par_chunks(rays.max(1)))
            .zip(input.sources.balance.gains.par_chunks(rays.max(1)))
            .for_each(|((sums, surfels), gains)| {
                for (ray, (surfel, gain)) in surfels.iter().zip(gains).enumerate() {
                    let gain = f32::from(*gain) / f32::from(GAIN_STEPS);
                    let radiance = match (*surfel, sky) {
                        (NONE, None) => continue,
                        (NONE, Some(sky)) => &sky[ray * count..][..count],
                        (surfel, _) => self.scalar(surfel as usize),
                    };
                    for (sums, y) in sums.chunks_mut(count).zip(&table[ray * coefficients..][..coefficients])
                    {
                        add_scaled(sums, *y * gain, radiance);
                    }
                }
            });
        probes
    }

    /// Appends the emitters' and the sky's signals.
    fn add_emitters_and_sky(
        &mut self,
        input: Input<'_>,
        lightings: &[Lighting],
        scales: &[f32],
        sky: &[f32],
    ) {
        for signal in 0..input.sources.emitters.signals.len() as u32 {
            let is_on = |l: &Lighting| matches!(l, Lighting::Emitter(e) if *e == signal);
            let radiance = lightings.iter().zip(scales).map(|(l, scale)| if is_on(l) { *scale } else { 0.0 });
            self.scalars.extend(radiance);
        }
        let Some(degree) = input.ground.settings.sky_degree else { return };
        let coefficients = coefficient_count(degree as usize);
        let table = weighted_basis(&input.ground.directions, degree as usize);
        let mut sums = vec![0.0; coefficients * self.count];
        for (row, sky) in table.chunks_exact(coefficients).zip(sky.chunks(self.count)) {
            for (sums, y) in sums.chunks_mut(self.count).zip(row) {
                add_scaled(sums, *y, sky);
            }
        }
        self.scalars.extend(sums);
    }
}

/// The sky's radiance along each direction, then under each lighting.
fn sky_of_directions(directions: &[Vec3], lightings: &[Lighting], scales: &[f32]) -> Vec<f32> {
    let radiance = |direction: &Vec3, lighting: &Lighting| match lighting {
        Lighting::Sky(sky) => sky.radiance(*direction),
        _ => 0.0,
    };
    let along =
        |direction| lightings.iter().zip(scales).map(move |(l, scale)| scale * radiance(direction, l));
    directions.iter().flat_map(along).collect()
}

/// Where a surfel's bounced light comes from.
#[derive(Clone, Debug, Default)]
struct Bounces {
    /// Surfels that its rays meet, one entry for each such ray.
    seen: Vec<u32>,
    /// Share of the irradiance that each ray brings, times the albedo over π.
    weight: f32,
}

/// A surfel's light while it is found.
struct LitSurfel<'a> {
    /// Radiance without bounces, per lighting.
    unbounced: &'a mut [f32],
    bounces: Bounces,
}

impl LitSurfel<'_> {
    /// Finds a surfel's radiance without bounces, and where its bounces come from.
    fn light(input: Input<'_>, lightings: &[Lighting], surfel: usize, unbounced: &mut [f32]) -> Bounces {
        let surfel_samples = input.sources.surfels.surfels[surfel];
        let samples = &input.sources.surfels.light_samples[surfel_samples.first_sample as usize..]
            [..surfel_samples.sample_count as usize];
        let points = input.sources.surfels.lit_points_of(surfel);
        let albedo =
            samples.iter().map(|s| albedo(&input.ground.tracer, s)).sum::<f32>() / samples.len() as f32;
        for (value, lighting) in unbounced.iter_mut().zip(lightings) {
            *value = albedo * FRAC_1_PI * direct_irradiance_of(input, lighting, points);
        }
        let bounces = Bounces { seen: Vec::new(), weight: albedo * FRAC_1_PI * PI / RAYS as f32 };
        let mut lit = LitSurfel { unbounced, bounces };
        for ray in 0..RAYS {
            let point = &points[ray as usize % points.len()];
            lit.follow_ray(input, lightings, point, sobol_owen(ray, hash_pair(surfel as u32, 0x5e1f)));
        }
        if input.ground.settings.sky_degree.is_none() {
            lit.add_own_emission(input, lightings, samples);
        }
        lit.bounces
    }

    /// Adds what one ray brings: the sky's or an emitter's light at once, a surfel's later.
    fn follow_ray(&mut self, input: Input<'_>, lightings: &[Lighting], point: &SurfacePoint, u: Vec2) {
        let Outpost { origin, normal } = point.outpost(&input.ground.tracer);
        let direction = world_from_tangent(normal) * cosine_hemisphere_from_square(u);
        let Some(hit) = input.ground.tracer.closest_hit(&Ray::new(origin, direction)) else {
            for (value, lighting) in self.unbounced.iter_mut().zip(lightings) {
                if let Lighting::Sky(sky) = lighting {
                    *value += self.bounces.weight * sky.radiance(direction);
                }
            }
            return;
        };
        if let Some(signal) = input.sources.emitters.signal_of_hit(&hit) {
            for (value, lighting) in self.unbounced.iter_mut().zip(lightings) {
                if matches!(lighting, Lighting::Emitter(e) if *e == signal) {
                    *value += self.bounces.weight;
                }
            }
        }
        let surfel = input.sources.surfels.surfel_of_hit(&input.ground.atlas, &hit);
        if surfel != NONE {
            self.bounces.seen.push(surfel);
        }
    }

    /// Emission that the probes see, where emitters have no signals of their own.
    fn add_own_emission(&mut self, input: Input<'_>, lightings: &[Lighting], samples: &[LightSample]) {
        for sample in samples.iter().filter(|s| !s.is_back_face()) {
            let signal = input.sources.emitters.signal_of_triangle(sample.triangle());
            for (value, lighting) in self.unbounced.iter_mut().zip(lightings) {
                if matches!(lighting, Lighting::Emitter(e) if Some(*e) == signal) {
                    *value += 1.0 / samples.len() as f32;
                }
            }
        }
    }
}

/// Mean irradiance of some points straight from a lighting, if it is analytic.
fn direct_irradiance_of(input: Input<'_>, lighting: &Lighting, points: &[SurfacePoint]) -> f32 {
    let Lighting::Analytic(light) = lighting else { return 0.0 };
    let (tracer, lights) = (&input.ground.tracer, std::slice::from_ref(light));
    let at = |p: &SurfacePoint| direct_irradiance(tracer, lights, p.position(tracer), p.normal(tracer)).x;
    points.iter().map(at).sum::<f32>() / points.len() as f32
}

fn albedo(tracer: &Tracer, sample: &LightSample) -> f32 {
    let factor = tracer.scene().material(sample.triangle() as usize).base_color.truncate();
    luminance(factor * linear_from_srgb8(sample.base_color()))
}

/// The surfels' radiance per lighting, after some bounces.
fn bounce(unbounced: &[f32], bounces: &[Bounces], count: usize) -> Vec<f32> {
    let mut radiance = unbounced.to_vec();
    let mut next = vec![0.0; radiance.len()];
    for _ in 0..BOUNCES {
        let surfels = next.par_chunks_mut(count.max(1)).zip(unbounced.par_chunks(count.max(1))).zip(bounces);
        surfels.for_each(|((next, unbounced), Bounces { seen, weight })| {
            next.fill(0.0);
            for seen in seen {
                add_scaled(next, *weight, &radiance[*seen as usize * count..][..count]);
            }
            add_scaled(next, 1.0, unbounced);
        });
        std::mem::swap(&mut radiance, &mut next);
    }
    radiance
}

/// Scales each lighting to a mean radiance of 1; returns the factors, 0 for lightings that reach nothing.
fn normalize(radiance: &mut [f32], sizes: &[u32], count: usize) -> Vec<f32> {
    let mut sums = vec![0f32; count];
    for (values, size) in radiance.chunks(count.max(1)).zip(sizes) {
        add_scaled(&mut sums, *size as f32, values);
    }
    let total: f32 = sizes.iter().map(|s| *s as f32).sum();
    let scales: Vec<f32> = sums.into_iter().map(|sum| if sum > 0.0 { total / sum } else { 0.0 }).collect();
    for values in radiance.chunks_mut(count.max(1)) {
        values.iter_mut().zip(&scales).for_each(|(value, scale)| *value *= scale);
    }
    scales
}

fn variance(deviation: f16) -> f32 {
    deviation.to_f32().powi(2)
}

/// `sums += factor · values`.
pub(crate) fn add_scaled(sums: &mut [f32], factor: f32, values: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += factor * value;
    }
}
