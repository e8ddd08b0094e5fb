//! What a method's signals are, and the defaults that follow: the one place that asks for the method.

use probelight_asset::{Method, Metric, Storage};

/// Highest band of the sky's own signals: skies are smooth, and what blocks them is in the matrix.
const SKY_DEGREE: u32 = 4;

/// What the clusters' signals are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SignalPlan {
    /// What surfaces are to the signals.
    pub(crate) surfaces: SurfaceSignals,
    /// Highest band of the sky's own signals; without them probes see the sky.
    pub(crate) sky_degree: Option<u32>,
    pub(crate) metric: Metric,
    pub(crate) storage: Storage,
    /// Gather rays as a multiple of what the quality asks for.
    pub(crate) gather_rays_factor: u32,
    /// Relative error and most singular values of a cluster, as multiples of what the quality asks for.
    pub(crate) error_factor: f32,
    pub(crate) rank_factor: f32,
    /// Whether receivers and probes get more rays where there are few of them.
    pub(crate) fills_ray_budgets: bool,
    pub(crate) probes_per_cluster: u32,
    pub(crate) receivers_per_cluster: u32,
    pub(crate) blend_borders: bool,
}

/// What surfaces are to the signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfaceSignals {
    /// Only probes see them: one point for each relight ray (\[SED\]).
    RelightHits,
    /// Patches of near surface and emitters are signals themselves; probes serve what is far away.
    Patches,
}

impl SignalPlan {
    pub(crate) fn of(method: Method) -> Self {
        match method {
            Method::Paper => Self {
                surfaces: SurfaceSignals::RelightHits,
                sky_degree: None,
                metric: Metric::Band,
                storage: Storage::F16,
                gather_rays_factor: 2,
                error_factor: 1.25,
                rank_factor: 0.5,
                fills_ray_budgets: false,
                probes_per_cluster: 10,
                receivers_per_cluster: 256,
                blend_borders: false,
            },
            // Surfels bring the detail, so fewer probes do; the compression takes noise away.
            Method::Hybrid => Self {
                surfaces: SurfaceSignals::Patches,
                sky_degree: Some(SKY_DEGREE),
                metric: Metric::Radiance,
                storage: Storage::Packed,
                gather_rays_factor: 1,
                error_factor: 1.0,
                rank_factor: 1.0,
                fills_ray_budgets: true,
                probes_per_cluster: 6,
                receivers_per_cluster: 512,
                blend_borders: true,
            },
        }
    }

    /// Whether patches, emitters and the sky are signals beside the probes.
    pub(crate) fn has_scalar_signals(&self) -> bool {
        self.surfaces == SurfaceSignals::Patches
    }
}
