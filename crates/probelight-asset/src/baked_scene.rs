//! The schema of a baked scene.
//!
//! Everything is ordered so that a lower level of detail is a prefix: relight points by their direction's
//! place in the progressive set, a cluster's columns by spherical-harmonics band, its singular values
//! descending, its receivers coarsest lightmap level first.

use bytemuck::{Pod, Zeroable};
use half::f16;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sh::coefficient_count;
use probelight_scene::{Bounds, Scene};
use serde::{Deserialize, Serialize};

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
    /// Places where radiance is measured.
    pub probes: Vec<Probe>,
    /// Unit directions of the relight rays, the same for all probes; every prefix is well distributed.
    pub relight_directions: Vec<Vec3>,
    /// What each relight ray hits: `probes.len() × relight_directions.len()`, a probe's rays in a row.
    pub relight_points: Vec<RelightPoint>,
    /// Groups of receivers that share one compressed transport matrix.
    pub clusters: Vec<Cluster>,
    /// The clusters' probes, indices into `probes`; see [`Cluster::first_probe`].
    pub cluster_probes: Vec<u32>,
    /// Lightmap texel of each receiver, cluster by cluster, coarsest lightmap level first.
    pub receiver_texels: Vec<u32>,
    /// All U matrices: per cluster `rank` columns of `receiver_count` values (column-major).
    pub receiver_basis: Vec<f16>,
    /// All ΣVᵀ matrices: per cluster `rank` rows of `probe_count · coefficients` values (row-major).
    pub signal_basis: Vec<f16>,
    /// One factor per row of ΣVᵀ (cluster by cluster, `rank` each), so that f16 holds its values well.
    pub row_scales: Vec<f32>,
}

/// Parameters of a bake. Lengths are metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeSettings {
    /// Lightmap texels per metre.
    pub texels_per_meter: f32,
    /// Mean distance between neighbouring probes.
    pub probe_spacing: f32,
    /// Highest spherical-harmonics band of the probes.
    pub sh_degree: u32,
    /// Gather rays per receiver.
    pub gather_rays: u32,
    /// Relight rays per probe.
    pub relight_rays: u32,
    /// Most probes a cluster may draw on.
    pub probes_per_cluster: u32,
    /// Most receivers of a cluster.
    pub receivers_per_cluster: u32,
    /// Most singular values kept per cluster.
    pub max_rank: u32,
    /// Relative error of a cluster's truncated matrix above which it is split.
    pub max_cluster_error: f32,
    /// Seed of all random numbers.
    pub seed: u64,
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

/// What a relight ray hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RelightPoint {
    /// World position, metres; unused for rays that reach the sky.
    pub position: Vec3,
    /// Index of the triangle hit, or [`NONE`] for the sky.
    pub triangle: u32,
    /// Lightmap texel of the hit on the side that was hit, or [`NONE`] if that side has no light of its own.
    pub texel: u32,
    /// Base colour texture at the hit without the material's factor (sRGB-encoded); the fourth byte is 1 if
    /// the back face was hit, else 0.
    pub base_color_and_side: [u8; 4],
    /// Emissive texture at the hit without the material's factor (sRGB-encoded); the fourth byte is 0.
    pub emission_texel: [u8; 4],
}

/// Receivers that share a compressed transport matrix A ≈ U·(ΣVᵀ) (\[SED\] eq. 6).
///
/// A's input is a list of signals. Today all are probe coefficients: column `P·l² + p·(2l+1) + (l+m)` is
/// coefficient (l, m) of the cluster's p-th of P probes, so that fewer bands are fewer leading columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster {
    /// Box around the receivers, metres.
    pub bounds: Bounds,
    /// First receiver (index into `receiver_texels`).
    pub first_receiver: u32,
    /// Number of receivers.
    pub receiver_count: u32,
    /// First probe (index into `cluster_probes`).
    pub first_probe: u32,
    /// Number of probes.
    pub probe_count: u32,
    /// Number of singular values kept.
    pub rank: u32,
    /// Offset of U in `receiver_basis`.
    pub receiver_basis_offset: u64,
    /// Offset of ΣVᵀ in `signal_basis`.
    pub signal_basis_offset: u64,
    /// Offset of the row scales in `row_scales`.
    pub row_scale_offset: u32,
    /// Relative error of the truncated matrix.
    pub error: f32,
}

impl BakedScene {
    /// Number of spherical-harmonics coefficients per probe.
    pub fn coefficients(&self) -> usize {
        coefficient_count(self.settings.sh_degree as usize)
    }

    /// Number of columns of a cluster's ΣVᵀ.
    pub fn column_count(&self, cluster: &Cluster) -> usize {
        cluster.probe_count as usize * self.coefficients()
    }

    /// Bytes of the transport matrices and their metadata (what a frame reads to gather light), per
    /// receiver.
    pub fn matrix_bytes_per_receiver(&self) -> f64 {
        let bytes = size_of_val(&self.receiver_basis[..])
            + size_of_val(&self.signal_basis[..])
            + size_of_val(&self.row_scales[..])
            + size_of_val(&self.cluster_probes[..])
            + size_of_val(&self.receiver_texels[..])
            + size_of_val(&self.clusters[..]);
        bytes as f64 / self.receiver_texels.len().max(1) as f64
    }
}
