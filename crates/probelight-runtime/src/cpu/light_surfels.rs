//! Stage 1: the scalar signals: radiance of surfels, surfel groups and emitters, coefficients of the sky.
//!
//! A surfel's radiance is `Le + ρ/π · (E_direct + E_lightmap)`: emission of front faces, direct light by the mean
//! reflectance of its samples, and what each sample reflects of last frame's lightmap, which holds everything that arrives
//! by way of the signals. Where emitters have signals of their own, surfels leave Le out.
//!
//! What changes rarely is kept: rays of lights are only traced when one moved, the terms without feedback are only
//! evaluated then or when a material changed. Every frame then is one multiplication per sample.
//! Feedback is clamped at zero, because truncated matrices can yield slightly negative irradiance and no
//! surface reflects that.

use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

use probelight_asset::{BakedScene, LightSample, Surfel, SurfelGroup};
use probelight_math::color::linear_from_srgb;
use probelight_math::glam::Vec3;
use probelight_scene::{Light, Lighting, Sky};
use probelight_trace::World;
use rayon::prelude::*;

use super::direct_light::DirectLight;
use crate::IrradianceLightmap;
use crate::frame::BLOCK;
use crate::shadow_turns::ShadowWork;
use crate::sky_signals::SkyProjection;
use crate::surface_colors::{SurfaceColors, emitter_radiance, has_emitter};

/// Samples a task works through.
const SAMPLES_PER_TASK: usize = 2048;

/// Surfels a task works through.
const SURFELS_PER_TASK: usize = 512;

/// All scalar signals, and the parts of them that outlast a frame.
#[derive(Clone, Debug)]
pub struct ScalarSignals {
    direct: DirectLight,
    /// Mean radiance that each surfel emits, W·m⁻²·sr⁻¹.
    emitted: Vec<Vec3>,
    /// Mean ρ/π of each surfel.
    reflectance: Vec<Vec3>,
    /// What each sample reflects of last frame's light.
    feedback: Vec<Feedback>,
    /// Radiance of each surfel without feedback: emission and reflected direct light.
    unbounced: Vec<Vec3>,
    /// Which blocks of surfels differ in it since it was evaluated before.
    is_shaded: Vec<bool>,
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
        let dark = vec![Vec3::ZERO; baked.surfels.len()];
        let feedback =
            |sample: &LightSample| Feedback { texel: baked.texel_of(sample), ..Feedback::default() };
        Self {
            direct: DirectLight::new(baked),
            emitted: dark.clone(),
            reflectance: dark.clone(),
            unbounced: dark,
            is_shaded: vec![false; baked.surfels.len().div_ceil(BLOCK)],
            feedback: baked.light_samples.iter().map(feedback).collect(),
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

    /// Irradiance of the surfels straight from the analytic lights, W/m².
    pub fn direct_irradiance(&self) -> &[Vec3] {
        self.direct.irradiance()
    }

    /// Finds the surfels' direct light, of the rays whose turn it is. Needed when a light changed or an object moved.
    pub fn light_directly(
        &mut self,
        baked: &BakedScene,
        world: World<'_>,
        lights: &[Light],
        work: ShadowWork,
    ) {
        self.direct.light(baked, world, lights, work);
    }

    /// Evaluates what surfels emit and how they reflect. Needed when a material or the emissive scale changed, before
    /// [`shade`](Self::shade).
    pub fn color(&mut self, baked: &BakedScene, lighting: &Lighting, colors: &[SurfaceColors]) {
        let (has_emitter, decode) = (&self.has_emitter, &self.linear_from_srgb);
        let samples = self.feedback.par_iter_mut().zip(&baked.light_samples);
        samples.with_min_len(SAMPLES_PER_TASK).for_each(|(feedback, sample)| {
            let material = baked.scene.triangle_material[sample.triangle() as usize] as usize;
            let texel = Vec3::from(sample.base_color().map(|code| decode[usize::from(code)]));
            feedback.reflectance = colors[material].base_color * texel * FRAC_1_PI;
        });
        let feedback = &self.feedback;
        let surfels = self.emitted.par_iter_mut().zip(&mut self.reflectance).zip(&baked.surfels);
        surfels.with_min_len(SURFELS_PER_TASK).for_each(|((emitted, reflectance), surfel)| {
            (*emitted, *reflectance) = (Vec3::ZERO, Vec3::ZERO);
            let share = (surfel.sample_count as f32).recip();
            for (sample, feedback) in baked.samples_of(surfel).iter().zip(&feedback[samples_of(surfel)]) {
                let triangle = sample.triangle() as usize;
                let material = baked.scene.triangle_material[triangle] as usize;
                *reflectance += share * feedback.reflectance;
                if !sample.is_back_face() && !has_emitter[material] && colors[material].emission != Vec3::ZERO
                {
                    let texel = baked.scene.emission_texel(triangle, sample.barycentric());
                    *emitted += share * lighting.emissive_scale * colors[material].emission * texel;
                }
            }
        });
        for (value, emitter) in self.values[baked.first_emitter_signal()..].iter_mut().zip(&baked.emitters) {
            *value = emitter_radiance(emitter, lighting, colors);
        }
    }

    /// Evaluates the radiance of surfels without feedback. Needed when a light, an object or a material changed.
    pub fn shade(&mut self) {
        let Self { unbounced, is_shaded, emitted, reflectance, direct, .. } = self;
        let surfels = emitted.par_chunks(BLOCK).zip(reflectance.par_chunks(BLOCK));
        let surfels = surfels.zip(direct.irradiance().par_chunks(BLOCK));
        let blocks = unbounced.par_chunks_mut(BLOCK).zip(is_shaded).zip(surfels);
        let per_task = SURFELS_PER_TASK / BLOCK;
        blocks.with_min_len(per_task).for_each(
            |((unbounced, is_shaded), ((emitted, reflectance), irradiance))| {
                *is_shaded = false;
                let surfels = emitted.iter().zip(reflectance).zip(irradiance);
                for (unbounced, ((emitted, reflectance), irradiance)) in unbounced.iter_mut().zip(surfels) {
                    let radiance = *emitted + *reflectance * *irradiance;
                    *is_shaded |= radiance != *unbounced;
                    *unbounced = radiance;
                }
            },
        );
    }

    /// Which blocks of surfels [`shade`](Self::shade) changed.
    pub(crate) fn is_shaded(&self) -> &[bool] {
        &self.is_shaded
    }

    /// Evaluates the sky's signals. Needed when the sky changed.
    pub fn project_sky(&mut self, baked: &BakedScene, sky: &Sky) {
        self.sky.project(sky, &mut self.values[baked.first_sky_signal()..]);
    }

    /// Evaluates the radiance of all surfels and groups with last frame's lightmap as feedback.
    pub fn light_surfels(&mut self, baked: &BakedScene, lightmap: &IrradianceLightmap) {
        let (feedback, means) = (&self.feedback, &self.unbounced);
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
        let (feedback, means) = (&self.feedback, &self.unbounced);
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

fn samples_of(surfel: &Surfel) -> Range<usize> {
    surfel.first_sample as usize..surfel.first_sample as usize + surfel.sample_count as usize
}
