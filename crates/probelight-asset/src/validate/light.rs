//! Where light is evaluated and measured: samples, surfels, emitters, probes.

use crate::{BakedParts, MAX_RELIGHT_RAYS, NONE};

/// How far the length of a unit vector may be from 1.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Probes may have this many coefficients together, whatever else the file holds: 4 Mi, 50 MB of radiance.
const FREE_COEFFICIENTS: u64 = 1 << 22;

/// Beyond, each relight ray allows for this many, so that a small file cannot demand huge buffers. The bake's default
/// has one ray for an eighth of a coefficient.
const MAX_COEFFICIENTS_PER_RAY: u64 = 8;

impl BakedParts {
    pub(super) fn check_light_samples(&self) -> Result<(), String> {
        let triangles = self.scene.triangles.len();
        for (s, sample) in self.light_samples.iter().enumerate() {
            ensure!(
                (sample.triangle() as usize) < triangles,
                "light sample {s} lies on triangle {} of {triangles}",
                sample.triangle()
            );
            let weights = sample.barycentric();
            ensure!(
                weights.element_sum() <= 1.0 + f32::EPSILON,
                "light sample {s} lies outside of its triangle"
            );
        }
        Ok(())
    }

    /// Surfels divide the samples among them, one after the other; groups are made of what comes before them.
    pub(super) fn check_surfels(&self) -> Result<(), String> {
        let mut end = 0;
        for (s, surfel) in self.surfels.iter().enumerate() {
            ensure!(
                u64::from(surfel.first_sample) == end,
                "surfel {s} does not start where the last one ends"
            );
            ensure!(surfel.sample_count > 0, "surfel {s} has no samples");
            ensure!(
                surfel.area >= 0.0 && surfel.area.is_finite(),
                "surfel {s} has an area that is not usable"
            );
            end += u64::from(surfel.sample_count);
        }
        let samples = self.light_samples.len();
        ensure!(end == samples as u64, "the surfels need {end} light samples, and there are {samples}");
        for (g, group) in self.surfel_groups.iter().enumerate() {
            let number = self.surfels.len() + g;
            let children = group.children;
            ensure!(
                children.iter().all(|child| (*child as usize) < number),
                "surfel group {g} (number {number}) is made of {children:?}, which do not come before it"
            );
            ensure!(
                (0.0..=1.0).contains(&group.first_weight),
                "surfel group {g} has a weight that is not within 0 to 1"
            );
        }
        Ok(())
    }

    /// Emitters are parts of real materials; the numbers of all scalar signals fit `u32`.
    pub(super) fn check_emitters(&self) -> Result<(), String> {
        let materials = self.scene.materials.len();
        for (e, emitter) in self.emitters.iter().enumerate() {
            ensure!(
                (emitter.material as usize) < materials,
                "emitter {e} has material {} of {materials}",
                emitter.material
            );
            let texel = emitter.mean_texel;
            ensure!(
                texel.is_finite() && texel.min_element() >= 0.0,
                "emitter {e} has a mean texel that is not a colour"
            );
        }
        let signals = self.scalar_signals();
        ensure!(signals < NONE as usize, "{signals} scalar signals are too many");
        Ok(())
    }

    pub(super) fn check_probes(&self) -> Result<(), String> {
        for (p, probe) in self.probes.iter().enumerate() {
            ensure!(
                probe.position.is_finite() && probe.support_radius >= 0.0 && probe.support_radius.is_finite(),
                "probe {p} has a position or radius that is not usable"
            );
        }
        for (d, direction) in self.relight_directions.iter().enumerate() {
            ensure!(
                (direction.length() - 1.0).abs() <= UNIT_TOLERANCE,
                "relight direction {d} is not a unit vector"
            );
        }
        Ok(())
    }

    pub(super) fn check_relight_rays(&self) -> Result<(), String> {
        let (probes, rays, surfels) = (self.probes.len(), self.relight_directions.len(), self.surfels.len());
        ensure!(rays <= MAX_RELIGHT_RAYS as usize, "{rays} relight rays, at most {MAX_RELIGHT_RAYS}");
        ensure!(
            probes.checked_mul(rays) == Some(self.relight_surfels.len()),
            "{} relight rays for {probes} probes with {rays} directions",
            self.relight_surfels.len()
        );
        ensure!(
            self.relight_gains.len() == self.relight_surfels.len(),
            "{} gains of {} relight rays",
            self.relight_gains.len(),
            self.relight_surfels.len()
        );
        let coefficients = probes as u64 * self.coefficients() as u64;
        let allowed = self.relight_surfels.len() as u64 * MAX_COEFFICIENTS_PER_RAY;
        ensure!(
            coefficients <= allowed.max(FREE_COEFFICIENTS),
            "{rays} relight rays are too few for {probes} probes of degree {}",
            self.settings.sh_degree
        );
        for (r, surfel) in self.relight_surfels.iter().enumerate() {
            ensure!(
                *surfel == NONE || (*surfel as usize) < surfels,
                "relight ray {r} meets surfel {surfel} of {surfels}"
            );
        }
        Ok(())
    }
}
