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

use probelight_asset::BakedScene;
use probelight_asset::packed::GAIN_STEPS;
use probelight_math::glam::Vec3;
use probelight_scene::Sky;
use rayon::prelude::*;

use super::per_thread::PerThread;
use super::{LANES, Lanes};
use crate::frame::{PROBES_A_TURN, RelightTable};
use crate::{FramePlan, ProbeExtent, Ways};

/// Probes multiplied together: their 24 sums of one panel, one value of the panel and one of radiance fill the
/// 32 registers of AVX-512.
const PROBES: usize = PROBES_A_TURN as usize;

/// Spherical-harmonics coefficients of the radiance around each probe, W·m⁻²·sr⁻¹.
#[derive(Debug)]
pub struct ProbeRadiance {
    /// Coefficients between the starts of two channels.
    stride: usize,
    table: Panels,
    /// Probe by probe, channel by channel, with `LANES` values of padding at the end.
    values: Vec<f32>,
    /// Radiance of the sky along each relight direction; black where the sky has signals of its own.
    sky: Vec<Vec3>,
    /// Radiance of the rays of [`PROBES`] probes.
    radiance: PerThread<Vec<Vec3>>,
    /// Largest change of each probe's bands in the last frame that noted them.
    band_changes: Vec<f32>,
}

/// The [`RelightTable`] in panels.
#[derive(Debug)]
struct Panels {
    table: RelightTable,
    /// Weighted basis values: panel by panel, ray by ray.
    lanes: Vec<Lanes>,
    /// The band of each coefficient.
    bands: Vec<usize>,
}

impl ProbeRadiance {
    /// Tabulates the basis for the relight directions and makes all probes dark.
    pub fn new(baked: &BakedScene) -> Self {
        let table = Panels::new(RelightTable::new(baked));
        let (rays, coefficients) = (table.table.rays(), table.table.coefficients);
        let stride = coefficients.next_multiple_of(LANES);
        Self {
            stride,
            table,
            values: vec![0.0; baked.probes.len() * 3 * stride + LANES],
            sky: vec![Vec3::ZERO; rays],
            radiance: PerThread::new(|| vec![Vec3::ZERO; PROBES * rays]),
            band_changes: vec![0.0; baked.probes.len() * (baked.settings.sh_degree as usize + 1)],
        }
    }

    /// Coefficients of one probe and colour channel (0 red, 1 green, 2 blue).
    pub fn coefficients(&self, probe: usize, channel: usize) -> &[f32] {
        &self.coefficients_from(probe, channel, 0)[..self.table.table.coefficients]
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

    /// Largest change of each probe's bands in the last frame that noted them, W·m⁻²·sr⁻¹.
    pub(crate) fn band_changes(&self) -> &[f32] {
        &self.band_changes
    }

    /// Projects the radiance that the plan's relight rays bring, given that of the surfels, to as many coefficients. Notes,
    /// if asked to, how the bands change.
    pub fn relight_probes(
        &mut self,
        baked: &BakedScene,
        ways: Ways<'_>,
        plan: &FramePlan,
        surfels: &[Vec3],
        notes_changes: bool,
    ) {
        let Self { stride, table, sky, radiance, band_changes, .. } = self;
        let bands = baked.settings.sh_degree as usize + 1;
        if notes_changes {
            band_changes.fill(0.0);
        }
        let (rays, stride) = (table.table.rays(), *stride);
        if rays == 0 {
            return;
        }
        let length = baked.probes.len() * 3 * stride;
        self.values[..length]
            .par_chunks_mut(PROBES * 3 * stride)
            .zip(ways.relight_surfels.par_chunks(PROBES * rays))
            .zip(ways.relight_gains.par_chunks(PROBES * rays))
            .zip(plan.probes().par_chunks(PROBES))
            .zip(band_changes.par_chunks_mut(PROBES * bands))
            .filter(|((_, extents), _)| extents.iter().any(|extent| extent.rays > 0))
            .for_each(|((((values, seen), gains), extents), changes)| {
                let mut scratch = radiance.lock();
                let mut changes = notes_changes.then_some(changes);
                let view = RayView { seen, gains, surfels, sky };
                let are_alike = extents.len() == PROBES && extents.iter().all(|extent| *extent == extents[0]);
                if are_alike {
                    table.relight::<PROBES>(extents[0], &view, &mut scratch, values, changes);
                    return;
                }
                for (probe, extent) in extents.iter().enumerate() {
                    let values = &mut values[probe * 3 * stride..][..3 * stride];
                    let changes =
                        changes.as_deref_mut().map(|changes| &mut changes[probe * bands..][..bands]);
                    table.relight::<1>(*extent, &view.of_probe(probe), &mut scratch, values, changes);
                }
            });
    }
}

/// What the rays of some probes see.
struct RayView<'a> {
    /// The surfel that each ray meets; a probe's rays in a row.
    seen: &'a [u32],
    gains: &'a [u8],
    surfels: &'a [Vec3],
    sky: &'a [Vec3],
}

impl RayView<'_> {
    /// That of one probe.
    fn of_probe(&self, probe: usize) -> Self {
        let rays = self.sky.len();
        let its = probe * rays..(probe + 1) * rays;
        Self { seen: &self.seen[its.clone()], gains: &self.gains[its], ..*self }
    }

    /// Radiance of each probe's leading rays, from the surfels they meet or else the sky, times gains and weights.
    fn look(&self, weights: &[f32], radiance: &mut [Vec3]) {
        let rays = self.sky.len();
        let of_probes = self.seen.chunks_exact(rays).zip(self.gains.chunks_exact(rays));
        for ((seen, gains), radiance) in of_probes.zip(radiance.chunks_exact_mut(rays)) {
            let rays = seen.iter().zip(gains).zip(self.sky).zip(weights);
            for ((((surfel, gain), sky), weight), radiance) in rays.zip(radiance) {
                let gain = f32::from(*gain) * (1.0 / f32::from(GAIN_STEPS)) * weight;
                // The number that stands for no surfel is not in the slice.
                *radiance = *self.surfels.get(*surfel as usize).unwrap_or(sky) * gain;
            }
        }
    }
}

impl Panels {
    fn new(table: RelightTable) -> Self {
        let panels = table.coefficients.div_ceil(LANES);
        let mut lanes = vec![[0.0; LANES]; panels * table.rays()];
        for (ray, values) in table.basis.chunks_exact(table.coefficients).enumerate() {
            for (j, value) in values.iter().enumerate() {
                lanes[j / LANES * table.rays() + ray][j % LANES] = *value;
            }
        }
        let bands = (0..).flat_map(|band| std::iter::repeat_n(band, 2 * band + 1));
        let bands = bands.take(table.coefficients).collect();
        Self { table, lanes: lanes.into_iter().map(Lanes::new).collect(), bands }
    }

    /// Coefficients of `P` probes with the same extent; `values` are theirs, and `changes` those of their bands.
    #[inline(always)]
    fn relight<const P: usize>(
        &self,
        extent: ProbeExtent,
        view: &RayView,
        scratch: &mut [Vec3],
        values: &mut [f32],
        mut changes: Option<&mut [f32]>,
    ) {
        let (stored, rays) = (self.table.rays(), extent.rays as usize);
        if rays == 0 {
            return;
        }
        let radiance = &mut scratch[..P * stored];
        view.look(self.table.weights_of(extent.rays), radiance);
        let probes: [&[Vec3]; P] = std::array::from_fn(|probe| &radiance[probe * stored..][..rays]);
        let (coefficients, stride) = (extent.coefficients(), values.len() / (3 * P));
        let panels = self.lanes.chunks_exact(stored).zip((0..coefficients).step_by(LANES));
        for (panel, first) in panels {
            let count = LANES.min(coefficients - first);
            for (probe, sums) in multiply_panel(&panel[..rays], probes).iter().enumerate() {
                for (channel, sums) in sums.iter().enumerate() {
                    let at = (probe * 3 + channel) * stride + first;
                    let (values, sums) = (&mut values[at..at + count], &sums.to_array()[..count]);
                    if let Some(changes) = &mut changes {
                        let of_probe = changes.len() / P;
                        let changes = &mut changes[probe * of_probe..][..of_probe];
                        note_changes(values, sums, &self.bands[first..], changes);
                    }
                    values.copy_from_slice(sums);
                }
            }
        }
    }
}

/// Raises the changes of bands to those of their coefficients.
fn note_changes(before: &[f32], after: &[f32], bands: &[usize], changes: &mut [f32]) {
    for ((before, after), band) in before.iter().zip(after).zip(bands) {
        changes[*band] = changes[*band].max((after - before).abs());
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
