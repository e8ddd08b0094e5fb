//! The prepared scene: what all later steps read and none changes.

pub(crate) mod atlas;
mod cut;
pub(crate) mod grid;
mod grid_levels;
mod layout;
mod outlooks;
pub(crate) mod probes;
pub(crate) mod receivers;
mod relight;
pub(crate) mod sample_point;
pub(crate) mod site;
pub(crate) mod texel_points;
pub(crate) mod walls;

use std::ops::Range;
use std::sync::Arc;

use probelight_asset::BakeSettings;
use probelight_math::directions::progressive_sphere;
use probelight_math::glam::Vec3;
use probelight_scene::{AlphaMode, Material, Scene, Warning};
use probelight_trace::{Hit, Progress, Tracer};

use crate::air::point_tree::PointTree;
use crate::air::{Air, LitSides};
use crate::ground::atlas::Atlas;
use crate::ground::cut::{CutScene, cut_along_walls};
use crate::ground::grid::{Grid, place_grid};
use crate::ground::layout::fit_layout;
use crate::ground::outlooks::find_outlooks;
use crate::ground::probes::place_probes;
use crate::ground::receivers::{Receivers, place_receivers};
use crate::ground::relight::trace_relight_rays;
use crate::ground::sample_point::{Lobe, Reception, SamplePoint};
use crate::ground::site::{Place, Site};
use crate::ground::texel_points::TexelPoints;
use crate::ground::walls::{Walls, find_walls};
use crate::options::{Decided, ErrorGoal, SignalPlan};
use crate::partition::KdRule;
use crate::{BakeError, BakeOptions};

/// Rounding of the largest coordinate, as a share of the scene's diagonal, from which on details are lost.
const LARGEST_STEP: f32 = 1e-4;

/// A scene with its lightmap, its sites and its probes.
pub(crate) struct Groundwork {
    /// Hash of the source scene's content.
    pub(crate) scene_hash: u64,
    /// What the bake was asked for, with what the steps decided.
    pub(crate) settings: BakeSettings,
    pub(crate) error: ErrorGoal,
    /// Bytes of U and ΣVᵀ per receiver that the texels' groups may take, if these decide the price of a byte.
    pub(crate) byte_budget: Option<f32>,
    pub(crate) plan: SignalPlan,
    /// What the scene's author should know.
    pub(crate) warnings: Vec<Warning>,
    /// Of the scene cut along walls.
    pub(crate) tracer: Tracer,
    pub(crate) atlas: Atlas,
    /// Lightmap texels with light of their own.
    pub(crate) receivers: Receivers,
    /// The grid in free space.
    pub(crate) grid: Grid,
    /// Walls in its cells.
    pub(crate) walls: Walls,
    /// The places that gather light: the receivers', with the same numbers, then the grid's vertices.
    pub(crate) sites: Vec<Site>,
    /// The points of each receiver's texel that count.
    pub(crate) points: TexelPoints,
    pub(crate) probes: PointTree,
    /// Unit directions of the relight rays.
    pub(crate) directions: Vec<Vec3>,
    /// What they meet, a probe's rays in a row; `None` is the sky.
    pub(crate) relight_hits: Vec<Option<Hit>>,
}

/// Prepares a scene: cuts it, lays out its lightmap, and places receivers and probes.
pub(crate) fn prepare(
    scene: Arc<Scene>,
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Result<Groundwork, BakeError> {
    refuse_invisible(&scene)?;
    progress.begin("building the ray tracer", 1);
    let scene_hash = scene.content_hash();
    let tracer = Tracer::new(scene);
    let wishes = options.resolve(&tracer)?;
    let CutScene { scene, seams } = cut_along_walls(tracer.scene(), wishes.estimated_texel_size);
    let tracer = Tracer::new(Arc::new(scene));
    let reach = if wishes.has_uniform_spacing() { 2 } else { 4 };
    let air = Air::survey(&tracer, wishes.voxel_size, reach, progress)?;
    let lit_sides = LitSides::find(&air, progress)?;
    let layout = fit_layout(&tracer, &lit_sides, &seams, &wishes, progress)?;
    let (receivers, points) = place_receivers(&air, &layout.atlas, &lit_sides, progress)?;
    let probes = place_probes(&air, &wishes, &lit_sides, &receivers.receivers, progress)?;
    let settings = wishes.settle(Decided {
        texels_per_meter: layout.texels_per_meter,
        receivers: receivers.receivers.len(),
        probes: probes.len(),
    });
    let directions = progressive_sphere(settings.relight_rays as usize);
    let relight_hits = trace_relight_rays(&tracer, &probes, &directions, progress)?;
    let probes = PointTree::of(&probes);
    let grid = place_grid(&air, &lit_sides, &settings, progress)?;
    let walls = find_walls(&tracer, &grid, progress)?;
    let on_texels = receivers.receivers.iter().map(|receiver| receiver.ray_origin(&tracer));
    let origins: Vec<Vec3> = on_texels.chain(grid.vertices.iter().map(|vertex| vertex.position)).collect();
    let outlooks = find_outlooks(&tracer, &probes, &directions, &relight_hits, &origins, progress)?;
    let (of_texels, of_grid) = outlooks.split_at(receivers.receivers.len());
    let on_texels = receivers.receivers.iter().zip(of_texels);
    let mut sites: Vec<Site> =
        on_texels.map(|(receiver, outlook)| receiver.site(*outlook, layout.atlas.width)).collect();
    let texel_size = 1.0 / settings.texels_per_meter;
    let points = points.in_sight(&tracer, &sites, &probes, texel_size, progress)?;
    sites.extend(grid.sites(of_grid, layout.atlas.width * layout.atlas.height));
    Ok(Groundwork {
        warnings: [far_away(tracer.scene()), air.warning(), layout.warning].into_iter().flatten().collect(),
        scene_hash,
        settings,
        error: wishes.error,
        byte_budget: wishes.byte_budget(receivers.receivers.len()),
        plan: wishes.plan,
        tracer,
        atlas: layout.atlas,
        receivers,
        grid,
        walls,
        sites,
        points,
        probes,
        directions,
        relight_hits,
    })
}

/// Refuses scenes of nothing but glass: surfaces that no ray meets.
fn refuse_invisible(scene: &Scene) -> Result<(), BakeError> {
    let is_visible = |material: &Material| match material.alpha_mode {
        AlphaMode::Mask { cutoff } => material.base_color.w >= cutoff,
        AlphaMode::Opaque => true,
    };
    if (0..scene.triangles.len()).any(|triangle| is_visible(scene.material(triangle))) {
        return Ok(());
    }
    let reason = "all surfaces are transparent, with an alpha below their cutoff (0.5 for blended ones); light meets \
                  opaque surfaces only";
    Err(BakeError::NothingToLight { reason: reason.into() })
}

/// A warning if the scene lies so far from the origin that details are lost in its numbers.
fn far_away(scene: &Scene) -> Option<Warning> {
    let bounds = scene.bounds();
    let distance = bounds.min.abs().max(bounds.max.abs()).max_element();
    let step = f32::EPSILON * distance;
    (step > LARGEST_STEP * bounds.diagonal()).then(|| Warning {
        message: format!(
            "the scene reaches {distance:.0} from the origin, where positions are known to {step:.1e} only (move it \
             to the origin if details are lost)"
        ),
        count: 1,
    })
}

impl Groundwork {
    /// The sites that are the receivers' texels.
    pub(crate) fn texels(&self) -> Range<u32> {
        0..self.receivers.receivers.len() as u32
    }

    /// The sites that are the grid's vertices.
    pub(crate) fn vertices(&self) -> Range<u32> {
        self.texels().end..self.sites.len() as u32
    }

    /// What a site keeps of the light that meets it.
    pub(crate) fn reception(&self, site: u32) -> Reception {
        if site < self.texels().end {
            Reception::Irradiance
        } else {
            Reception::Basis(self.settings.grid_basis)
        }
    }

    /// A site and its points.
    pub(crate) fn place(&self, number: u32) -> Place<'_> {
        let (site, reception) = (&self.sites[number as usize], self.reception(number));
        let points = match reception {
            Reception::Irradiance => {
                let points = self.points.of(number).iter();
                points.map(|point| SamplePoint::on_surface(&self.tracer, point)).collect()
            }
            Reception::Basis(_) => vec![SamplePoint { origin: site.position, lobe: Lobe::Sphere }],
        };
        Place { site, points, reception }
    }

    /// Gather rays of a site. Those of a vertex of the grid go all around, and serve several rows.
    pub(crate) fn rays_of(&self, site: u32) -> u32 {
        match self.reception(site) {
            Reception::Irradiance => self.settings.gather_rays,
            Reception::Basis(_) => {
                (grid::RAYS_PER_GATHER_RAY * self.settings.gather_rays).max(grid::FEWEST_RAYS)
            }
        }
    }

    /// What a site's compression may lose. Light in the air is read between vertices, which errs by more.
    pub(crate) fn error_of(&self, reception: Reception) -> ErrorGoal {
        match (reception, self.error) {
            (Reception::Basis(_), ErrorGoal::About(error)) => {
                ErrorGoal::About(grid::ERROR_PER_TEXEL_ERROR * error)
            }
            (_, error) => error,
        }
    }

    /// What a byte of a site's compressed transport must save.
    pub(crate) fn byte_price_of(&self, reception: Reception) -> f32 {
        match reception {
            Reception::Irradiance => self.settings.byte_price,
            Reception::Basis(_) => grid::byte_price(self.texels().end),
        }
    }

    /// Share of the light that a site may get from surfels which shine independently of each other, as under a torch. Vertices,
    /// with more columns to keep for the same bytes, err by more with it than they gain.
    pub(crate) fn unforeseen_share_of(&self, reception: Reception) -> f32 {
        match reception {
            Reception::Irradiance => receivers::UNFORESEEN_SHARE,
            Reception::Basis(_) => 0.0,
        }
    }

    /// The rows of a site's transport, in the numbering that the receivers of clusters have.
    pub(crate) fn rows(&self, site: u32) -> Range<u32> {
        let (texels, rows) = (self.texels().end, self.reception(site).rows() as u32);
        // Each texel has one.
        let first = site.min(texels) + site.saturating_sub(texels) * rows;
        first..first + rows
    }

    /// The site that a row belongs to.
    pub(crate) fn site_of_row(&self, row: u32) -> &Site {
        let (texels, rows) = (self.texels().end, self.settings.grid_basis.rows() as u32);
        let site = row.min(texels) + row.saturating_sub(texels) / rows;
        &self.sites[site as usize]
    }

    /// The sites, in groups whose transport is compressed together: first all texels, then all vertices.
    pub(crate) fn groups(&self) -> Vec<Vec<u32>> {
        let (rule, texels) = (self.cluster_rule(), self.settings.receivers_per_cluster as usize);
        let mut groups = rule.partition(&self.sites, self.texels(), texels);
        groups.extend(rule.partition(&self.sites, self.vertices(), grid::VERTICES_PER_GROUP));
        groups
    }

    /// How clusters of sites are divided: those facing opposite ways before those half a full cluster's width apart.
    pub(crate) fn cluster_rule(&self) -> KdRule {
        let width = (self.settings.receivers_per_cluster as f32).sqrt() / self.settings.texels_per_meter;
        KdRule { meters_per_normal: 0.5 * width, by_outlook: true }
    }
}
