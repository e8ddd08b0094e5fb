//! What a bake is asked for, checked, with the defaults that the scene gives; and the settings that follow.

use std::ops::RangeInclusive;

use probelight_asset::{BakeSettings, GridBasis, MAX_GRID_LEVELS, MAX_SH_DEGREE, Method, Metric, Storage};
use probelight_math::glam::DVec3;
use probelight_scene::Bounds;
use probelight_trace::Tracer;

use super::scale::Scale;
use super::{BakeOptions, Preset, SignalPlan, SurfaceSignals};
use crate::BakeError;

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

/// Singular values that a cluster may have at most.
const HIGHEST_RANK: u32 = 256;

/// Lowest probe density unless asked otherwise, per m³ (\[SED\] §3); per cube of [`Scale::unit`] here.
const SPARSEST_PROBE_DENSITY: f32 = 0.02;

/// Smallest probe spacing as a share of the largest, where it follows the local free distance.
const SMALLEST_SPACING: f32 = 0.25;

/// Edge of the voxels in which places for probes are looked for, as a share of the smallest probe spacing.
const VOXEL_PER_SPACING: f32 = 0.5;

/// Vertices of the grid unless asked otherwise: as many as there are receivers, over `RECEIVERS_PER_VERTEX`, so that the
/// grid takes about a tenth of the file; but not so few that small scenes' lamps fall between them.
const RECEIVERS_PER_VERTEX: usize = 40;
const FEWEST_VERTICES: usize = 6_000;

/// Smallest extent of the space that the grid's default spacing is chosen for, as a share of the largest.
const FLATTEST: f64 = 0.05;

/// How fine the lightmap is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TexelDensity {
    /// Texels per metre.
    Fixed(f32),
    /// As many receivers.
    Receivers(u32),
    /// Texels per metre, fewer if there would be more receivers.
    AtMost { receivers: u32, texels_per_meter: f32 },
}

impl TexelDensity {
    /// The number of receivers that decides, if one does.
    pub(crate) fn receivers(self) -> Option<u32> {
        match self {
            Self::Fixed(_) => None,
            Self::Receivers(receivers) | Self::AtMost { receivers, .. } => Some(receivers),
        }
    }

    /// Texels per metre that are not exceeded.
    pub(crate) fn limit(self) -> f32 {
        match self {
            Self::Fixed(texels_per_meter) | Self::AtMost { texels_per_meter, .. } => texels_per_meter,
            Self::Receivers(_) => f32::INFINITY,
        }
    }

    /// About how large a texel will be, metres, before the layout is known, if the scene has so much surface.
    pub(crate) fn estimated_texel_size(self, area: f64) -> f32 {
        let fitting = |receivers| (area / f64::from(receivers)).sqrt() as f32;
        self.receivers().map_or(0.0, fitting).max(1.0 / self.limit())
    }
}

/// Relative error of a cluster's stored matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ErrorGoal {
    /// As far as the rank and reasonable bytes allow.
    About(f32),
    /// In every cluster, at any number of bytes.
    AtMost(f32),
}

impl ErrorGoal {
    pub(crate) fn error(self) -> f32 {
        match self {
            Self::About(error) | Self::AtMost(error) => error,
        }
    }

    pub(crate) fn must_be_met(self) -> bool {
        matches!(self, Self::AtMost(_))
    }
}

/// How many rays each receiver or probe has.
#[derive(Clone, Copy, Debug)]
struct Rays {
    fewest: u32,
    /// Rays of all together that doubling them does not exceed; none where the number is fixed.
    budget: Option<u64>,
}

impl Rays {
    /// Doubled, a few times at most, while those of all stay within the budget.
    fn of_each(self, count: usize) -> u32 {
        let fits = |rays: &u32| self.budget.is_some_and(|budget| u64::from(*rays) * count as u64 <= budget);
        let doublings = (0..=DOUBLINGS_OF_RAYS).map(|doublings| self.fewest << doublings);
        doublings.skip(1).take_while(fits).last().unwrap_or(self.fewest)
    }
}

/// Width of the surfels, metres.
#[derive(Clone, Copy, Debug)]
enum SurfelSize {
    Fixed(f32),
    /// But a few texels at least.
    About(f32),
}

/// What a bake is asked for, with the scene's defaults. Nothing changes it.
#[derive(Clone, Debug)]
pub(crate) struct Wishes {
    pub(crate) plan: SignalPlan,
    pub(crate) density: TexelDensity,
    /// About how large a texel will be, metres.
    pub(crate) estimated_texel_size: f32,
    /// Edge of the voxels in which open air is looked for, metres.
    pub(crate) voxel_size: f32,
    /// Whether the scene's second texture coordinates are used where they are valid.
    pub(crate) use_uv1: bool,
    /// Largest distance between neighbouring probes, metres.
    pub(crate) widest_spacing: f32,
    /// Smallest distance between neighbouring probes, metres; the same if the user fixed their density.
    pub(crate) smallest_spacing: f32,
    pub(crate) error: ErrorGoal,
    pub(crate) seed: u64,
    grid: GridDensity,
    grid_basis: GridBasis,
    method: Method,
    metric: Metric,
    storage: Storage,
    surfel_size: SurfelSize,
    samples_per_surfel: u32,
    near_radius: Option<f32>,
    gather_rays: Rays,
    relight_rays: Rays,
    sh_degree: Degree,
    max_rank: u32,
    probes_per_cluster: u32,
    receivers_per_cluster: u32,
    blend_borders: bool,
    bytes: Bytes,
}

/// How many vertices the grid in free space has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum GridDensity {
    Nowhere,
    /// So far apart, metres.
    Even(f32),
    /// So many, most of them near surfaces.
    Vertices(u32),
    ByReceivers,
}

/// What decides how many bytes are spent.
#[derive(Clone, Copy, Debug)]
enum Bytes {
    /// What one must save, see [`BakeSettings::byte_price`].
    Price(f32),
    /// So many per receiver.
    Budget(f32),
    /// The same, from so many receivers on. Of fewer each may take more: twice as many of a quarter as many.
    BudgetOf(f32, u32),
    /// As many as the wanted error takes.
    Any,
}

impl Bytes {
    fn budget(self, receivers: usize) -> Option<f32> {
        match self {
            Self::Budget(bytes) => Some(bytes),
            Self::BudgetOf(bytes, many) => {
                Some(bytes * (many as f32 / receivers.max(1) as f32).max(1.0).sqrt())
            }
            Self::Price(_) | Self::Any => None,
        }
    }
}

/// Highest band of the probes' spherical harmonics.
#[derive(Clone, Copy, Debug)]
enum Degree {
    Fixed(u32),
    /// As high as the relight rays resolve, [`USUAL_DEGREE`] at least.
    OfRays,
}

/// \[SED\] Table 1. No lower one is good enough, however few rays there are.
const USUAL_DEGREE: u32 = 7;

/// Rays for each coefficient from which on a band more tells more than its rays' noise: 2,048 rays resolve degree 10.
const RAYS_PER_COEFFICIENT: u32 = 16;

impl Degree {
    fn of(self, rays: u32) -> u32 {
        let resolved = |degree: &u32| RAYS_PER_COEFFICIENT * (degree + 1).pow(2) <= rays;
        match self {
            Self::Fixed(degree) => degree,
            Self::OfRays => {
                (USUAL_DEGREE..=MAX_SH_DEGREE).take_while(resolved).last().unwrap_or(USUAL_DEGREE)
            }
        }
    }
}

/// What the steps of a bake decide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decided {
    pub(crate) texels_per_meter: f32,
    pub(crate) receivers: usize,
    pub(crate) probes: usize,
}

impl Wishes {
    /// The distance between neighbouring probes is the same everywhere.
    pub(crate) fn has_uniform_spacing(&self) -> bool {
        self.smallest_spacing == self.widest_spacing
    }

    /// Bytes of U and ΣVᵀ that each of so many receivers may take, if these decide.
    pub(crate) fn byte_budget(&self, receivers: usize) -> Option<f32> {
        self.bytes.budget(receivers)
    }

    /// The settings that go into the file.
    pub(crate) fn settle(&self, decided: Decided) -> BakeSettings {
        let surfel_size = match self.surfel_size {
            SurfelSize::Fixed(size) => size,
            SurfelSize::About(size) => size.max(TEXELS_PER_SURFEL / decided.texels_per_meter),
        };
        let near_radius = match self.plan.surfaces {
            SurfaceSignals::RelightHits => None,
            SurfaceSignals::Patches => {
                Some(self.near_radius.unwrap_or(SURFELS_PER_NEAR_RADIUS * surfel_size))
            }
        };
        let relight_rays = self.relight_rays.of_each(decided.probes);
        BakeSettings {
            method: self.method,
            metric: self.metric,
            storage: self.storage,
            texels_per_meter: decided.texels_per_meter,
            probe_spacing: self.widest_spacing,
            sh_degree: self.sh_degree.of(relight_rays),
            sky_degree: self.plan.sky_degree,
            surfel_size,
            samples_per_surfel: self.samples_per_surfel,
            near_radius,
            gather_rays: self.gather_rays.of_each(decided.receivers),
            relight_rays,
            probes_per_cluster: self.probes_per_cluster,
            receivers_per_cluster: self.receivers_per_cluster,
            blend_borders: self.blend_borders,
            max_rank: self.max_rank,
            max_cluster_error: self.error.error(),
            byte_price: match self.bytes {
                Bytes::Price(price) => price,
                // A budget's price is found when the light is known.
                _ => 0.0,
            },
            grid_vertices: match self.grid {
                GridDensity::Vertices(count) => Some(count),
                GridDensity::ByReceivers => {
                    Some((decided.receivers / RECEIVERS_PER_VERTEX).max(FEWEST_VERTICES) as u32)
                }
                _ => None,
            },
            grid_spacing: match self.grid {
                GridDensity::Even(spacing) => Some(spacing),
                _ => None,
            },
            grid_basis: self.grid_basis,
            seed: self.seed,
        }
    }
}

impl BakeOptions {
    /// Checks the options and fills in the defaults for one scene.
    pub(crate) fn resolve(&self, tracer: &Tracer) -> Result<Wishes, BakeError> {
        let preset = self.quality.unwrap_or_default().preset();
        let method = self.method.unwrap_or_default();
        let plan = SignalPlan::of(method);
        let scale = Scale::of(tracer);
        let error = self.error_goal(plan.error_factor * preset.max_cluster_error)?;
        let usual_rank = (plan.rank_factor * preset.max_rank as f32) as u32;
        let default_rank = if error.must_be_met() { HIGHEST_RANK } else { usual_rank };
        let density = self.density(scale.free_distance, preset.max_receivers)?;
        let estimated_texel_size = density.estimated_texel_size(scale.area);
        let [smallest_spacing, widest_spacing] = match positive("the probe density", self.probe_density)? {
            Some(density) => [spacing_at(density); 2],
            None => default_spacings(scale.unit, estimated_texel_size),
        };
        let receivers = scale.area / f64::from(estimated_texel_size).powi(2);
        let [gather_rays, relight_rays] = self.rays(&plan, &preset)?;
        let surfel_size = positive("the surfel size", self.surfel_size)?;
        let storage = self.storage.unwrap_or(plan.storage);
        Ok(Wishes {
            plan,
            density,
            estimated_texel_size,
            voxel_size: scale.voxel_size(VOXEL_PER_SPACING * smallest_spacing, receivers),
            use_uv1: self.use_uv1,
            widest_spacing,
            smallest_spacing,
            error,
            seed: self.seed.unwrap_or(0),
            grid: self.grid(tracer)?,
            grid_basis: self.grid_basis.unwrap_or_default(),
            method,
            metric: self.metric.unwrap_or(plan.metric),
            storage,
            surfel_size: surfel_size
                .map_or(SurfelSize::About(scale.free_distance * SURFEL_PER_FREE_DISTANCE), SurfelSize::Fixed),
            samples_per_surfel: within("the samples per surfel", self.samples_per_surfel, 16, 1..=64)?,
            near_radius: positive("the near radius", self.near_radius)?,
            gather_rays,
            relight_rays,
            sh_degree: self.degree(&plan)?,
            max_rank: within("the rank", self.max_rank, default_rank, 1..=HIGHEST_RANK)?,
            probes_per_cluster: within(
                "the probes per cluster",
                self.probes_per_cluster,
                plan.probes_per_cluster,
                1..=40,
            )?,
            receivers_per_cluster: within(
                "the receivers per cluster",
                self.receivers_per_cluster,
                plan.receivers_per_cluster,
                16..=4096,
            )?,
            blend_borders: self.blend_borders.unwrap_or(plan.blend_borders),
            bytes: self.bytes(&preset, storage, error)?,
        })
    }

    fn bytes(&self, preset: &Preset, storage: Storage, error: ErrorGoal) -> Result<Bytes, BakeError> {
        let price = positive("the price of a byte", self.byte_price)?;
        let budget = positive("the bytes per receiver", self.bytes_per_receiver)?;
        Ok(match (price, budget) {
            (Some(price), _) => Bytes::Price(price),
            _ if error.must_be_met() || storage == Storage::F16 => Bytes::Any,
            (None, Some(bytes)) => Bytes::Budget(bytes),
            (None, None) => Bytes::BudgetOf(preset.bytes_per_receiver, preset.full_budget_receivers),
        })
    }

    /// An error that was asked for is met, unless a rank was, too.
    fn error_goal(&self, default: f32) -> Result<ErrorGoal, BakeError> {
        let error = positive("the largest cluster error", self.max_cluster_error)?;
        Ok(match (error, self.max_rank) {
            (Some(error), None) => ErrorGoal::AtMost(error),
            (error, _) => ErrorGoal::About(error.unwrap_or(default)),
        })
    }

    /// Gather rays of a receiver and relight rays of a probe. A number that was asked for does not grow.
    fn rays(&self, plan: &SignalPlan, preset: &Preset) -> Result<[Rays; 2], BakeError> {
        let gather_rays = plan.gather_rays_factor * preset.gather_rays;
        let budget =
            |option: Option<u32>, budget: u64| (plan.fills_ray_budgets && option.is_none()).then_some(budget);
        Ok([
            Rays {
                fewest: within("the gather rays", self.gather_rays, gather_rays, 16..=65_536)?,
                budget: budget(self.gather_rays, preset.gather_ray_budget),
            },
            Rays {
                fewest: within("the relight rays", self.relight_rays, 512, 16..=16_384)?,
                budget: budget(self.relight_rays, preset.relight_ray_budget),
            },
        ])
    }

    fn degree(&self, plan: &SignalPlan) -> Result<Degree, BakeError> {
        let asked = within("the SH degree", self.sh_degree, USUAL_DEGREE, 0..=MAX_SH_DEGREE)?;
        let follows_rays = plan.fills_ray_budgets && self.sh_degree.is_none();
        Ok(if follows_rays { Degree::OfRays } else { Degree::Fixed(asked) })
    }

    /// How many vertices the grid has.
    fn grid(&self, tracer: &Tracer) -> Result<GridDensity, BakeError> {
        let spacing = positive("the grid's spacing", self.grid_spacing)?;
        let levels = within("the grid's levels", self.grid_levels, MAX_GRID_LEVELS, 1..=MAX_GRID_LEVELS)?;
        Ok(match (spacing, self.grid_vertices) {
            (Some(spacing), _) => GridDensity::Even(spacing),
            (None, Some(0)) => GridDensity::Nowhere,
            (None, Some(vertices)) if levels == 1 => {
                GridDensity::Even(even_spacing(&tracer.scene().bounds(), vertices as f32))
            }
            (None, Some(vertices)) => GridDensity::Vertices(vertices),
            (None, None) => GridDensity::ByReceivers,
        })
    }

    fn density(&self, free_distance: f32, max_receivers: u32) -> Result<TexelDensity, BakeError> {
        let receivers = self
            .receivers
            .map(|n| within("the number of receivers", Some(n), n, 1..=64_000_000))
            .transpose()?;
        Ok(match (positive("the texel density", self.texels_per_meter)?, receivers) {
            (Some(texels_per_meter), _) => TexelDensity::Fixed(texels_per_meter),
            (None, Some(receivers)) => TexelDensity::Receivers(receivers),
            (None, None) => TexelDensity::AtMost {
                receivers: max_receivers,
                texels_per_meter: 1.0 / (free_distance * TEXEL_PER_FREE_DISTANCE),
            },
        })
    }
}

/// Distance between the vertices of an even grid with so many over the scene's bounds (\[SED\] eq. 8), metres.
pub(crate) fn even_spacing(bounds: &Bounds, vertices: f32) -> f32 {
    let size = bounds.size().as_dvec3();
    // Flat scenes have room above them.
    let size = size.max(DVec3::splat(FLATTEST * size.max_element()));
    (size.element_product() / f64::from(vertices)).cbrt() as f32
}

/// Smallest and largest distance between neighbouring probes, metres. They are no denser than the texels, so that their
/// number follows what was asked for.
fn default_spacings(unit: f32, texel_size: f32) -> [f32; 2] {
    let widest = unit * spacing_at(SPARSEST_PROBE_DENSITY);
    [SMALLEST_SPACING * widest, widest].map(|spacing| spacing.max(texel_size))
}

/// Distance between neighbours, metres, at a number of probes per m³.
fn spacing_at(density: f32) -> f32 {
    density.powf(-1.0 / 3.0)
}

/// An option that must be a positive number.
fn positive(option: &'static str, value: Option<f32>) -> Result<Option<f32>, BakeError> {
    match value {
        Some(v) if !(v > 0.0 && v.is_finite()) => {
            Err(BakeError::Option { option, expected: "positive".to_owned(), got: v.to_string() })
        }
        other => Ok(other),
    }
}

/// An option, or its default, that must be within a range.
fn within(
    option: &'static str,
    value: Option<u32>,
    default: u32,
    range: RangeInclusive<u32>,
) -> Result<u32, BakeError> {
    let value = value.unwrap_or(default);
    if range.contains(&value) {
        return Ok(value);
    }
    let expected = format!("{} to {}", range.start(), range.end());
    Err(BakeError::Option { option, expected, got: value.to_string() })
}

#[cfg(test)]
mod tests {
    use super::super::Quality;
    use super::*;

    #[test]
    fn few_get_more_rays_and_many_do_not() {
        let of_each = |count, budget| Rays { fewest: 512, budget }.of_each(count);
        let budget = Some(512 * 1024);
        assert_eq!(
            [1, 256, 257, 512, 513, 1 << 20].map(|n| of_each(n, budget)),
            [2048, 2048, 1024, 1024, 512, 512]
        );
        assert_eq!(of_each(1, None), 512, "what the user asked for stays");
    }

    #[test]
    fn bands_follow_the_rays() {
        let rays = [16, 512, 1024, 2048, 16_384];
        assert_eq!(rays.map(|rays| Degree::OfRays.of(rays)), [7, 7, 7, 10, MAX_SH_DEGREE]);
        assert_eq!(rays.map(|rays| Degree::Fixed(3).of(rays)), [3; 5]);
    }

    #[test]
    fn few_receivers_may_take_more_bytes_each() {
        let preset = Quality::Medium.preset();
        let budget = |options: &BakeOptions, storage, error, receivers| {
            options.bytes(&preset, storage, error).unwrap().budget(receivers)
        };
        let (packed, about) = (Storage::Packed, ErrorGoal::About(0.1));
        let of = |receivers| budget(&BakeOptions::default(), packed, about, receivers).unwrap();
        assert_eq!([1_600_000, 400_000, 100_000, 25_000].map(|n| of(n) / of(400_000)), [1.0, 1.0, 2.0, 4.0]);
        let asked = BakeOptions { bytes_per_receiver: Some(9.0), ..BakeOptions::default() };
        assert_eq!(budget(&asked, packed, about, 10), Some(9.0), "what the user asked for stays");
        // Nothing is to be decided where there is a price, or an error that must be met, or but one storage.
        let priced = BakeOptions { byte_price: Some(0.5), ..BakeOptions::default() };
        assert_eq!(budget(&priced, packed, about, 10), None);
        assert_eq!(budget(&asked, packed, ErrorGoal::AtMost(0.1), 10), None);
        assert_eq!(budget(&asked, Storage::F16, about, 10), None);
    }

    #[test]
    fn probes_are_no_denser_than_texels() {
        let [smallest, widest] = default_spacings(1.0, 0.1);
        assert!((widest.powi(3) * SPARSEST_PROBE_DENSITY - 1.0).abs() < 1e-5 && smallest == 0.25 * widest);
        assert_eq!(default_spacings(1.0, 2.0), [2.0, widest]);
        assert_eq!(default_spacings(1.0, 20.0), [20.0, 20.0]);
    }

    #[test]
    fn a_number_of_receivers_is_a_wish_or_a_limit() {
        assert_eq!(TexelDensity::Fixed(4.0).estimated_texel_size(9.0), 0.25);
        let density = TexelDensity::AtMost { receivers: 10, texels_per_meter: 2.0 };
        assert_eq!((density.receivers(), density.limit()), (Some(10), 2.0));
        assert_eq!([1.0, 90.0].map(|area| density.estimated_texel_size(area)), [0.5, 3.0]);
        assert_eq!(TexelDensity::Receivers(10).limit(), f32::INFINITY);
    }
}
