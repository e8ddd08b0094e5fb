//! What a bake was asked for and what it measured.

use serde::{Deserialize, Serialize};

use crate::GridBasis;

/// Parameters of a bake. Lengths are metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeSettings {
    /// What the clusters' signals are.
    pub method: Method,
    /// What the matrices are compressed for.
    pub metric: Metric,
    /// How the matrices are stored.
    pub storage: Storage,
    /// Lightmap texels per metre.
    pub texels_per_meter: f32,
    /// Mean distance between neighbouring probes.
    pub probe_spacing: f32,
    /// Highest spherical-harmonics band of the probes.
    pub sh_degree: u32,
    /// Highest spherical-harmonics band of the sky's own signals; without them probes see the sky.
    pub sky_degree: Option<u32>,
    /// Width of the surfels.
    pub surfel_size: f32,
    /// Most light samples per surfel.
    pub samples_per_surfel: u32,
    /// Distance from a receiver up to which it takes light from surfels, not from probes; without it, all.
    pub near_radius: Option<f32>,
    /// Gather rays per receiver.
    pub gather_rays: u32,
    /// Relight rays per probe.
    pub relight_rays: u32,
    /// Most probes a cluster may draw on.
    pub probes_per_cluster: u32,
    /// Most receivers of a cluster.
    pub receivers_per_cluster: u32,
    /// Whether clusters blend at the borders between them, see [`BorderBlend`](crate::BorderBlend).
    pub blend_borders: bool,
    /// Most singular values kept per cluster.
    pub max_rank: u32,
    /// Relative error of a cluster's compressed transport that the bake aims at.
    pub max_cluster_error: f32,
    /// What a further byte per receiver had to save where that error was out of reach, as a share of its energy.
    pub byte_price: f32,
    /// Wanted number of vertices of the grid in free space, more of them in rooms and near emitters.
    pub grid_vertices: Option<u32>,
    /// Largest distance between neighbouring vertices of an even grid; without it and a number, there is none.
    pub grid_spacing: Option<f32>,
    /// What a vertex of the grid stores.
    pub grid_basis: GridBasis,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// What the clusters' signals are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Probes alone, as published (\[SED\]).
    Paper,
    /// Surfels, emitters and the sky, with probes for what is far away.
    #[default]
    Hybrid,
}

/// In which sense a compressed matrix is near to the full one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// All signals count the same (\[SED\]).
    Plain,
    /// High bands of the probes count less.
    Band,
    /// The light counts that random plausible lightings bring.
    #[default]
    Radiance,
}

/// How the matrices are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Storage {
    /// Half floats.
    F16,
    /// Eight bits for the leading singular values, four for those that carry little.
    #[default]
    Packed,
}

/// Figures a bake reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// Lightmap texels that belong to a chart.
    pub chart_texels: u64,
    /// Chart texels that lie inside geometry and are filled from neighbours.
    pub invalid_texels: u64,
    /// Share of gathered energy whose hit no probe of the cluster sees, taken from the probe that sees
    /// nearest to it.
    pub approximated_fraction: f64,
    /// Share of gathered energy that reached no probe at all and is lost.
    pub uncovered_fraction: f64,
    /// Receiver-weighted mean of the clusters' relative errors.
    pub mean_cluster_error: f64,
    /// Largest of the clusters' relative errors.
    pub max_cluster_error: f64,
    /// Warnings about the input, as sentences.
    pub warnings: Vec<String>,
}
