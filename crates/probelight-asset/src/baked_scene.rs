//! The schema of a baked scene.
//!
//! Everything is ordered so that a lower level of detail is a prefix: relight points by their direction's
//! place in the progressive set, a cluster's columns by spherical-harmonics band, its singular values
//! descending, its receivers coarsest lightmap level first.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sh::coefficient_count;
use probelight_scene::{Bounds, Scene};
use serde::{Deserialize, Serialize};

#[cfg(doc)]
use crate::packed::GAIN_STEPS;
use crate::packed::Ranks;

/// Stands for "no such index".
pub const NONE: u32 = u32::MAX;

/// What a bake leaves behind: everything the runtime needs, without the source scene's file.
#[derive(Clone, Debug, Default)]
pub struct BakedScene {
    /// Geometry, materials and textures the scene was baked with.
    pub scene: Scene,
    /// Hash of the source scene's content.
    pub scene_hash: u64,
    /// What the bake was asked for, with every default resolved.
    pub settings: BakeSettings,
    /// What the bake measured.
    pub report: BakeReport,
    /// Where each triangle's light lies.
    pub lightmap: LightmapLayout,
    /// Points whose light is evaluated, surfel by surfel.
    pub light_samples: Vec<LightSample>,
    /// Patches of surface: the only places where light is evaluated.
    pub surfels: Vec<Surfel>,
    /// Larger patches, each made of two smaller ones that come before it; see [`SurfelGroup`].
    pub surfel_groups: Vec<SurfelGroup>,
    /// Emissive surfaces with signals of their own. The surfels on their materials do not shine themselves.
    pub emitters: Vec<Emitter>,
    /// Places where radiance is measured.
    pub probes: Vec<Probe>,
    /// Unit directions of the relight rays, the same for all probes; every prefix is well distributed.
    pub relight_directions: Vec<Vec3>,
    /// The surfel that each relight ray meets, or [`NONE`] for the sky:
    /// `probes.len() × relight_directions.len()`, a probe's rays in a row.
    pub relight_surfels: Vec<u32>,
    /// How much the light of each relight ray counts, in parts of [`GAIN_STEPS`].
    pub relight_gains: Vec<u8>,
    /// Groups of receivers that share one compressed transport matrix.
    pub clusters: Vec<Cluster>,
    /// The clusters' scalar signals, see [`BakedScene::scalar_signals`] and [`Cluster::first_signal`].
    pub cluster_signals: Vec<u32>,
    /// The clusters' probes, indices into `probes`; see [`Cluster::first_probe`].
    pub cluster_probes: Vec<u32>,
    /// Lightmap texel of each receiver, cluster by cluster, coarsest lightmap level first.
    pub receiver_texels: Vec<u32>,
    /// Relative error of each receiver's compressed transport, in [`ERROR_STEPS`]ths of the wanted one, at most 255
    /// of them. No frame reads it.
    pub receiver_errors: Vec<u8>,
    /// All U matrices, packed: per cluster one column of `receiver_count` values for each singular value.
    pub receiver_basis: Vec<u32>,
    /// All ΣVᵀ matrices, packed: per cluster one row of [`BakedScene::column_count`] values for each singular
    /// value.
    pub signal_basis: Vec<u32>,
    /// One factor per row of ΣVᵀ (cluster by cluster, one for each singular value).
    pub row_scales: Vec<f32>,
    /// One factor per column of ΣVᵀ, as the exponent e of 2^(−e/8); cluster by cluster.
    pub column_exponents: Vec<u8>,
}

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

/// Where the light of each triangle lies in the lightmap: one image of `width × height` texels (pages are
/// stacked vertically). Texel (x, y) has index `y · width + x`; its centre is at (x + ½, y + ½).
#[derive(Clone, Debug, Default)]
pub struct LightmapLayout {
    /// Width, texels.
    pub width: u32,
    /// Height of all pages together, texels.
    pub height: u32,
    /// Number of pages stacked in the image.
    pub pages: u32,
    /// Lightmap faces: the front face of triangle t is `faces[t]`, which may be [unlit](LightmapFace::is_lit);
    /// back faces with light of their own follow.
    pub faces: Vec<LightmapFace>,
    /// Per triangle the index of its back face in `faces`, or [`NONE`].
    pub back_faces: Vec<u32>,
    /// Texels without a receiver that bilinear lookups touch: (texel, texel to copy from), the source always
    /// a receiver of the same chart.
    pub dilation: Vec<[u32; 2]>,
}

/// Lightmap coordinates of a triangle's three corners, in texels of the stacked image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightmapFace {
    /// Corner coordinates, in the order of the triangle's corners.
    pub corners: [Vec2; 3],
}

impl LightmapLayout {
    /// Where the light of one side of a triangle lies, texels, at barycentric weights of its second and third
    /// corner; `None` if that side has no light of its own.
    #[inline]
    pub fn position(&self, triangle: u32, is_back_face: bool, barycentric: Vec2) -> Option<Vec2> {
        let face = if is_back_face { *self.back_faces.get(triangle as usize)? } else { triangle };
        let face = self.faces.get(face as usize)?;
        face.is_lit().then(|| face.position(barycentric))
    }
}

impl LightmapFace {
    /// Whether the face has light of its own. The corners of unlit faces (the insides of solids) are all zero.
    #[inline]
    pub fn is_lit(&self) -> bool {
        self.corners != [Vec2::ZERO; 3]
    }

    /// Lightmap position at barycentric weights of the second and third corner, texels.
    #[inline]
    pub fn position(&self, barycentric: Vec2) -> Vec2 {
        let [a, b, c] = self.corners;
        a + (b - a) * barycentric.x + (c - a) * barycentric.y
    }
}

/// A place where incoming radiance is measured and projected to spherical harmonics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Probe {
    /// World position, metres.
    pub position: Vec3,
    /// Distance to the farthest receiver that draws on the probe, metres (for levels of detail).
    pub support_radius: f32,
}

/// A point whose light is evaluated each frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightSample {
    /// World position on the surface, metres.
    pub position: Vec3,
    /// Index of its triangle.
    pub triangle: u32,
    /// Its lightmap texel on its side of the triangle, or [`NONE`] if that side has no light of its own.
    pub texel: u32,
    /// Base colour texture without the material's factor (sRGB-encoded); the fourth byte is 1 on the back
    /// face, else 0.
    pub base_color_and_side: [u8; 4],
    /// Emissive texture without the material's factor (sRGB-encoded); the fourth byte is 0.
    pub emission_texel: [u8; 4],
}

impl LightSample {
    /// Whether the sample lies on the back face of its triangle.
    #[inline]
    pub fn is_back_face(&self) -> bool {
        self.base_color_and_side[3] != 0
    }
}

/// A patch of surface. Its radiance is the mean of its samples' outgoing radiance
/// `Le + ρ/π · (E_direct + E_lightmap)`; Le is left out where an [`Emitter`] carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Surfel {
    /// First of its samples (index into `light_samples`); surfels divide the samples among them in order.
    pub first_sample: u32,
    /// Number of samples, at least one.
    pub sample_count: u32,
}

/// A patch made of two smaller ones: its radiance is `w · first + (1 − w) · second`.
///
/// Surfels and groups share one numbering: surfel s is s, group g is `surfels.len() + g`. Children have
/// smaller numbers than their group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SurfelGroup {
    /// The two patches.
    pub children: [u32; 2],
    /// Share w of the first in the area, 0 to 1.
    pub first_weight: f32,
}

/// An emissive surface, or a part of one. Its signal is its mean emitted radiance: the material's present
/// emission times `mean_texel`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Emitter {
    /// Index of its material.
    pub material: u32,
    /// Mean of the emissive texture, linear RGB.
    pub mean_texel: Vec3,
}

/// Receivers that share a compressed transport matrix A ≈ U·(ΣVᵀ) (\[SED\] eq. 6).
///
/// A's input is a list of signals. Its first `signal_count` columns are scalar signals
/// ([`BakedScene::scalar_signals`]); then come the coefficients of the cluster's P probes: column
/// `signal_count + P·l² + p·(2l+1) + (l+m)` is coefficient (l, m) of the p-th, so that fewer bands are fewer
/// leading columns.
///
/// Value (k, c) of ΣVᵀ is `row_scale[k] · 2^(−column_exponent[c]/8) · v` with v as stored; U's values are as
/// stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cluster {
    /// Box around the receivers, metres.
    pub bounds: Bounds,
    /// Where in the scene's air its receivers lie: no light gets from one air space to another. [`NONE`] for receivers
    /// that see no probe.
    pub air_space: u32,
    /// First receiver (index into `receiver_texels`).
    pub first_receiver: u32,
    /// Number of receivers.
    pub receiver_count: u32,
    /// First scalar signal (index into `cluster_signals`).
    pub first_signal: u32,
    /// Number of scalar signals.
    pub signal_count: u32,
    /// First probe (index into `cluster_probes`).
    pub first_probe: u32,
    /// Number of probes.
    pub probe_count: u32,
    /// How many singular values are kept, and with which precision U has them.
    pub receiver_ranks: Ranks,
    /// With which precision ΣVᵀ has them; as many.
    pub signal_ranks: Ranks,
    /// Offset of U in `receiver_basis`, words.
    pub receiver_basis_offset: u64,
    /// Offset of ΣVᵀ in `signal_basis`, words.
    pub signal_basis_offset: u64,
    /// Offset of the row scales in `row_scales`.
    pub row_scale_offset: u32,
    /// Offset of the column exponents in `column_exponents`.
    pub column_exponent_offset: u64,
    /// Relative error of the compressed matrix in the bake's metric.
    pub error: f32,
}

impl Cluster {
    /// Number of singular values.
    pub const fn rank(&self) -> u32 {
        self.receiver_ranks.total()
    }

    /// Words of U.
    pub fn receiver_basis_words(&self) -> u64 {
        self.receiver_ranks.words(u64::from(self.receiver_count))
    }
}

/// What [`BakedScene::receiver_errors`] has for the wanted error.
pub const ERROR_STEPS: f32 = 64.0;

impl BakedScene {
    /// Number of scalar signals. In order: the radiance of each surfel, of each surfel group, of each emitter,
    /// and the sky's coefficients (if it has [signals of its own](BakeSettings::sky_degree)).
    pub fn scalar_signals(&self) -> usize {
        self.first_sky_signal() + self.sky_coefficients()
    }

    /// Number of the first emitter's signal.
    pub fn first_emitter_signal(&self) -> usize {
        self.surfels.len() + self.surfel_groups.len()
    }

    /// Number of the sky's first signal.
    pub fn first_sky_signal(&self) -> usize {
        self.first_emitter_signal() + self.emitters.len()
    }

    /// Number of the sky's own signals.
    pub fn sky_coefficients(&self) -> usize {
        self.settings.sky_degree.map_or(0, |degree| coefficient_count(degree as usize))
    }

    /// Number of spherical-harmonics coefficients per probe.
    pub fn coefficients(&self) -> usize {
        coefficient_count(self.settings.sh_degree as usize)
    }

    /// Lightmap texels of a cluster's receivers.
    pub fn texels(&self, cluster: &Cluster) -> &[u32] {
        &self.receiver_texels[cluster.first_receiver as usize..][..cluster.receiver_count as usize]
    }

    /// Number of columns of a cluster's ΣVᵀ.
    pub fn column_count(&self, cluster: &Cluster) -> usize {
        cluster.signal_count as usize + cluster.probe_count as usize * self.coefficients()
    }

    /// Bytes of the transport matrices and their metadata (what a frame reads to gather light), per
    /// receiver.
    pub fn matrix_bytes_per_receiver(&self) -> f64 {
        let bytes = size_of_val(&self.receiver_basis[..])
            + size_of_val(&self.signal_basis[..])
            + size_of_val(&self.row_scales[..])
            + size_of_val(&self.column_exponents[..])
            + size_of_val(&self.cluster_signals[..])
            + size_of_val(&self.cluster_probes[..])
            + size_of_val(&self.receiver_texels[..])
            + size_of_val(&self.clusters[..]);
        bytes as f64 / self.receiver_texels.len().max(1) as f64
    }
}
