//! The stages of a frame by name.

use std::time::Duration;

/// A stage of a frame, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Scalar signals: radiance of surfels and groups. Direct light and shading only if something changed.
    LightSurfels,
    /// The probes' coefficients.
    RelightProbes,
    /// The clusters' coefficients.
    ProjectClusters,
    /// Irradiance of the receivers.
    GatherReceivers,
    /// Texels around the charts.
    DilateLightmap,
    /// Coarser levels of the lightmap.
    ReduceLightmap,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 6] = [
        Self::LightSurfels,
        Self::RelightProbes,
        Self::ProjectClusters,
        Self::GatherReceivers,
        Self::DilateLightmap,
        Self::ReduceLightmap,
    ];

    /// Its name, that of its file on both sides.
    pub const fn name(self) -> &'static str {
        match self {
            Self::LightSurfels => "light_surfels",
            Self::RelightProbes => "relight_probes",
            Self::ProjectClusters => "project_clusters",
            Self::GatherReceivers => "gather_receivers",
            Self::DilateLightmap => "dilate_lightmap",
            Self::ReduceLightmap => "reduce_lightmap",
        }
    }
}

/// How long the stages of a frame took on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimings {
    /// In the order of [`Stage::ALL`].
    pub stages: [Duration; Stage::ALL.len()],
    /// From the beginning of the first stage to the end of the last, shadow maps not included.
    pub frame: Duration,
}
