//! The schema of a baked scene.
//!
//! [`BakedParts`] is plain data; [`BakedScene`] is the same data after every promise was checked, for reading only.
//!
//! Everything is ordered so that a lower level of detail is a prefix: relight points by their direction's
//! place in the progressive set, a cluster's columns by spherical-harmonics band, its singular values
//! descending, its receivers coarsest lightmap level first.

use std::ops::{Deref, Range};
use std::sync::Arc;

use probelight_math::glam::{Vec3, Vec4};
use probelight_math::sh::coefficient_count;
use probelight_scene::Scene;

#[cfg(doc)]
use crate::packed::GAIN_STEPS;
use crate::{
    BakeReport, BakeSettings, Cluster, Emitter, GridBlock, GridCell, GridLayout, GridVertex, InvalidParts,
    LightSample, LightmapFace, LightmapLayout, Probe, Surfel, SurfelGroup,
};

/// What [`BakedParts::receiver_errors`] has for the wanted error.
pub const ERROR_STEPS: f32 = 64.0;

/// Stands for "no such index".
pub const NONE: u32 = u32::MAX;

/// [`BakedParts`] that are known to be valid: every index is in range, every number finite, every length right.
///
/// The parts can be read but not changed; [`into_parts`](Self::into_parts) gives them back.
#[derive(Clone, Debug)]
pub struct BakedScene(BakedParts);

impl BakedScene {
    /// Checks every promise that the runtime relies on: matching lengths, indices in range, finite numbers,
    /// surfels and clusters that lie one after the other, a lightmap whose size fits its use.
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn new(parts: BakedParts) -> Result<Self, InvalidParts> {
        parts.check().map_err(|reason| InvalidParts { reason })?;
        Ok(Self(parts))
    }

    /// A scene that was not baked: nothing but its analytic lights lights it. To look at it while it is baked.
    ///
    /// # Errors
    /// What is wrong with the scene.
    pub fn unbaked(scene: Arc<Scene>) -> Result<Self, InvalidParts> {
        let triangles = scene.triangles.len();
        let lightmap = LightmapLayout {
            width: 1,
            height: 1,
            pages: 1,
            faces: vec![LightmapFace::default(); triangles],
            back_faces: vec![NONE; triangles],
            dilation: Vec::new(),
        };
        Self::new(BakedParts { scene, lightmap, ..BakedParts::default() })
    }

    /// The parts, to be changed.
    pub fn into_parts(self) -> BakedParts {
        self.0
    }
}

impl Deref for BakedScene {
    type Target = BakedParts;

    fn deref(&self) -> &BakedParts {
        &self.0
    }
}

/// What a bake leaves behind: everything the runtime needs, without the source scene's file. Nothing is checked
/// before it becomes a [`BakedScene`].
#[derive(Clone, Debug, Default)]
pub struct BakedParts {
    /// Geometry, materials and textures the scene was baked with; shared with ray tracers.
    pub scene: Arc<Scene>,
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
    /// Where there is light in free space.
    pub grid: GridLayout,
    /// All blocks of the grid, x first: which vertices have light.
    pub grid_blocks: Vec<GridBlock>,
    /// The vertices that have light, block by block.
    pub grid_vertices: Vec<GridVertex>,
    /// The receivers that hold the vertices' rows, vertex by vertex; they come behind those of the lightmap.
    pub grid_receivers: Vec<u32>,
    /// Which cells of the grid have walls, blocks as `grid_blocks`; a cell has the place of its lowest corner. Empty if
    /// none has.
    pub grid_cell_blocks: Vec<GridBlock>,
    /// The cells that have walls, block by block.
    pub grid_cells: Vec<GridCell>,
    /// Planes that divide cells: unit normal and, last, what makes the sum (x, y, z, 1) · plane zero on it, metres.
    pub grid_planes: Vec<Vec4>,
    /// Groups of receivers that share one compressed transport matrix. Those of the grid come last.
    pub clusters: Vec<Cluster>,
    /// The clusters' scalar signals, see [`BakedParts::scalar_signals`] and [`Cluster::first_signal`].
    pub cluster_signals: Vec<u32>,
    /// The clusters' probes, indices into `probes`; see [`Cluster::first_probe`].
    pub cluster_probes: Vec<u32>,
    /// Lightmap texel of each of the lightmap's receivers, cluster by cluster, coarsest lightmap level first.
    pub receiver_texels: Vec<u32>,
    /// Relative error of each receiver's compressed transport, in [`ERROR_STEPS`]ths of the wanted one, at most 255
    /// of them. No frame reads it.
    pub receiver_errors: Vec<u8>,
    /// All U matrices, packed: per cluster one column of `receiver_count` values for each singular value.
    pub receiver_basis: Vec<u32>,
    /// All ΣVᵀ matrices, packed: per cluster one row of [`BakedParts::column_count`] values for each singular
    /// value.
    pub signal_basis: Vec<u32>,
    /// One factor per row of ΣVᵀ (cluster by cluster, one for each singular value).
    pub row_scales: Vec<f32>,
    /// One factor per column of ΣVᵀ, as the exponent e of 2^(−e/8); cluster by cluster.
    pub column_exponents: Vec<u8>,
}

impl BakedParts {
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

    /// Lightmap texels of a cluster's receivers; none if these are the grid's.
    pub fn texels(&self, cluster: &Cluster) -> &[u32] {
        let texels = self.receiver_texels.get(cluster.first_receiver as usize..).unwrap_or_default();
        &texels[..texels.len().min(cluster.receiver_count as usize)]
    }

    /// The lightmap's receivers, cluster by cluster: numbers of the cluster, of the receiver and of its texel.
    pub fn receivers_with_texels(&self) -> impl Iterator<Item = (u32, u32, u32)> {
        (0..).zip(&self.clusters).flat_map(|(number, cluster)| {
            let texels = (cluster.first_receiver..).zip(self.texels(cluster));
            texels.map(move |(receiver, texel)| (number, receiver, *texel))
        })
    }

    /// A cluster's scalar signals, in the order of its first columns.
    #[inline]
    pub fn signals_of(&self, cluster: &Cluster) -> &[u32] {
        &self.cluster_signals[cluster.first_signal as usize..][..cluster.signal_count as usize]
    }

    /// A cluster's probes.
    #[inline]
    pub fn probes_of(&self, cluster: &Cluster) -> &[u32] {
        &self.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize]
    }

    /// Where a probe's relight rays lie among all.
    #[inline]
    pub fn rays_of(&self, probe: usize) -> Range<usize> {
        let rays = self.relight_directions.len();
        probe * rays..(probe + 1) * rays
    }

    /// The light samples of a surfel; at least one.
    #[inline]
    pub fn samples_of(&self, surfel: &Surfel) -> &[LightSample] {
        &self.light_samples[surfel.first_sample as usize..][..surfel.sample_count as usize]
    }

    /// World position (metres) of a light sample, and the unit geometric normal on its side.
    pub fn place_of(&self, sample: &LightSample) -> (Vec3, Vec3) {
        let triangle = sample.triangle() as usize;
        let front = self.scene.geometric_normal(triangle);
        let normal = if sample.is_back_face() { -front } else { front };
        (self.scene.position(triangle, sample.barycentric()), normal)
    }

    /// The lightmap texel of a light sample; [`NONE`](crate::NONE) if its side has no light of its own.
    pub fn texel_of(&self, sample: &LightSample) -> u32 {
        let texel = self.lightmap.texel(sample.triangle(), sample.is_back_face(), sample.barycentric());
        texel.unwrap_or(NONE)
    }

    /// The receiver of each lightmap texel, [`NONE`](crate::NONE) outside the charts.
    pub fn receivers_of_chart_texels(&self) -> Vec<u32> {
        let mut receivers = vec![NONE; self.lightmap.width as usize * self.lightmap.height as usize];
        for (receiver, texel) in (0..).zip(&self.receiver_texels) {
            receivers[*texel as usize] = receiver;
        }
        receivers
    }

    /// The receiver whose irradiance each lightmap texel shows, around the charts, too; [`NONE`](crate::NONE) if the texel is
    /// never written.
    pub fn receivers_of_texels(&self) -> Vec<u32> {
        let mut receivers = self.receivers_of_chart_texels();
        for [texel, source] in &self.lightmap.dilation {
            receivers[*texel as usize] = receivers[*source as usize];
        }
        receivers
    }

    /// Of each receiver, the number of its cluster.
    pub fn clusters_of_receivers(&self) -> Vec<u32> {
        let clusters = (0..).zip(&self.clusters);
        clusters
            .flat_map(|(number, cluster)| std::iter::repeat_n(number, cluster.receiver_count as usize))
            .collect()
    }

    /// Number of columns of a cluster's ΣVᵀ.
    pub fn column_count(&self, cluster: &Cluster) -> usize {
        cluster.signal_count as usize + cluster.probe_count as usize * self.coefficients()
    }
}
