//! What a user may ask of a bake, and the defaults derived from the scene.

use probelight_asset::{BakeSettings, Method, Metric, Storage};
use probelight_math::glam::Vec3;
use probelight_math::sampling::{Rng, cosine_hemisphere_from_square, sobol_owen, world_from_tangent};
use probelight_scene::Scene;
use probelight_trace::{Ray, Tracer};
use rayon::prelude::*;

use crate::surface_samples::sample_front_faces;
use crate::{BakeError, Quality};

/// What a user may ask of a bake. `None` means the documented default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeOptions {
    /// What the receivers, gather rays, rank and cluster error default to. Default [`Quality::Medium`], whose
    /// values are given below.
    pub quality: Option<Quality>,
    /// What the clusters' signals are. Default [`Method::Hybrid`].
    pub method: Option<Method>,
    /// What the matrices are compressed for. Default [`Metric::Radiance`], with the paper's method
    /// [`Metric::Band`].
    pub metric: Option<Metric>,
    /// How the matrices are stored. Default [`Storage::Packed`], with the paper's method [`Storage::F16`].
    pub storage: Option<Storage>,
    /// Wanted number of receivers (lightmap texels with light of their own). Takes precedence over the
    /// default texel density, not over an explicit one.
    pub receivers: Option<u32>,
    /// Lightmap texels per metre. Default: texels of 1/32 of the scene's typical free distance, but no
    /// more receivers than [`DEFAULT_MAX_RECEIVERS`].
    pub texels_per_meter: Option<f32>,
    /// Probes per cubic metre of open space. Default: adapted to the local free distance, and nowhere
    /// sparser than \[SED\]'s 0.02.
    pub probe_density: Option<f32>,
    /// Width of the surfels, metres. Default: a share of the scene's typical free distance, but not below
    /// two and a half texels.
    pub surfel_size: Option<f32>,
    /// Most light samples per surfel. Default 16.
    pub samples_per_surfel: Option<u32>,
    /// Distance from a receiver beyond which it takes light from probes, not from surfels. Default: eight
    /// surfel widths.
    pub near_radius: Option<f32>,
    /// Gather rays per receiver. Default 256, with the paper's method 512; with the hybrid method two or four
    /// times as many where there are so few receivers that all rays together stay below 100 million.
    pub gather_rays: Option<u32>,
    /// Relight rays per probe. Default 512 (\[SED\] §5.1); with the hybrid method two or four times as many where
    /// there are so few probes that all rays together stay below [`RELIGHT_RAY_BUDGET`].
    pub relight_rays: Option<u32>,
    /// Highest spherical-harmonics band, 0 to 11. Default 7 (\[SED\] Table 1).
    pub sh_degree: Option<u32>,
    /// Most singular values per cluster, 1 to 256. Default 32 (\[SED\] §3.3); as many as it takes if
    /// `max_cluster_error` is given.
    pub max_rank: Option<u32>,
    /// Relative error of a cluster's stored matrix. If it is given, every cluster keeps it, at any number of
    /// bytes, unless `max_rank` is given too. Default 0.02, as far as the rank and reasonable bytes allow: what is
    /// lost then is mostly the noise of the gather rays.
    pub max_cluster_error: Option<f32>,
    /// Most probes a cluster draws on; up to twice as many where more than a few of its rays end at places that
    /// none of them sees. Default 6, with the paper's method 10.
    pub probes_per_cluster: Option<u32>,
    /// Most receivers in a cluster. Default 512, with the paper's method 256: probes serve a cluster well only if it is small against the
    /// distance between them.
    pub receivers_per_cluster: Option<u32>,
    /// Whether clusters blend at the borders between them. Default true, with the paper's method false.
    pub blend_borders: Option<bool>,
    /// Use the scene's second texture coordinates for the lightmap where they are valid.
    pub use_uv1: bool,
    /// Seed of all random numbers. Default 0.
    pub seed: Option<u64>,
}

/// Receivers that the default texel density does not exceed.
pub const DEFAULT_MAX_RECEIVERS: u32 = 400_000;

/// Default texel edge as a share of the typical free distance.
const TEXEL_PER_FREE_DISTANCE: f32 = 1.0 / 32.0;

/// Default surfel width as a share of the typical free distance, and in texels at least.
const SURFEL_PER_FREE_DISTANCE: f32 = 0.1;
const TEXELS_PER_SURFEL: f32 = 2.5;

/// Default near radius in surfel widths: farther away, probes see as finely as the surfels are.
const SURFELS_PER_NEAR_RADIUS: f32 = 8.0;

/// How often the rays of a receiver or probe are doubled where there are few of them. A receiver's noise halves
/// with each two doublings, while the texels' size remains.
const DOUBLINGS_OF_RAYS: u32 = 2;

/// Relight rays of all probes together that doubling the default does not exceed: less than what the probes of a
/// large scene have anyway, so it costs no frame time that matters.
pub const RELIGHT_RAY_BUDGET: u64 = 1 << 18;

/// Singular values that a cluster may have at most.
const HIGHEST_RANK: u32 = 256;

/// Defaults that depend on the method.
struct MethodDefaults {
    metric: Metric,
    storage: Storage,
    /// Gather rays as a multiple of what the quality asks for.
    gather_rays_factor: u32,
    probes_per_cluster: u32,
    receivers_per_cluster: u32,
}

impl MethodDefaults {
    fn of(method: Method) -> Self {
        match method {
            Method::Paper => Self {
                metric: Metric::Band,
                storage: Storage::F16,
                gather_rays_factor: 2,
                probes_per_cluster: 10,
                receivers_per_cluster: 256,
            },
            // Surfels bring the detail, so fewer probes do; the compression takes noise away.
            Method::Hybrid => Self {
                metric: Metric::Radiance,
                storage: Storage::Packed,
                gather_rays_factor: 1,
                probes_per_cluster: 6,
                receivers_per_cluster: 512,
            },
        }
    }
}

/// Highest band of the sky's own signals: skies are smooth, and what blocks them is in the matrix.
const SKY_DEGREE: u32 = 4;

/// Lowest probe density unless asked otherwise, per m³ (\[SED\] §3).
const SPARSEST_PROBE_DENSITY: f32 = 0.02;

/// Smallest probe spacing as a share of the largest, where it follows the local free distance.
const SMALLEST_SPACING: f32 = 0.25;

/// What the options come to for one scene.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    /// Settings that go into the file. `texels_per_meter` is still the wish.
    pub(crate) settings: BakeSettings,
    /// Wanted number of receivers, if the texel density is to follow from it.
    pub(crate) receiver_target: Option<u32>,
    /// Surfel width, if the user fixed it; otherwise the default before the texel size is known.
    pub(crate) surfel_size_is_fixed: bool,
    /// Whether the receiver target is only an upper limit.
    pub(crate) target_is_limit: bool,
    /// Probe spacing everywhere, if the user fixed the density.
    pub(crate) uniform_spacing: bool,
    /// Whether every cluster is to keep the wanted error, at any number of bytes.
    pub(crate) must_meet_error: bool,
    /// Gather rays of all receivers together that the default may grow to; none if the user fixed the rays.
    pub(crate) gather_ray_budget: Option<u64>,
    /// The same for the relight rays of all probes.
    pub(crate) relight_ray_budget: Option<u64>,
}

impl Resolved {
    /// About how large a texel will be, metres, before the layout is known.
    pub(crate) fn estimated_texel_size(&self, scene: &Scene) -> f32 {
        let wished = 1.0 / self.settings.texels_per_meter;
        let Some(target) = self.receiver_target else { return wished };
        let fitting = (scene.surface_area() / f64::from(target)).sqrt() as f32;
        if self.target_is_limit { wished.max(fitting) } else { fitting }
    }

    /// Takes note of the texel density that the layout came to.
    pub(crate) fn set_texel_density(&mut self, texels_per_meter: f32) {
        self.settings.texels_per_meter = texels_per_meter;
        let settings = &mut self.settings;
        if !self.surfel_size_is_fixed {
            settings.surfel_size = settings.surfel_size.max(TEXELS_PER_SURFEL / texels_per_meter);
        }
        if settings.method == Method::Hybrid {
            settings.near_radius.get_or_insert(SURFELS_PER_NEAR_RADIUS * settings.surfel_size);
        }
    }

    /// Takes note of the number of receivers: where they are few, each can have more rays.
    pub(crate) fn set_receiver_count(&mut self, receivers: usize) {
        double_within(&mut self.settings.gather_rays, receivers, self.gather_ray_budget);
    }

    /// Takes note of the number of probes: where they are few, each can have more rays.
    pub(crate) fn set_probe_count(&mut self, probes: usize) {
        double_within(&mut self.settings.relight_rays, probes, self.relight_ray_budget);
    }

    /// Smallest distance between neighbouring probes, metres.
    pub(crate) fn smallest_spacing(&self) -> f32 {
        self.settings.probe_spacing * if self.uniform_spacing { 1.0 } else { SMALLEST_SPACING }
    }
}

/// Doubles the rays of each, a few times at most, while those of all stay within a budget.
fn double_within(rays: &mut u32, count: usize, budget: Option<u64>) {
    let Some(budget) = budget else { return };
    for _ in 0..DOUBLINGS_OF_RAYS {
        if 2 * u64::from(*rays) * count as u64 <= budget {
            *rays *= 2;
        }
    }
}

impl BakeOptions {
    /// Checks the options and fills in the defaults for one scene.
    pub(crate) fn resolve(&self, tracer: &Tracer) -> Result<Resolved, BakeError> {
        let preset = self.quality.unwrap_or_default().preset();
        let free_distance = typical_free_distance(tracer);
        let positive = |option, value: Option<f32>| match value {
            Some(v) if !(v > 0.0 && v.is_finite()) => {
                Err(BakeError::Option { option, expected: "positive", got: v.to_string() })
            }
            other => Ok(other),
        };
        let within = |option, value: Option<u32>, default, range: std::ops::RangeInclusive<u32>, expected| {
            let value = value.unwrap_or(default);
            if range.contains(&value) {
                Ok(value)
            } else {
                Err(BakeError::Option { option, expected, got: value.to_string() })
            }
        };
        let texel_density = positive("the texel density", self.texels_per_meter)?;
        let probe_density = positive("the probe density", self.probe_density)?;
        let max_error = positive("the largest cluster error", self.max_cluster_error)?;
        let receivers =
            within("the number of receivers", self.receivers, 1, 1..=64_000_000, "1 to 64 million")?;
        let spacing = probe_density.unwrap_or(SPARSEST_PROBE_DENSITY).powf(-1.0 / 3.0);
        let surfel_size = positive("the surfel size", self.surfel_size)?;
        let method = self.method.unwrap_or_default();
        let must_meet_error = max_error.is_some() && self.max_rank.is_none();
        let defaults = MethodDefaults::of(method);
        let settings = BakeSettings {
            method,
            metric: self.metric.unwrap_or(defaults.metric),
            storage: self.storage.unwrap_or(defaults.storage),
            sky_degree: (method == Method::Hybrid).then_some(SKY_DEGREE),
            surfel_size: surfel_size.unwrap_or(free_distance * SURFEL_PER_FREE_DISTANCE),
            samples_per_surfel: within(
                "the samples per surfel",
                self.samples_per_surfel,
                16,
                1..=64,
                "1 to 64",
            )?,
            near_radius: match (method, self.near_radius) {
                (Method::Paper, _) => None,
                (Method::Hybrid, radius) => positive("the near radius", radius)?,
            },
            texels_per_meter: texel_density.unwrap_or(1.0 / (free_distance * TEXEL_PER_FREE_DISTANCE)),
            probe_spacing: spacing,
            sh_degree: within("the SH degree", self.sh_degree, 7, 0..=11, "0 to 11")?,
            gather_rays: within(
                "the gather rays",
                self.gather_rays,
                defaults.gather_rays_factor * preset.gather_rays,
                16..=65_536,
                "16 to 65536",
            )?,
            relight_rays: within("the relight rays", self.relight_rays, 512, 16..=16_384, "16 to 16384")?,
            probes_per_cluster: within(
                "the probes per cluster",
                self.probes_per_cluster,
                defaults.probes_per_cluster,
                1..=40,
                "1 to 40",
            )?,
            receivers_per_cluster: within(
                "the receivers per cluster",
                self.receivers_per_cluster,
                defaults.receivers_per_cluster,
                16..=4096,
                "16 to 4096",
            )?,
            blend_borders: self.blend_borders.unwrap_or(method == Method::Hybrid),
            max_rank: within(
                "the rank",
                self.max_rank,
                if must_meet_error { HIGHEST_RANK } else { preset.max_rank },
                1..=HIGHEST_RANK,
                "1 to 256",
            )?,
            max_cluster_error: max_error.unwrap_or(preset.max_cluster_error),
            seed: self.seed.unwrap_or(0),
        };
        let (receiver_target, target_is_limit) = match (texel_density, self.receivers) {
            (Some(_), _) => (None, false),
            (None, Some(_)) => (Some(receivers), false),
            (None, None) => (Some(preset.max_receivers), true),
        };
        let if_default = |option: Option<u32>, budget: u64| {
            (method == Method::Hybrid && option.is_none()).then_some(budget)
        };
        let gather_ray_budget = u64::from(preset.max_receivers) * u64::from(preset.gather_rays);
        Ok(Resolved {
            gather_ray_budget: if_default(self.gather_rays, gather_ray_budget),
            relight_ray_budget: if_default(self.relight_rays, RELIGHT_RAY_BUDGET),
            settings,
            receiver_target,
            target_is_limit,
            must_meet_error,
            uniform_spacing: probe_density.is_some(),
            surfel_size_is_fixed: surfel_size.is_some(),
        })
    }
}

/// Median distance that light travels from a surface to the next, metres: the scale of the scene's spaces.
fn typical_free_distance(tracer: &Tracer) -> f32 {
    let samples = sample_front_faces(tracer.scene(), 4096, &mut Rng::new(0, 17));
    let mut distances: Vec<f32> = samples
        .par_iter()
        .enumerate()
        .filter_map(|(i, sample)| {
            let local = cosine_hemisphere_from_square(sobol_owen(i as u32, 23));
            let ray = Ray::new(
                sample.position + sample.normal * tracer.offset(),
                world_from_tangent(sample.normal) * local,
            );
            tracer.closest_hit(&ray).filter(|hit| !hit.is_back_face).map(|hit| hit.distance)
        })
        .collect();
    distances.sort_by(f32::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or_else(|| fallback_distance(tracer.scene()))
}

/// Stand-in for scenes where no surface sees another.
fn fallback_distance(scene: &Scene) -> f32 {
    let size: Vec3 = scene.bounds().size();
    size.length() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubled(count: usize, budget: Option<u64>) -> u32 {
        let mut rays = 512;
        double_within(&mut rays, count, budget);
        rays
    }

    #[test]
    fn few_get_more_rays_and_many_do_not() {
        let budget = Some(512 * 1024);
        assert_eq!(
            [1, 256, 257, 512, 513, 1 << 20].map(|n| doubled(n, budget)),
            [2048, 2048, 1024, 1024, 512, 512]
        );
        assert_eq!(doubled(1, None), 512, "what the user asked for stays");
    }
}
