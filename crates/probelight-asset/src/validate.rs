//! What the runtime may rely on without looking: every index in range, every number finite, every matrix as
//! large as its cluster says.

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{AlphaMode, Light, Material};

use crate::{AssetError, BakeReport, BakedScene, Cluster, NONE};

/// Highest spherical-harmonics band a file may ask for; recurrences in f32 are accurate far beyond the 7 of
/// the paper, and tables stay small.
const MAX_SH_DEGREE: u32 = 32;

/// Lightmaps up to this size may be empty: 4 Mi texels.
const FREE_LIGHTMAP_TEXELS: u64 = 1 << 22;

/// A larger lightmap must use at least one texel in this many, so that a small file cannot demand a huge
/// image.
const MAX_TEXELS_PER_USED_TEXEL: u64 = 64;

/// How far the length of a unit vector may be from 1.
const UNIT_TOLERANCE: f32 = 1e-3;

/// `Err` with a formatted reason unless the condition holds (NaN in a comparison does not hold).
macro_rules! ensure {
    ($condition:expr, $($reason:tt)+) => {
        if $condition {} else {
            return Err(format!($($reason)+));
        }
    };
}

impl BakedScene {
    /// Checks every promise that the runtime relies on: matching lengths, indices in range, finite numbers,
    /// clusters that lie one after the other, a lightmap whose size fits its use.
    ///
    /// # Errors
    /// [`AssetError::Invalid`], naming the first thing that is wrong.
    pub fn validate(&self) -> Result<(), AssetError> {
        self.scene.validate().map_err(|error| AssetError::Invalid { reason: error.to_string() })?;
        self.check_scene_numbers()
            .and_then(|()| self.check_settings())
            .and_then(|()| self.check_lightmap())
            .and_then(|()| self.check_texels())
            .and_then(|()| self.check_probes())
            .and_then(|()| self.check_relight_points())
            .and_then(|()| self.check_clusters())
            .and_then(|()| self.check_matrices())
            .map_err(|reason| AssetError::Invalid { reason })
    }

    /// Number of lightmap texels.
    fn texel_count(&self) -> u64 {
        u64::from(self.lightmap.width) * u64::from(self.lightmap.height)
    }

    /// The scene's numbers that [`probelight_scene::Scene::validate`] leaves alone.
    fn check_scene_numbers(&self) -> Result<(), String> {
        for (m, material) in self.scene.materials.iter().enumerate() {
            ensure!(material_is_finite(material), "material {m} has a factor that is not finite");
        }
        for (l, light) in self.scene.lights.iter().enumerate() {
            ensure!(light_is_finite(light), "light {l} has a number that is not finite");
        }
        for (c, camera) in self.scene.cameras.iter().enumerate() {
            let finite = [camera.position, camera.target, camera.up].iter().all(|v| v.is_finite());
            ensure!(finite && camera.vertical_fov.is_finite(), "camera {c} has a number that is not finite");
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
        let asked = [settings.texels_per_meter, settings.probe_spacing, settings.max_cluster_error];
        ensure!(asked.iter().all(|v| v.is_finite()), "the settings have a number that is not finite");
        ensure!(
            settings.sh_degree <= MAX_SH_DEGREE,
            "spherical harmonics of degree {}, and {MAX_SH_DEGREE} is the highest",
            settings.sh_degree
        );
        Ok(())
    }

    fn check_lightmap(&self) -> Result<(), String> {
        let map = &self.lightmap;
        let (texels, triangles) = (self.texel_count(), self.scene.triangles.len());
        let used = (self.receiver_texels.len() + map.dilation.len()) as u64;
        ensure!(
            texels > 0
                && texels < u64::from(NONE)
                && texels <= FREE_LIGHTMAP_TEXELS.max(used * MAX_TEXELS_PER_USED_TEXEL),
            "a lightmap of {} × {} texels for {used} used ones",
            map.width,
            map.height
        );
        ensure!(
            map.pages > 0 && map.height.is_multiple_of(map.pages),
            "{} lightmap pages in a height of {} texels",
            map.pages,
            map.height
        );
        ensure!(map.faces.len() >= triangles, "{} lit faces for {triangles} triangles", map.faces.len());
        ensure!(
            map.back_faces.len() == triangles,
            "{} back faces for {triangles} triangles",
            map.back_faces.len()
        );
        for (t, face) in map.back_faces.iter().enumerate() {
            ensure!(
                *face == NONE || (triangles..map.faces.len()).contains(&(*face as usize)),
                "triangle {t} has the back face {face}, which does not exist"
            );
        }
        let size = Vec2::new(map.width as f32, map.height as f32);
        for (f, face) in map.faces.iter().enumerate() {
            let inside = |corner: &Vec2| corner.cmpge(Vec2::ZERO).all() && corner.cmple(size).all();
            ensure!(face.corners.iter().all(inside), "lit face {f} leaves the lightmap");
        }
        Ok(())
    }

    /// No texel is written twice, and dilation copies from receivers. Relies on the lightmap's size being
    /// sane.
    fn check_texels(&self) -> Result<(), String> {
        let texels = self.texel_count();
        let mut is_receiver = vec![false; texels as usize];
        for (r, texel) in self.receiver_texels.iter().enumerate() {
            ensure!(u64::from(*texel) < texels, "receiver {r} has texel {texel} of {texels}");
            let taken = std::mem::replace(&mut is_receiver[*texel as usize], true);
            ensure!(!taken, "receiver {r} shares texel {texel} with another");
        }
        let mut is_dilated = vec![false; texels as usize];
        for (d, [texel, source]) in self.lightmap.dilation.iter().enumerate() {
            ensure!(
                u64::from(*texel.max(source)) < texels,
                "dilation {d} copies texel {source} to {texel} of {texels}"
            );
            ensure!(is_receiver[*source as usize], "dilation {d} copies texel {source}, not a receiver's");
            ensure!(!is_receiver[*texel as usize], "dilation {d} overwrites texel {texel} of a receiver");
            let taken = std::mem::replace(&mut is_dilated[*texel as usize], true);
            ensure!(!taken, "dilation {d} writes texel {texel} a second time");
        }
        Ok(())
    }

    fn check_probes(&self) -> Result<(), String> {
        for (p, probe) in self.probes.iter().enumerate() {
            ensure!(
                probe.position.is_finite() && probe.support_radius >= 0.0 && probe.support_radius.is_finite(),
                "probe {p} has a position or radius that is not usable"
            );
        }
        for (d, direction) in self.relight_directions.iter().enumerate() {
            ensure!(
                (direction.length() - 1.0).abs() <= UNIT_TOLERANCE,
                "relight direction {d} is not a unit vector"
            );
        }
        Ok(())
    }

    fn check_relight_points(&self) -> Result<(), String> {
        let (probes, rays) = (self.probes.len(), self.relight_directions.len());
        ensure!(
            probes.checked_mul(rays) == Some(self.relight_points.len()),
            "{} relight points for {probes} probes with {rays} rays",
            self.relight_points.len()
        );
        let (texels, triangles) = (self.texel_count(), self.scene.triangles.len());
        for (p, point) in self.relight_points.iter().enumerate() {
            ensure!(point.position.is_finite(), "relight point {p} is not finite");
            ensure!(
                point.triangle == NONE || (point.triangle as usize) < triangles,
                "relight point {p} lies on triangle {} of {triangles}",
                point.triangle
            );
            ensure!(
                point.texel == NONE || u64::from(point.texel) < texels,
                "relight point {p} reads texel {} of {texels}",
                point.texel
            );
        }
        Ok(())
    }

    /// Clusters divide receivers, matrices and row scales among them, one after the other.
    fn check_clusters(&self) -> Result<(), String> {
        for (i, probe) in self.cluster_probes.iter().enumerate() {
            ensure!((*probe as usize) < self.probes.len(), "entry {i} of the clusters' probes is {probe}");
        }
        let mut end = ClusterEnd::default();
        for (c, cluster) in self.clusters.iter().enumerate() {
            ensure!(end.is_start_of(cluster), "cluster {c} does not start where the one before it ends");
            let probes_end = u64::from(cluster.first_probe) + u64::from(cluster.probe_count);
            ensure!(probes_end <= self.cluster_probes.len() as u64, "cluster {c} has probes of no cluster");
            let box_ = &cluster.bounds;
            ensure!(
                box_.min.is_finite() && box_.max.is_finite() && box_.min.cmple(box_.max).all(),
                "cluster {c} has a box that is not one"
            );
            ensure!(cluster.error >= 0.0 && cluster.error.is_finite(), "cluster {c} has no usable error");
            end.advance(cluster, self.coefficients() as u64)
                .ok_or_else(|| format!("cluster {c} is too large"))?;
        }
        let lengths = ClusterEnd {
            receivers: self.receiver_texels.len() as u64,
            receiver_basis: self.receiver_basis.len() as u64,
            signal_basis: self.signal_basis.len() as u64,
            row_scales: self.row_scales.len() as u64,
        };
        ensure!(end == lengths, "the clusters need {end:?}, and there are {lengths:?}");
        Ok(())
    }

    fn check_matrices(&self) -> Result<(), String> {
        let finite = self.receiver_basis.iter().chain(&self.signal_basis).all(|v| v.is_finite());
        ensure!(finite, "a transport matrix has a value that is not finite");
        ensure!(self.row_scales.iter().all(|v| v.is_finite()), "a row scale is not finite");
        Ok(())
    }
}

/// How much of the shared arrays the clusters so far have taken.
#[derive(Debug, Default, PartialEq)]
struct ClusterEnd {
    receivers: u64,
    receiver_basis: u64,
    signal_basis: u64,
    row_scales: u64,
}

impl ClusterEnd {
    fn is_start_of(&self, cluster: &Cluster) -> bool {
        u64::from(cluster.first_receiver) == self.receivers
            && cluster.receiver_basis_offset == self.receiver_basis
            && cluster.signal_basis_offset == self.signal_basis
            && u64::from(cluster.row_scale_offset) == self.row_scales
    }

    /// Adds a cluster; `None` on overflow.
    fn advance(&mut self, cluster: &Cluster, coefficients: u64) -> Option<()> {
        let rank = u64::from(cluster.rank);
        let columns = u64::from(cluster.probe_count).checked_mul(coefficients)?;
        let receivers = u64::from(cluster.receiver_count);
        self.receivers = self.receivers.checked_add(receivers)?;
        self.receiver_basis = self.receiver_basis.checked_add(rank.checked_mul(receivers)?)?;
        self.signal_basis = self.signal_basis.checked_add(rank.checked_mul(columns)?)?;
        self.row_scales = self.row_scales.checked_add(rank)?;
        Some(())
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

fn light_is_finite(light: &Light) -> bool {
    let finite = |vectors: &[Vec3]| vectors.iter().all(|v| v.is_finite());
    match light {
        Light::Point { position, intensity } => finite(&[*position, *intensity]),
        Light::Spot { position, direction, intensity, inner_angle, outer_angle } => {
            finite(&[*position, *direction, *intensity]) && (inner_angle + outer_angle).is_finite()
        }
        Light::Directional { direction, irradiance } => finite(&[*direction, *irradiance]),
    }
}
