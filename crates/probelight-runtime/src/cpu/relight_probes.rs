//! Stage 2: the probes' radiance as spherical-harmonics coefficients (\[SED\] eq. 2).
//!
//! All probes share their directions, so the projection of all of them is one matrix product,
//! λ = L·(w·Y), of radiance with a table of weighted basis values:
//!
//! ```text
//!            rays                 coefficients              coefficients
//!          ┌──────┐              ┌──┬──┬──┬──┐             ┌─────────────┐
//!  probes  │  L   │ ×      rays  │  │  │  │  │  =   probes │      λ      │    for each colour channel
//!          └──────┘              └──┴──┴──┴──┘             └─────────────┘
//! ```
//!
//! A ray brings the radiance of the surfel that it meets, times the ray's gain, or the sky's. The table is stored in
//! panels of `LANES` coefficients. A panel of 512 rays (32 KiB) stays in the first-level cache while a task multiplies
//! its probes' radiance with it, sums in registers.

use probelight_asset::{BakedScene, GAIN_STEPS};
use probelight_math::directions::weighted_basis;
use probelight_math::glam::Vec3;
use probelight_scene::Sky;
use rayon::prelude::*;

use super::per_thread::PerThread;
use super::{LANES, Lanes};

/// Probes multiplied together: their 24 sums of one panel, one value of the panel and one of radiance fill the
/// 32 registers of AVX-512.
const PROBES: usize = 8;

/// Spherical-harmonics coefficients of the radiance around each probe, W·m⁻²·sr⁻¹.
#[derive(Debug)]
pub struct ProbeRadiance {
    rays: usize,
    coefficients: usize,
    /// Coefficients between the starts of two channels.
    stride: usize,
    /// Weighted basis values: panel by panel, ray by ray.
    table: Vec<Lanes>,
    /// Probe by probe, channel by channel, with `LANES` values of padding at the end.
    values: Vec<f32>,
    /// Radiance of the sky along each relight direction; black where the sky has signals of its own.
    sky: Vec<Vec3>,
    /// Radiance of the rays of [`PROBES`] probes.
    radiance: PerThread<Vec<Vec3>>,
}

impl ProbeRadiance {
    /// Tabulates the basis for the relight directions and makes all probes dark.
    ///
    /// The quadrature is exact for radiance within the probes' own bands, where the number of rays allows.
    pub fn new(baked: &BakedScene) -> Self {
        let (rays, coefficients) = (baked.relight_directions.len(), baked.coefficients());
        let panels = coefficients.div_ceil(LANES);
        let mut table = vec![[0.0; LANES]; panels * rays];
        let weighted_basis = weighted_basis(&baked.relight_directions, baked.settings.sh_degree as usize);
        for (ray, values) in weighted_basis.chunks_exact(coefficients).enumerate() {
            for (j, value) in values.iter().enumerate() {
                table[j / LANES * rays + ray][j % LANES] = *value;
            }
        }
        let stride = panels * LANES;
        let values = vec![0.0; baked.probes.len() * 3 * stride + LANES];
        let table = table.into_iter().map(Lanes::new).collect();
        Self {
            rays,
            coefficients,
            stride,
            table,
            values,
            sky: vec![Vec3::ZERO; rays],
            radiance: PerThread::new(|| vec![Vec3::ZERO; PROBES * rays]),
        }
    }

    /// Coefficients of one probe and colour channel (0 red, 1 green, 2 blue).
    pub fn coefficients(&self, probe: usize, channel: usize) -> &[f32] {
        &self.coefficients_from(probe, channel, 0)[..self.coefficients]
    }

    /// Everything from one coefficient on; at least `LANES` values.
    #[inline(always)]
    pub(super) fn coefficients_from(&self, probe: usize, channel: usize, coefficient: usize) -> &[f32] {
        &self.values[(probe * 3 + channel) * self.stride + coefficient..]
    }

    /// Evaluates the sky along the relight directions. Needed when the sky changed.
    pub fn see_sky(&mut self, baked: &BakedScene, sky: &Sky) {
        if baked.settings.sky_degree.is_none() {
            for (radiance, direction) in self.sky.iter_mut().zip(&baked.relight_directions) {
                *radiance = sky.radiance(*direction);
            }
        }
    }

    /// Projects the radiance that the relight rays bring, given that of the surfels, to coefficients.
    pub fn relight_probes(&mut self, baked: &BakedScene, surfels: &[Vec3]) {
        let Self { rays, stride, table, sky, radiance, .. } = self;
        let (rays, stride) = (*rays, *stride);
        if rays == 0 {
            return;
        }
        let length = baked.probes.len() * 3 * stride;
        self.values[..length]
            .par_chunks_mut(PROBES * 3 * stride)
            .zip(baked.relight_surfels.par_chunks(PROBES * rays))
            .zip(baked.relight_gains.par_chunks(PROBES * rays))
            .for_each(|((values, seen), gains)| {
                let mut scratch = radiance.lock();
                let radiance = &mut scratch[..seen.len()];
                look(seen, gains, surfels, sky, radiance);
                if seen.len() == PROBES * rays {
                    project::<PROBES>(table, rays, radiance, values);
                    return;
                }
                for (values, radiance) in values.chunks_exact_mut(3 * stride).zip(radiance.chunks_exact(rays))
                {
                    project::<1>(table, rays, radiance, values);
                }
            });
    }
}

/// Radiance of some probes' rays, from the surfels they meet or else the sky, times their gains.
fn look(seen: &[u32], gains: &[u8], surfels: &[Vec3], sky: &[Vec3], radiance: &mut [Vec3]) {
    let of_probes = seen.chunks_exact(sky.len()).zip(gains.chunks_exact(sky.len()));
    for ((seen, gains), radiance) in of_probes.zip(radiance.chunks_exact_mut(sky.len())) {
        for (((surfel, gain), sky), radiance) in seen.iter().zip(gains).zip(sky).zip(radiance) {
            // The number that stands for no surfel is not in the slice.
            *radiance = *surfels.get(*surfel as usize).unwrap_or(sky)
                * (f32::from(*gain) * (1.0 / f32::from(GAIN_STEPS)));
        }
    }
}

/// Coefficients of `P` probes.
#[inline(always)]
fn project<const P: usize>(table: &[Lanes], rays: usize, radiance: &[Vec3], values: &mut [f32]) {
    let stride = table.len() / rays * LANES;
    let probes: [&[Vec3]; P] = std::array::from_fn(|probe| &radiance[probe * rays..][..rays]);
    for (panel_index, panel) in table.chunks_exact(rays).enumerate() {
        let sums = multiply_panel(panel, probes);
        for (probe, sums) in sums.iter().enumerate() {
            for (channel, sums) in sums.iter().enumerate() {
                let at = (probe * 3 + channel) * stride + panel_index * LANES;
                values[at..at + LANES].copy_from_slice(&sums.to_array());
            }
        }
    }
}

/// Product of `P` probes' radiance with one panel, for each channel.
#[inline(always)]
fn multiply_panel<const P: usize>(panel: &[Lanes], probes: [&[Vec3]; P]) -> [[Lanes; 3]; P] {
    let mut sums = [[Lanes::ZERO; 3]; P];
    for (ray, basis) in panel.iter().enumerate() {
        for probe in 0..P {
            let radiance = probes[probe][ray];
            sums[probe][0] = basis.mul_add(Lanes::splat(radiance.x), sums[probe][0]);
            sums[probe][1] = basis.mul_add(Lanes::splat(radiance.y), sums[probe][1]);
            sums[probe][2] = basis.mul_add(Lanes::splat(radiance.z), sums[probe][2]);
        }
    }
    sums
}
