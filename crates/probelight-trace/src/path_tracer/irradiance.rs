//! Irradiance at given points, with its uncertainty.

use std::f32::consts::PI;

use probelight_math::glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::PathTracer;
use super::integrator::{DirectionChoice, Surface};
use super::sampler::{Sampler, sequence_seed};
use crate::{Cancelled, Progress};

/// Standard errors come from the scatter of this many independent batches.
const BATCHES: u32 = 16;

/// Irradiance of a surface point by origin, W/m², and one-sigma standard errors of the means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointIrradiance {
    /// Straight from analytic lights; exact.
    pub delta: Vec3,
    /// Straight from emissive surfaces.
    pub area: Vec3,
    /// Straight from the sky.
    pub sky: Vec3,
    /// From all light that was reflected at least once.
    pub indirect: Vec3,
    /// Standard error of `area`.
    pub se_area: Vec3,
    /// Standard error of `sky`.
    pub se_sky: Vec3,
    /// Standard error of `indirect`.
    pub se_indirect: Vec3,
}

impl PathTracer {
    /// Irradiance at a surface point on the side of its unit `normal`. `samples` paths are traced, rounded up
    /// to a multiple of 16; the same seed gives the same result.
    pub fn irradiance(&self, position: Vec3, normal: Vec3, samples: u32, seed: u64) -> PointIrradiance {
        let surface = Surface { position, normal };
        let per_batch = samples.div_ceil(BATCHES).max(1);
        let batches: [Batch; BATCHES as usize] = std::array::from_fn(|batch| {
            self.irradiance_batch(surface, per_batch, sequence_seed(seed, batch as u64))
        });
        let (area, se_area) = mean_and_error(batches.map(|batch| batch.area));
        let (sky, se_sky) = mean_and_error(batches.map(|batch| batch.sky));
        let (indirect, se_indirect) = mean_and_error(batches.map(|batch| batch.indirect));
        let delta = self.delta_irradiance(surface);
        PointIrradiance { delta, area, sky, indirect, se_area, se_sky, se_indirect }
    }

    /// [`Self::irradiance`] of many `(position, normal)` in parallel. Each point has its own random numbers,
    /// made from `seed` and its index, so the result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`Cancelled`] if `progress` asks to stop.
    pub fn irradiance_of_points(
        &self,
        points: &[(Vec3, Vec3)],
        samples: u32,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<PointIrradiance>, Cancelled> {
        progress.begin("tracing paths", points.len() as u64);
        points
            .par_iter()
            .enumerate()
            .map(|(index, (position, normal))| {
                if progress.is_cancelled() {
                    return Err(Cancelled);
                }
                let seed = u64::from(sequence_seed(seed, index as u64));
                let irradiance = self.irradiance(*position, *normal, samples, seed);
                progress.advance(1);
                Ok(irradiance)
            })
            .collect()
    }

    fn irradiance_batch(&self, surface: Surface, samples: u32, seed: u32) -> Batch {
        // f64: a long sum of f32 would lose the last digits of its terms.
        let (mut area, mut sky, mut indirect) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for index in 0..samples {
            let mut sampler = Sampler::new(index, seed);
            let sampled = self.sampled_emitter_irradiance(surface, &mut sampler);
            // Radiance over the density cosθ/π, times the cosine: π times the radiance.
            let (ray, density) = self.cosine_ray(surface, &mut sampler);
            let arriving = self.arriving_radiance(&ray, DirectionChoice::Sampled(density), &mut sampler);
            area += (sampled + PI * arriving.emitted).as_dvec3();
            sky += (PI * arriving.sky).as_dvec3();
            indirect += (PI * arriving.reflected).as_dvec3();
        }
        let mean = |sum: DVec3| (sum / f64::from(samples)).as_vec3();
        Batch { area: mean(area), sky: mean(sky), indirect: mean(indirect) }
    }
}

/// Mean irradiance of one batch of paths.
#[derive(Clone, Copy, Default)]
struct Batch {
    area: Vec3,
    sky: Vec3,
    indirect: Vec3,
}

fn mean_and_error(batches: [Vec3; BATCHES as usize]) -> (Vec3, Vec3) {
    let count = BATCHES as f32;
    let mean = batches.iter().sum::<Vec3>() / count;
    let squares: Vec3 = batches.iter().map(|batch| (batch - mean) * (batch - mean)).sum();
    let error = squares / (count * (count - 1.0));
    (mean, Vec3::from_array(error.to_array().map(f32::sqrt)))
}
