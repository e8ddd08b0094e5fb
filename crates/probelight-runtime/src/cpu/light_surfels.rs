//! Stage 1: the scalar signals: radiance of surfels, surfel groups and emitters, coefficients of the sky.
//!
//! A surfel's radiance is the mean of its samples' `L = Le + ρ/π · (E_direct + E_lightmap)`: emission of front
//! faces, and the light that the sample's side reflects. `E_lightmap` is last frame's lightmap, which holds
//! everything that arrives by way of the signals. Where emitters have signals of their own, surfels leave Le out.
//!
//! What changes rarely is kept: shadow rays are only traced when a light changed or an object moved, the terms
//! without feedback are only evaluated then or when a material changed. Every frame then is one multiplication per sample.
//! Feedback is clamped at zero, because truncated matrices can yield slightly negative irradiance and no
//! surface reflects that.

use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

use probelight_asset::{BakedScene, LightSample, Surfel, SurfelGroup};
use probelight_math::color::linear_from_srgb;
use probelight_math::glam::Vec3;
use probelight_scene::{Light, Lighting, Sky};
use probelight_trace::{Tracer, World, direct_irradiance, shadow_ray};
use rayon::prelude::*;

use crate::IrradianceLightmap;
use crate::frame::BLOCK;
use crate::sky_signals::SkyProjection;
use crate::surface_colors::{SurfaceColors, emitter_radiance, has_emitter};

/// Samples a task works through.
const SAMPLES_PER_TASK: usize = 2048;

/// Surfels a task works through.
const SURFELS_PER_TASK: usize = 512;

/// All scalar signals, and the parts of them that outlast a frame.
#[derive(Clone, Debug)]
pub struct ScalarSignals {
    /// Irradiance of the analytic lights at each sample, W/m², as if nothing moved through the scene.
    unshadowed: Vec<Vec3>,
    /// The same in the shadows of objects.
    direct: Vec<Vec3>,
    /// Radiance of each sample without feedback: emission and reflected direct light.
    unbounced: Vec<Vec3>,
    /// What each sample reflects of last frame's light.
    feedback: Vec<Feedback>,
    /// Mean of each surfel's `unbounced`.
    unbounced_means: Vec<Vec3>,
    /// Whether emitters carry the emission of a material.
    has_emitter: Vec<bool>,
    sky: SkyProjection,
    /// In the order of [`scalar_signals`](probelight_asset::BakedParts::scalar_signals).
    values: Vec<Vec3>,
    linear_from_srgb: [f32; 256],
}

/// How a sample reflects the lightmap.
#[derive(Clone, Copy, Debug, Default)]
struct Feedback {
    /// ρ/π.
    reflectance: Vec3,
    /// The texel, or [`NONE`](probelight_asset::NONE) where the lightmap has nothing.
    texel: u32,
}

impl ScalarSignals {
    /// Darkness for a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let dark = vec![Vec3::ZERO; baked.light_samples.len()];
        let feedback = |sample: &LightSample| Feedback { texel: sample.texel, ..Feedback::default() };
        Self {
            unshadowed: dark.clone(),
            direct: dark.clone(),
            unbounced: dark,
            feedback: baked.light_samples.iter().map(feedback).collect(),
            unbounced_means: vec![Vec3::ZERO; baked.surfels.len()],
            has_emitter: has_emitter(baked),
            sky: SkyProjection::new(baked),
            values: vec![Vec3::ZERO; baked.scalar_signals()],
            linear_from_srgb: std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0)),
        }
    }

    /// All scalar signals in the order of [`scalar_signals`](probelight_asset::BakedParts::scalar_signals), W·m⁻²·sr⁻¹.
    pub fn values(&self) -> &[Vec3] {
        &self.values
    }

    /// Traces shadow rays against what stands still, for the samples whose turn it is. Needed when a light changed, before
    /// [`cast_object_shadows`](Self::cast_object_shadows).
    pub fn trace_direct(&mut self, baked: &BakedScene, tracer: &Tracer, lights: &[Light], turn: SampleTurn) {
        for_each_sample(&mut self.unshadowed, baked, tracer, turn, |direct, position, normal| {
            *direct = direct_irradiance(tracer, lights, position, normal);
        });
    }

    /// Traces shadow rays against objects: direct irradiance of the samples whose turn it is. Needed when a light changed or
    /// an object moved.
    pub fn cast_object_shadows(
        &mut self,
        baked: &BakedScene,
        world: World<'_>,
        lights: &[Light],
        turn: SampleTurn,
    ) {
        for index in turn.samples(self.direct.len()) {
            self.direct[index] = self.unshadowed[index];
        }
        if world.objects.is_empty() {
            return;
        }
        let offset = world.tracer.offset();
        for_each_sample(&mut self.direct, baked, world.tracer, turn, |direct, position, normal| {
            let is_hidden = |light: &Light| {
                let arriving = light.illuminate(position).filter(|it| it.to_light.dot(normal) > 0.0);
                arriving.is_some_and(|arriving| {
                    world.is_object_in_the_way(&shadow_ray(position, normal, &arriving, offset))
                })
            };
            if *direct != Vec3::ZERO && lights.iter().any(is_hidden) {
                *direct = direct_irradiance(&world, lights, position, normal);
            }
        });
    }

    /// Evaluates what does not depend on feedback, but for the sky. Needed when a light or a material changed.
    pub fn shade(&mut self, baked: &BakedScene, lighting: &Lighting, colors: &[SurfaceColors]) {
        self.shade_samples(baked, lighting, colors);
        let unbounced = &self.unbounced;
        self.unbounced_means
            .par_chunks_mut(SURFELS_PER_TASK)
            .zip(baked.surfels.par_chunks(SURFELS_PER_TASK))
            .for_each(|(means, surfels)| {
                for (mean, surfel) in means.iter_mut().zip(surfels) {
                    let samples = &unbounced[samples_of(surfel)];
                    *mean = samples.iter().sum::<Vec3>() / samples.len() as f32;
                }
            });
        for (value, emitter) in self.values[baked.first_emitter_signal()..].iter_mut().zip(&baked.emitters) {
            *value = emitter_radiance(emitter, lighting, colors);
        }
    }

    fn shade_samples(&mut self, baked: &BakedScene, lighting: &Lighting, colors: &[SurfaceColors]) {
        let (has_emitter, decode) = (&self.has_emitter, &self.linear_from_srgb);
        let texel = |[r, g, b, _]: [u8; 4]| Vec3::from([r, g, b].map(|code| decode[usize::from(code)]));
        self.unbounced
            .par_chunks_mut(SAMPLES_PER_TASK)
            .zip(self.feedback.par_chunks_mut(SAMPLES_PER_TASK))
            .zip(
                self.direct
                    .par_chunks(SAMPLES_PER_TASK)
                    .zip(baked.light_samples.par_chunks(SAMPLES_PER_TASK)),
            )
            .for_each(|((unbounced, feedback), (direct, samples))| {
                for (i, sample) in samples.iter().enumerate() {
                    let material = baked.scene.triangle_material[sample.triangle as usize] as usize;
                    let reflectance =
                        colors[material].base_color * texel(sample.base_color_and_side) * FRAC_1_PI;
                    let shines = !sample.is_back_face() && !has_emitter[material];
                    let scale = if shines { lighting.emissive_scale } else { 0.0 };
                    let emitted = colors[material].emission * texel(sample.emission_texel) * scale;
                    unbounced[i] = emitted + reflectance * direct[i];
                    feedback[i].reflectance = reflectance;
                }
            });
    }

    /// Evaluates the sky's signals. Needed when the sky changed.
    pub fn project_sky(&mut self, baked: &BakedScene, sky: &Sky) {
        self.sky.project(sky, &mut self.values[baked.first_sky_signal()..]);
    }

    /// Evaluates the radiance of all surfels and groups with last frame's lightmap as feedback.
    pub fn light_surfels(&mut self, baked: &BakedScene, lightmap: &IrradianceLightmap) {
        let (feedback, means) = (&self.feedback, &self.unbounced_means);
        self.values[..baked.surfels.len()]
            .par_chunks_mut(SURFELS_PER_TASK)
            .zip(means.par_chunks(SURFELS_PER_TASK).zip(baked.surfels.par_chunks(SURFELS_PER_TASK)))
            .for_each(|(values, (means, surfels))| {
                for ((value, mean), surfel) in values.iter_mut().zip(means).zip(surfels) {
                    *value = *mean + mean_reflected(&feedback[samples_of(surfel)], lightmap);
                }
            });
        // A few ten thousand multiplications, each of which may need the one before it.
        for (number, group) in (baked.surfels.len()..).zip(&baked.surfel_groups) {
            self.values[number] = mix(group, &self.values);
        }
    }

    /// [`light_surfels`](Self::light_surfels) of the blocks of surfels that are dirty, and of the groups if there are
    /// any. Notes the largest change of each block of signals.
    pub(crate) fn light_dirty_surfels(
        &mut self,
        baked: &BakedScene,
        lightmap: &IrradianceLightmap,
        is_dirty: &[bool],
        changes: &mut [f32],
    ) {
        if !is_dirty.contains(&true) {
            return;
        }
        let (feedback, means) = (&self.feedback, &self.unbounced_means);
        let blocks =
            self.values[..baked.surfels.len()].par_chunks_mut(BLOCK).zip(baked.surfels.par_chunks(BLOCK));
        let blocks = blocks.zip(means.par_chunks(BLOCK)).zip(is_dirty).zip(&mut *changes);
        blocks.for_each(|((((values, surfels), means), is_dirty), change)| {
            let surfels = values.iter_mut().zip(surfels).zip(means);
            for ((value, surfel), mean) in surfels.take(if *is_dirty { BLOCK } else { 0 }) {
                let radiance = *mean + mean_reflected(&feedback[samples_of(surfel)], lightmap);
                *change = change.max((radiance - *value).abs().max_element());
                *value = radiance;
            }
        });
        for (number, group) in (baked.surfels.len()..).zip(&baked.surfel_groups) {
            let radiance = mix(group, &self.values);
            let change = &mut changes[number / BLOCK];
            *change = change.max((radiance - self.values[number]).abs().max_element());
            self.values[number] = radiance;
        }
    }
}

/// Radiance that samples reflect of the lightmap's light on average.
#[inline(always)]
fn mean_reflected(samples: &[Feedback], lightmap: &IrradianceLightmap) -> Vec3 {
    let reflected = samples.iter().map(|sample| sample.reflected(lightmap)).sum::<Vec3>();
    reflected * (samples.len() as f32).recip()
}

/// Radiance of a group, given that of its patches.
#[inline(always)]
fn mix(group: &SurfelGroup, radiance: &[Vec3]) -> Vec3 {
    let [first, second] = group.children.map(|child| radiance[child as usize]);
    group.first_weight * first + (1.0 - group.first_weight) * second
}

impl Feedback {
    /// Radiance that the sample reflects of the lightmap's light.
    #[inline(always)]
    fn reflected(&self, lightmap: &IrradianceLightmap) -> Vec3 {
        let irradiance = lightmap.texels.get(self.texel as usize).copied().unwrap_or(Vec3::ZERO);
        self.reflectance * irradiance.max(Vec3::ZERO)
    }
}

/// Which light samples have their turn in a frame: every n-th, so that each surfel has some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleTurn {
    /// Number of the turn, below `turns`.
    pub turn: usize,
    /// Turns until all samples have had theirs, at least one.
    pub turns: usize,
}

impl SampleTurn {
    /// All samples.
    pub const ALL: Self = Self { turn: 0, turns: 1 };

    /// Numbers of the samples.
    fn samples(self, count: usize) -> impl Iterator<Item = usize> {
        (self.turn..count).step_by(self.turns)
    }
}

/// Changes a value of each light sample whose turn it is by its position and the normal on its side.
fn for_each_sample(
    values: &mut [Vec3],
    baked: &BakedScene,
    tracer: &Tracer,
    turn: SampleTurn,
    change: impl Fn(&mut Vec3, Vec3, Vec3) + Sync,
) {
    // Tasks begin with a turn of their own.
    let per_task = SAMPLES_PER_TASK.next_multiple_of(turn.turns);
    values.par_chunks_mut(per_task).zip(baked.light_samples.par_chunks(per_task)).for_each(
        |(values, samples)| {
            for index in turn.samples(samples.len()) {
                let sample = &samples[index];
                let normal = tracer.side_normal(sample.triangle, sample.is_back_face());
                change(&mut values[index], sample.position, normal);
            }
        },
    );
}

fn samples_of(surfel: &Surfel) -> Range<usize> {
    surfel.first_sample as usize..surfel.first_sample as usize + surfel.sample_count as usize
}
