//! Open air: which places light can reach, and how far they see.
//!
//! Light meets both sides of every surface, but the insides of closed solids are never seen and must not cost
//! receivers or probes. Whether a material is double-sided does not tell, since whole scenes are exported so, and a
//! solid's inside may show the front of whatever else is buried in it. So the scene's empty voxels near surfaces
//! are surveyed once, each with one set of rays. Those that do not look like the inside of a solid are open air. All
//! else follows from them:
//!
//! - a point of a surface is *open* if it is in sight of open air, or if light finds a way to it over other surfaces;
//! - a side of a triangle is lit if any point of it is open ([`LitSides`]);
//! - points of texels are open ones only ([`crate::ground::receivers`]);
//! - probes are put where most of what is seen is lit ([`crate::ground::probes`]).

pub(crate) mod limits;
pub(crate) mod point_tree;
mod sides;
mod voxels;

pub(crate) use voxels::box_overlaps_triangle;

use probelight_math::color::luminance;
use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::Vec3;
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_scene::Warning;
use probelight_trace::{Hit, Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::limits::{
    EXTENT_SHARE, FEWEST_LIT_WALKS, FIRST_PLACE_RAYS, FIRST_WALKS, MAX_BACK_SHARE, MAX_SOLID_SHARE,
    MAX_UNLIT_SHARE, PLACE_RAYS, PLACES_TRIED, SMALLEST_COSINE, STEPS_PER_WALK, WALKS,
};
use crate::air::point_tree::PointTree;
use crate::air::voxels::VoxelGrid;
use crate::steps::for_each_in_parallel;

pub(crate) use sides::LitSides;

/// An empty place near surfaces, and what it sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Survey {
    /// Metres.
    pub(crate) position: Vec3,
    /// Share of its rays that meet back faces of single-sided materials.
    back_share: f32,
    /// Median distance to what it sees, metres; infinite if it mostly sees the sky.
    pub(crate) free_distance: f32,
    /// Distance to the nearest surface that it sees, metres.
    pub(crate) clearance: f32,
    /// Whether it is connected to the outside of the scene's bounds.
    is_outside: bool,
}

impl Survey {
    fn of(tracer: &Tracer, position: Vec3, is_outside: bool) -> Self {
        Self::of_hits(tracer, position, is_outside, &look_around(tracer, position))
    }

    /// From what [`look_around`] found.
    fn of_hits(tracer: &Tracer, position: Vec3, is_outside: bool, hits: &[Option<Hit>]) -> Self {
        let is_solid = |hit: &&Hit| is_inside_of_solid(tracer, hit);
        let backs = hits.iter().flatten().filter(is_solid).count();
        let distances = sorted_distances(hits);
        Self {
            position,
            back_share: backs as f32 / PLACE_RAYS as f32,
            free_distance: distances[PLACE_RAYS / 2],
            clearance: distances[0],
            is_outside,
        }
    }

    fn is_open(&self) -> bool {
        self.is_outside || self.back_share <= MAX_BACK_SHARE
    }
}

/// How large the space around a place is, and what emitters send there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings {
    /// Distance within which it meets a surface in nearly all directions, metres; infinite outdoors.
    pub(crate) extent: f32,
    /// Mean luminance of emitters over all directions.
    pub(crate) emission: f32,
    /// The same over distance squared, 1/m².
    pub(crate) emission_change: f32,
}

fn rays_around(position: Vec3) -> impl Iterator<Item = Ray> {
    (0..PLACE_RAYS).map(move |ray| Ray::new(position, spherical_fibonacci(ray, PLACE_RAYS)))
}

/// What the rays of a place meet.
fn look_around(tracer: &Tracer, position: Vec3) -> Vec<Option<Hit>> {
    rays_around(position).map(|ray| tracer.closest_hit(&ray)).collect()
}

/// Distances to what a place sees, metres, nearest first; infinite for the sky.
fn sorted_distances(hits: &[Option<Hit>]) -> Vec<f32> {
    let mut distances: Vec<f32> =
        hits.iter().map(|hit| hit.map_or(f32::INFINITY, |hit| hit.distance)).collect();
    distances.sort_by(f32::total_cmp);
    distances
}

/// How many hits are on unlit sides.
fn unlit_hits(hits: &[Option<Hit>], lit_sides: &LitSides) -> usize {
    hits.iter().flatten().filter(|hit| !lit_sides.is_lit(hit)).count()
}

/// Whether few enough of a place's rays meet unlit sides that light may be measured there.
fn is_lit_enough(unlit: usize) -> bool {
    unlit as f32 / PLACE_RAYS as f32 <= MAX_UNLIT_SHARE
}

/// Whether a hit looks like the inside of a solid.
fn is_inside_of_solid(tracer: &Tracer, hit: &Hit) -> bool {
    hit.is_back_face && !tracer.scene().material(hit.triangle as usize).double_sided
}

/// A point of a surface, moved off it, and the surface's unit normal there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outpost {
    pub(crate) origin: Vec3,
    pub(crate) normal: Vec3,
}

impl Outpost {
    /// The end of a ray.
    fn at_end(tracer: &Tracer, ray: &Ray, hit: &Hit) -> Self {
        let position = ray.origin + ray.direction * hit.distance;
        Self { origin: tracer.off_surface(position, hit.normal), normal: hit.normal }
    }
}

/// Where a walk from a point leads.
#[derive(Clone, Copy, Debug, PartialEq)]
enum WalkEnd {
    Light,
    /// At the first step: the inside of a solid.
    Solid,
    Nowhere,
}

/// The surveyed air of a scene.
pub(crate) struct Air<'a> {
    tracer: &'a Tracer,
    /// Edge of the voxels, metres: the width of the narrowest space that is found.
    voxel: f32,
    surveys: Vec<Survey>,
    open: PointTree,
}

impl<'a> Air<'a> {
    /// Surveys the empty voxels within `reach` voxels of a surface.
    pub(crate) fn survey(
        tracer: &'a Tracer,
        voxel: f32,
        reach: u32,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let places = VoxelGrid::new(tracer.scene(), voxel).empty_near_surfaces(reach);
        let look = |(position, is_outside)| Survey::of(tracer, position, is_outside);
        let surveys = for_each_in_parallel("surveying the air", places.into_par_iter(), progress, look)?;
        let open: Vec<Vec3> =
            surveys.iter().filter(|survey| survey.is_open()).map(|survey| survey.position).collect();
        Ok(Self { tracer, voxel, surveys, open: PointTree::of(&open) })
    }

    /// The tracer of the scene.
    pub(crate) fn tracer(&self) -> &'a Tracer {
        self.tracer
    }

    /// Places that see surfaces, most of them lit: where light may be measured.
    pub(crate) fn places_for_probes(&self, lit_sides: &LitSides) -> Vec<Survey> {
        let sees_light = |survey: &&Survey| {
            // Few back faces, few unlit sides: fronts that are unlit are buried.
            survey.back_share <= MAX_UNLIT_SHARE || {
                let hits = look_around(self.tracer, survey.position);
                is_lit_enough(unlit_hits(&hits, lit_sides))
            }
        };
        let sees_surface = |survey: &&Survey| survey.clearance.is_finite();
        self.surveys.par_iter().filter(sees_surface).filter(sees_light).copied().collect()
    }

    /// What a place sees, if that is light: surfaces most of which are lit, or the sky.
    pub(crate) fn place_for_light(&self, position: Vec3, lit_sides: &LitSides) -> Option<Survey> {
        let hits = self.hits_of_lit_place(position, lit_sides)?;
        Some(Survey::of_hits(self.tracer, position, false, &hits))
    }

    /// What is around a place, if light is there. Emitters count as no nearer than `nearest` (metres).
    pub(crate) fn surroundings(
        &self,
        position: Vec3,
        lit_sides: &LitSides,
        nearest: f32,
    ) -> Option<Surroundings> {
        let hits = self.hits_of_lit_place(position, lit_sides)?;
        let distances = sorted_distances(&hits);
        let extent = distances[(EXTENT_SHARE * PLACE_RAYS as f32) as usize];
        let mut seen = Surroundings { extent, emission: 0.0, emission_change: 0.0 };
        for hit in hits.iter().flatten().filter(|hit| self.is_emissive(hit)) {
            let emission =
                luminance(self.tracer.scene().material(hit.triangle as usize).emission) / PLACE_RAYS as f32;
            seen.emission += emission;
            seen.emission_change += emission * hit.distance.max(nearest).powi(-2);
        }
        Some(seen)
    }

    /// What the rays of a place meet, if that is light.
    fn hits_of_lit_place(&self, position: Vec3, lit_sides: &LitSides) -> Option<Vec<Option<Hit>>> {
        // Most places inside solids are told by a few rays.
        let scouts = rays_around(position).step_by(PLACE_RAYS / FIRST_PLACE_RAYS);
        let scouted: Vec<Option<Hit>> = scouts.map(|ray| self.tracer.closest_hit(&ray)).collect();
        if unlit_hits(&scouted, lit_sides) > FIRST_PLACE_RAYS / 2 {
            return None;
        }
        let hits = look_around(self.tracer, position);
        let unlit = unlit_hits(&hits, lit_sides);
        is_lit_enough(unlit).then_some(hits)
    }

    /// Whether a point of a surface is in sight of open air, at once or by way of other surfaces.
    pub(crate) fn is_open(&self, point: &Outpost, seed: u32) -> bool {
        self.sees(point) || self.lit_walks(point, seed) >= FEWEST_LIT_WALKS
    }

    /// Whether a point of a surface is in sight of open air.
    pub(crate) fn sees(&self, point: &Outpost) -> bool {
        let faces = |place: Vec3| {
            let offset = place - point.origin;
            offset.dot(point.normal) >= SMALLEST_COSINE * offset.length()
        };
        self.open.nearest_visible(self.tracer, point.origin, PLACES_TRIED, faces).next().is_some()
    }

    /// How many walks over surfaces lead from a point to the sky, to an emissive face or into sight of open air; no more
    /// are counted than are asked for.
    fn lit_walks(&self, point: &Outpost, seed: u32) -> u32 {
        let (mut in_solid, mut lit) = (0, 0);
        for walk in 0..WALKS {
            match self.walk(point, walk, seed) {
                WalkEnd::Light => lit += 1,
                WalkEnd::Solid => in_solid += 1,
                WalkEnd::Nowhere => {}
            }
            let is_in_solid = in_solid == FIRST_WALKS && walk + 1 == FIRST_WALKS;
            if lit == FEWEST_LIT_WALKS || is_in_solid {
                break;
            }
        }
        lit
    }

    fn walk(&self, start: &Outpost, walk: u32, seed: u32) -> WalkEnd {
        let mut at = *start;
        for step in 0..STEPS_PER_WALK {
            let local = cosine_hemisphere_from_square(sobol_owen(walk, hash_pair(seed, step)));
            let ray = Ray::new(at.origin, world_from_tangent(at.normal) * local);
            let Some(hit) = self.tracer.closest_hit(&ray) else { return WalkEnd::Light };
            if is_inside_of_solid(self.tracer, &hit) {
                return if step == 0 { WalkEnd::Solid } else { WalkEnd::Nowhere };
            }
            at = Outpost::at_end(self.tracer, &ray, &hit);
            if self.is_emissive(&hit) || self.sees(&at) {
                return WalkEnd::Light;
            }
        }
        WalkEnd::Nowhere
    }

    fn is_emissive(&self, hit: &Hit) -> bool {
        !hit.is_back_face && self.tracer.scene().material(hit.triangle as usize).emission != Vec3::ZERO
    }

    /// A warning if most of the scene looks like the inside of solids.
    pub(crate) fn warning(&self) -> Option<Warning> {
        let bounds = self.tracer.scene().bounds();
        let inside = || self.surveys.iter().filter(|survey| bounds.contains(survey.position));
        let solid = inside().filter(|survey| !survey.is_open()).count();
        (solid as f32 > MAX_SOLID_SHARE * inside().count() as f32).then(|| Warning {
            message: format!(
                "{solid} places in closed spaces show back faces only and stay dark; if this is a room seen from \
                 within, turn its faces round or make its materials double-sided"
            ),
            count: 1,
        })
    }
}
