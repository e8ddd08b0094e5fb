//! Which sides of the triangles have light of their own.
//!
//! - A front face, or either face of a double-sided material, is lit if any point of it is open. Points are tried
//!   inside it, in its corners and along its edges: what other solids leave free of a face touches one of these,
//!   however thin the rim.
//! - The back face of a single-sided material is lit if it is in sight of open air and sees a lit place (a house
//!   modelled as single sheets, seen from the street); that nobody sees it is the usual case.

use std::collections::BTreeMap;

use probelight_math::glam::Vec2;
use probelight_math::sampling::{
    cosine_hemisphere_from_square, hash_pair, sobol_owen, triangle_from_square, world_from_tangent,
};
use probelight_trace::{Hit, Progress, Ray, Tracer};
use rayon::prelude::*;

use super::{Air, Outpost, is_inside_of_solid};
use crate::BakeError;
use crate::air::limits::{
    FEWEST_LIT_WALKS, FIRST_POINTS, FIRST_WALKS, GENERATIONS, INSETS, MOST_POINTS, MOST_SCOUTS,
    POINTS_PER_EDGE, WALKS,
};
use crate::steps::for_each_in_parallel;

/// The lit sides of a scene.
#[derive(Clone, Debug)]
pub(crate) struct LitSides {
    front: Vec<bool>,
    back: Vec<bool>,
    /// Open points of sides that are mostly hidden, by triangle and whether it is the back: barycentric weights of
    /// the second and third corner.
    rims: BTreeMap<(u32, bool), Vec<Vec2>>,
}

/// How much of a side is lit.
enum Light {
    None,
    /// At least where points are bound to find it.
    Wide,
    /// At these points only.
    Rim(Vec<Vec2>),
}

impl LitSides {
    /// Finds the lit sides.
    pub(crate) fn find(air: &Air<'_>, progress: &dyn Progress) -> Result<Self, BakeError> {
        let scene = air.tracer.scene();
        let sides = (0..scene.triangles.len() as u32).flat_map(|t| {
            let sides = if scene.material(t as usize).double_sided { 2 } else { 1 };
            [(t, false), (t, true)].into_iter().take(sides)
        });
        let sides: Vec<(u32, bool)> = sides.collect();
        let light = |side: (u32, bool)| (side, Side::new(air, side.0, side.1).light());
        let lights =
            for_each_in_parallel("looking for lit surfaces", sides.into_par_iter(), progress, light)?;
        let dark = vec![false; scene.triangles.len()];
        let mut sides = Self { front: dark.clone(), back: dark, rims: BTreeMap::new() };
        for (side, light) in lights {
            let lit = if side.1 { &mut sides.back } else { &mut sides.front };
            lit[side.0 as usize] = !matches!(light, Light::None);
            if let Light::Rim(points) = light {
                sides.rims.insert(side, points);
            }
        }
        for _ in 0..GENERATIONS {
            sides.light_seen_back_faces(air, progress)?;
        }
        Ok(sides)
    }

    /// Whether the front face of a triangle is lit.
    pub(crate) fn front(&self, triangle: usize) -> bool {
        self.front[triangle]
    }

    /// Whether the back face of a triangle is lit.
    pub(crate) fn back(&self, triangle: usize) -> bool {
        self.back[triangle]
    }

    /// Whether the side that a ray met is lit.
    pub(crate) fn is_lit(&self, hit: &Hit) -> bool {
        let sides = if hit.is_back_face { &self.back } else { &self.front };
        sides[hit.triangle as usize]
    }

    /// Known open points of a side that is mostly hidden.
    pub(crate) fn rim(&self, triangle: u32, is_back: bool) -> &[Vec2] {
        self.rims.get(&(triangle, is_back)).map_or(&[], Vec::as_slice)
    }

    /// Lights the back faces of single-sided materials that lit places see.
    fn light_seen_back_faces(&mut self, air: &Air<'_>, progress: &dyn Progress) -> Result<(), BakeError> {
        let scene = air.tracer.scene();
        let is_seen = |t: usize| {
            self.back[t]
                || (!scene.material(t).double_sided && Side::new(air, t as u32, true).sees_lit_place(self))
        };
        let triangles = (0..scene.triangles.len()).into_par_iter();
        self.back = for_each_in_parallel("looking for lit back faces", triangles, progress, is_seen)?;
        Ok(())
    }
}

/// A side of a triangle whose light is looked for.
struct Side<'a> {
    air: &'a Air<'a>,
    triangle: u32,
    is_back: bool,
}

impl<'a> Side<'a> {
    fn new(air: &'a Air<'_>, triangle: u32, is_back: bool) -> Self {
        Self { air, triangle, is_back }
    }

    fn tracer(&self) -> &'a Tracer {
        self.air.tracer
    }

    fn light(&self) -> Light {
        let first = || (0..FIRST_POINTS).map(|i| self.inner_point(i));
        let seeds = hash_pair(2 * self.triangle + u32::from(self.is_back), 41);
        let seed = |i: u32| hash_pair(seeds, i);
        let walks = |(i, point): &(u32, Vec2)| self.air.lit_walks(&self.outpost(*point), seed(*i));
        let sees = |point: Vec2| self.air.sees(&self.outpost(point));
        if first().any(sees) {
            return Light::Wide;
        }
        let most = (0..).zip(first()).map(|point| walks(&point)).max().unwrap_or(0);
        if most >= FEWEST_LIT_WALKS {
            return Light::Wide;
        }
        let others = self.rim_points().into_iter().chain(self.further_points());
        let others: Vec<(u32, Vec2)> = (FIRST_POINTS..).zip(others).collect();
        // Walks cost far more than looking around: where those of scouts are all in vain, others would be too.
        let mut scouts = others.iter().step_by(others.len().div_ceil(MOST_SCOUTS));
        let is_near_light = most > 0 || scouts.any(|point| walks(point) > 0);
        let is_open = |(i, point): &(u32, Vec2)| match is_near_light {
            true => self.air.is_open(&self.outpost(*point), seed(*i)),
            false => sees(*point),
        };
        let open: Vec<Vec2> = others.into_iter().filter(is_open).map(|(_, point)| point).collect();
        if open.is_empty() { Light::None } else { Light::Rim(open) }
    }

    /// Whether open air and a lit place see some point of the side.
    fn sees_lit_place(&self, lit: &LitSides) -> bool {
        let corners = corner_points(INSETS[0]);
        let further = self.further_points().into_iter();
        let first = (0..FIRST_POINTS).map(|i| self.inner_point(i));
        (0..).zip(first.chain(corners).chain(further)).any(|(i, point)| {
            let outpost = self.outpost(point);
            let frame = world_from_tangent(outpost.normal);
            let seed = hash_pair(2 * self.triangle + u32::from(self.is_back), i);
            let look = |walk: u32| {
                let local = cosine_hemisphere_from_square(sobol_owen(walk, seed));
                let ray = Ray::new(outpost.origin, frame * local);
                Some((ray, self.tracer().closest_hit(&ray)?))
            };
            let is_lit = |(ray, hit): (Ray, Hit)| {
                lit.is_lit(&hit) && self.air.sees(&Outpost::at_end(self.tracer(), &ray, &hit))
            };
            let is_solid = |walk| {
                look(walk)
                    .is_some_and(|(_, hit)| !lit.is_lit(&hit) && is_inside_of_solid(self.tracer(), &hit))
            };
            !(0..FIRST_WALKS).all(is_solid)
                && self.air.sees(&outpost)
                && (0..WALKS).filter_map(look).any(is_lit)
        })
    }

    fn outpost(&self, point: Vec2) -> Outpost {
        let normal = self.tracer().side_normal(self.triangle, self.is_back);
        let position = self.tracer().scene().position(self.triangle as usize, point);
        Outpost { origin: self.tracer().off_surface(position, normal), normal }
    }

    fn inner_point(&self, i: u32) -> Vec2 {
        triangle_from_square(sobol_owen(i, hash_pair(self.triangle, 40)))
    }

    fn further_points(&self) -> Vec<Vec2> {
        let squares = self.tracer().scene().area(self.triangle as usize) * (4.0 / self.air.voxel).powi(2);
        let count = squares.min(MOST_POINTS) as u32;
        (FIRST_POINTS..FIRST_POINTS.max(count)).map(|i| self.inner_point(i)).collect()
    }

    /// Points in the corners and along the edges.
    fn rim_points(&self) -> Vec<Vec2> {
        let corners = self.tracer().scene().corners(self.triangle as usize);
        let mut points: Vec<Vec2> = INSETS.into_iter().flat_map(corner_points).collect();
        for i in 0..3 {
            let length = corners[i].distance(corners[(i + 1) % 3]);
            let [fewest, most] = POINTS_PER_EDGE;
            let count = (8.0 * length / self.air.voxel).clamp(fewest, most) as u32;
            for k in 0..count {
                let along = CORNERS[i].lerp(CORNERS[(i + 1) % 3], (k as f32 + 0.5) / count as f32);
                points.extend(INSETS.map(|inset| along.lerp(CORNERS[(i + 2) % 3], inset)));
            }
        }
        points
    }
}

/// Barycentric weights (of the second and third corner) of the corners.
const CORNERS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// Points in the three corners, `inset` of the way to the middle.
fn corner_points(inset: f32) -> [Vec2; 3] {
    CORNERS.map(|corner| corner.lerp(Vec2::splat(1.0 / 3.0), inset))
}
