//! What a user may ask of a bake ([`BakeOptions`]), the same checked and completed for one scene ([`Wishes`]), and
//! the settings that come of it once the steps have decided what was left to them ([`Wishes::settle`]).

mod quality;
mod scale;
mod signal_plan;
mod wishes;

use probelight_asset::{GridBasis, Method, Metric, Storage};

pub use quality::{Preset, Quality};
pub(crate) use signal_plan::{SignalPlan, SurfaceSignals};
pub(crate) use wishes::{Decided, ErrorGoal, Wishes, even_spacing};

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
    /// sparser than \[SED\]'s 0.02; in scenes that are not as large as rooms or landscapes in metres, per cube
    /// of the power of ten that makes them as large as rooms.
    pub probe_density: Option<f32>,
    /// Width of the surfels, metres. Default: a share of the scene's typical free distance, but not below
    /// two and a half texels.
    pub surfel_size: Option<f32>,
    /// Most light samples per surfel, of one for each of its texels. Default 16.
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
    /// Highest spherical-harmonics band, 0 to 11. Default 7 (\[SED\] Table 1); with the hybrid method 10 where probes
    /// have 2,048 relight rays.
    pub sh_degree: Option<u32>,
    /// Most singular values per cluster, 1 to 256. Default 64 (\[SED\] §3.3 has 32); as many as it takes if
    /// `max_cluster_error` is given.
    pub max_rank: Option<u32>,
    /// Relative error of a cluster's stored matrix. If it is given, every cluster keeps it, at any number of
    /// bytes, unless `max_rank` is given too. Default 0.016, as far as the rank and
    /// `bytes_per_receiver` allow: what is lost then is mostly the noise of the gather rays.
    pub max_cluster_error: Option<f32>,
    /// Most probes a cluster draws on; up to twice as many where more than a few of its rays end at places that
    /// none of them sees. Default 6, with the paper's method 10.
    pub probes_per_cluster: Option<u32>,
    /// Most receivers in a cluster. Default 512, with the paper's method 256: probes serve a cluster well only if it is small against the
    /// distance between them.
    pub receivers_per_cluster: Option<u32>,
    /// Whether clusters blend at the borders between them. Default true, with the paper's method false.
    pub blend_borders: Option<bool>,
    /// Bytes that U and ΣVᵀ may take per receiver, on average; fewer where the wanted error takes fewer. Default 44 from
    /// 400,000 receivers on, and more of fewer: twice as many of a quarter as many.
    pub bytes_per_receiver: Option<f32>,
    /// What a further byte per receiver must save, as a share of the wanted error's energy, instead of
    /// `bytes_per_receiver`, from which it follows otherwise. Give it, and the rays, so that parts of a world baked one by
    /// one are alike.
    pub byte_price: Option<f32>,
    /// Vertices of the grid in free space, about so many that have light; none with 0. Default: one for 40
    /// receivers, but at least 6,000.
    pub grid_vertices: Option<u32>,
    /// Distances that there are between neighbouring vertices, each twice the last: finer in rooms and near emitters.
    /// Default and most 3; with 1 an even grid over the scene's bounds, which has vertices in solids, too (\[SED\] eq. 8).
    pub grid_levels: Option<u32>,
    /// Distance between neighbouring vertices of an even grid, metres, instead of their number.
    pub grid_spacing: Option<f32>,
    /// What a vertex of the grid stores. Default: spherical harmonics of degree 2.
    pub grid_basis: Option<GridBasis>,
    /// Use the scene's second texture coordinates for the lightmap where they are valid.
    pub use_uv1: bool,
    /// Seed of all random numbers. Default 0.
    pub seed: Option<u64>,
}

/// Receivers that the default texel density does not exceed.
pub const DEFAULT_MAX_RECEIVERS: u32 = 400_000;

/// Relight rays of all probes together that doubling the default does not exceed: less than what the probes of a
/// large scene have anyway, so it costs no frame time that matters.
pub const RELIGHT_RAY_BUDGET: u64 = 1 << 18;
