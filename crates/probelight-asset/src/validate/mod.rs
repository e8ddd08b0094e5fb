//! What the runtime may rely on without looking: every index in range, every number finite, every matrix as
//! large as its cluster says.

use probelight_scene::{AlphaMode, Material};

use crate::{BakeReport, BakedParts};

/// Highest spherical-harmonics band of the probes, for the bake and in files: 144 coefficients.
pub const MAX_SH_DEGREE: u32 = 11;

/// Most relight rays of a probe, for the bake and in files.
pub const MAX_RELIGHT_RAYS: u32 = 16_384;

/// Highest band of the sky's own signals: 81 signals that clusters may list.
const MAX_SKY_DEGREE: u32 = 8;

/// `Err` with a formatted reason unless the condition holds (NaN in a comparison does not hold).
macro_rules! ensure {
    ($condition:expr, $($reason:tt)+) => {
        if $condition {} else {
            return Err(format!($($reason)+));
        }
    };
}

mod clusters;
mod grid;
mod light;
mod lightmap;

impl BakedParts {
    /// Checks what [`BakedScene::new`](crate::BakedScene::new) promises; says what is wrong first.
    pub(crate) fn check(&self) -> Result<(), String> {
        self.scene.validate().map_err(|error| error.to_string())?;
        self.check_scene_numbers()
            .and_then(|()| self.check_settings())
            .and_then(|()| self.check_lightmap())
            .and_then(|()| self.check_texels())
            .and_then(|()| self.check_light_samples())
            .and_then(|()| self.check_surfels())
            .and_then(|()| self.check_emitters())
            .and_then(|()| self.check_probes())
            .and_then(|()| self.check_relight_rays())
            .and_then(|()| self.check_grid())
            .and_then(|()| self.check_clusters())
            .and_then(|()| self.check_matrices())
    }

    /// The parts of the scene that [`probelight_scene::Scene::validate`] leaves alone.
    fn check_scene_numbers(&self) -> Result<(), String> {
        for (m, material) in self.scene.materials.iter().enumerate() {
            ensure!(material_is_finite(material), "material {m} has a factor that is not finite");
        }
        for (l, light) in self.scene.lights.iter().enumerate() {
            light.validate().map_err(|unusable| format!("light {l}: {unusable}"))?;
        }
        for (c, camera) in self.scene.cameras.iter().enumerate() {
            camera.validate().map_err(|unusable| format!("camera {c} ('{}'): {unusable}", camera.name))?;
        }
        Ok(())
    }

    fn check_settings(&self) -> Result<(), String> {
        let BakeReport {
            approximated_fraction,
            uncovered_fraction,
            mean_cluster_error,
            max_cluster_error,
            ..
        } = &self.report;
        let measured = [approximated_fraction, uncovered_fraction, mean_cluster_error, max_cluster_error];
        ensure!(measured.iter().all(|v| v.is_finite()), "the report has a number that is not finite");
        let settings = &self.settings;
        let asked = [
            settings.texels_per_meter,
            settings.probe_spacing,
            settings.surfel_size,
            settings.near_radius.unwrap_or(0.0),
            settings.byte_price,
            settings.max_cluster_error,
            settings.grid_spacing.unwrap_or(0.0),
        ];
        ensure!(asked.iter().all(|v| v.is_finite()), "the settings have a number that is not finite");
        ensure!(
            settings.sh_degree <= MAX_SH_DEGREE,
            "spherical harmonics of degree {}, and {MAX_SH_DEGREE} is the highest",
            settings.sh_degree
        );
        let sky_degree = settings.sky_degree.unwrap_or(0);
        ensure!(
            sky_degree <= MAX_SKY_DEGREE,
            "sky signals of degree {sky_degree}, and {MAX_SKY_DEGREE} is the highest"
        );
        Ok(())
    }
}

fn material_is_finite(material: &Material) -> bool {
    let cutoff = match material.alpha_mode {
        AlphaMode::Opaque => 0.0,
        AlphaMode::Mask { cutoff } => cutoff,
    };
    let scalars = [material.metallic, material.roughness, material.normal_scale, cutoff];
    material.base_color.is_finite()
        && material.emission.is_finite()
        && scalars.iter().all(|value| value.is_finite())
}
