//! Which sides of the triangles have light of their own.
//!
//! Light meets both sides of every surface, but the insides of closed solids are never seen and must not
//! cost receivers; and a place from which many such sides are seen lies inside a solid. Whether a material
//! is double-sided does not tell, since whole scenes are exported so. What tells is open air: the empty
//! voxels of the scene that do not look like the inside of a solid.
//!
//! - A front face, or either face of a double-sided material, is lit if it is in sight of open air, at once
//!   or by way of a surface point that is, or in sight of an emissive face (the inside of a lamp's housing).
//! - The back face of a single-sided material is lit if a lit place sees it (a house modelled as single
//!   sheets, seen from the street); that nobody sees it from the front is the usual case.

use std::sync::atomic::{AtomicBool, Ordering};

use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::Vec3;
use probelight_math::sampling::{
    Rng, cosine_hemisphere_from_square, hash_pair, sobol_owen, triangle_from_square, world_from_tangent,
};
use probelight_trace::{Hit, Ray, Tracer};
use rayon::prelude::*;

use crate::point_grid::PointGrid;
use crate::surface_samples::{SurfaceSample, sample_front_faces};
use crate::voxels::VoxelGrid;

/// Rays from each voxel, and the share of them that may meet back faces of single-sided materials before
/// an enclosed voxel counts as the inside of a solid.
const VOXEL_RAYS: usize = 64;
const MAX_BACK_SHARE: f32 = 0.25;

/// Places in open air tried for sight of a point, nearest first.
const PLACES_TRIED: usize = 12;

/// Points on a side, rays from each, and how many of all these rays must reach the sky, emissive faces or
/// points in sight of open air.
const POINTS: u32 = 4;
const RAYS_PER_POINT: u32 = 24;
const FEWEST_LIT_RAYS: u32 = 3;

/// Points from which back faces are looked for, rays from each, and how many times back faces found this
/// way look for further ones (round the corners of a house).
const VIEWERS: usize = 16_384;
const RAYS_PER_VIEWER: u32 = 64;
const GENERATIONS: usize = 2;

/// The lit sides of a scene.
#[derive(Clone, Debug)]
pub(crate) struct LitSides {
    front: Vec<bool>,
    back: Vec<bool>,
}

impl LitSides {
    /// Finds the lit sides; `voxel_size` (metres) is the smallest width of an open space that counts.
    pub(crate) fn find(tracer: &Tracer, voxel_size: f32, seed: u64) -> Self {
        let air = OpenAir::find(tracer, voxel_size);
        let scene = tracer.scene();
        let all = 0..scene.triangles.len();
        let front = all.clone().into_par_iter().map(|t| air.reaches(t, false)).collect();
        let back =
            all.into_par_iter().map(|t| scene.material(t).double_sided && air.reaches(t, true)).collect();
        let mut sides = Self { front, back };
        let mut viewers = sample_front_faces(scene, VIEWERS, &mut Rng::new(seed, 1));
        for _ in 0..GENERATIONS {
            viewers = sides.add_seen_back_faces(&air, &viewers);
        }
        sides
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

    /// Lights the back faces that viewers in open air see; returns points on them as the next viewers.
    fn add_seen_back_faces(&mut self, air: &OpenAir<'_>, viewers: &[SurfaceSample]) -> Vec<SurfaceSample> {
        let seen: Vec<AtomicBool> = self.back.iter().map(|lit| AtomicBool::new(*lit)).collect();
        let found: Vec<Option<SurfaceSample>> = viewers
            .par_iter()
            .enumerate()
            .map(|(i, viewer)| {
                let hits = self.unlit_back_faces_seen(air, viewer, i as u32);
                for (triangle, _) in &hits {
                    seen[*triangle as usize].store(true, Ordering::Relaxed);
                }
                hits.first().map(|(_, sample)| *sample)
            })
            .collect();
        self.back = seen.into_iter().map(AtomicBool::into_inner).collect();
        found.into_iter().flatten().collect()
    }

    fn unlit_back_faces_seen(
        &self,
        air: &OpenAir<'_>,
        viewer: &SurfaceSample,
        index: u32,
    ) -> Vec<(u32, SurfaceSample)> {
        let origin = viewer.position + viewer.normal * air.tracer.offset();
        if !air.sees(origin) {
            return Vec::new();
        }
        let world_from_local = world_from_tangent(viewer.normal);
        (0..RAYS_PER_VIEWER)
            .filter_map(|ray| {
                let local = cosine_hemisphere_from_square(sobol_owen(ray, hash_pair(index, 91)));
                let direction = world_from_local * local;
                let hit = air.tracer.closest_hit(&Ray::new(origin, direction))?;
                let position = origin + direction * hit.distance;
                (hit.is_back_face
                    && !self.is_lit(&hit)
                    && air.sees(position + hit.normal * air.tracer.offset()))
                .then_some((hit.triangle, SurfaceSample { position, normal: hit.normal }))
            })
            .collect()
    }
}

/// Places known to be in open air.
struct OpenAir<'a> {
    tracer: &'a Tracer,
    places: PointGrid,
}

impl<'a> OpenAir<'a> {
    /// Centres of the empty voxels near surfaces, without those inside solids.
    fn find(tracer: &'a Tracer, voxel_size: f32) -> Self {
        let candidates = VoxelGrid::new(tracer.scene(), voxel_size).empty_near_surfaces(2);
        let places: Vec<Vec3> = candidates
            .par_iter()
            .filter(|(position, is_outside)| *is_outside || back_share(tracer, *position) <= MAX_BACK_SHARE)
            .map(|(position, _)| *position)
            .collect();
        Self { tracer, places: PointGrid::of(&places, voxel_size) }
    }

    /// Whether a point (already off its surface) is in sight of open air.
    fn sees(&self, point: Vec3) -> bool {
        let near = self.places.nearest(point, PLACES_TRIED);
        near.into_iter().any(|p| self.tracer.is_visible(point, self.places.positions[p as usize]))
    }

    fn is_emissive(&self, hit: &Hit) -> bool {
        !hit.is_back_face && self.tracer.scene().material(hit.triangle as usize).emission != Vec3::ZERO
    }

    /// Whether a side is in sight of open air, or of enough surface points that shine or are.
    fn reaches(&self, triangle: usize, is_back: bool) -> bool {
        let normal = self.tracer.side_normal(triangle as u32, is_back);
        let origins: Vec<Vec3> = (0..POINTS)
            .map(|point| {
                let at = triangle_from_square(sobol_owen(point, hash_pair(triangle as u32, 40)));
                self.tracer.scene().position(triangle, at) + normal * self.tracer.offset()
            })
            .collect();
        if origins.iter().any(|origin| self.sees(*origin)) {
            return true;
        }
        let world_from_local = world_from_tangent(normal);
        let mut lit_rays = 0;
        for (point, origin) in origins.into_iter().enumerate() {
            for ray in 0..RAYS_PER_POINT {
                let u = sobol_owen(ray, hash_pair(triangle as u32, 41 + point as u32));
                let ray = Ray::new(origin, world_from_local * cosine_hemisphere_from_square(u));
                let is_lit = self.tracer.closest_hit(&ray).is_none_or(|hit| {
                    let end = ray.origin + ray.direction * hit.distance + hit.normal * self.tracer.offset();
                    self.is_emissive(&hit) || self.sees(end)
                });
                lit_rays += u32::from(is_lit);
                if lit_rays >= FEWEST_LIT_RAYS {
                    return true;
                }
            }
        }
        false
    }
}

/// Share of directions in which a place sees back faces of single-sided materials.
fn back_share(tracer: &Tracer, position: Vec3) -> f32 {
    let is_wrong_side = |ray: &usize| {
        let direction = spherical_fibonacci(*ray, VOXEL_RAYS);
        tracer.closest_hit(&Ray::new(position, direction)).is_some_and(|hit| {
            hit.is_back_face && !tracer.scene().material(hit.triangle as usize).double_sided
        })
    };
    (0..VOXEL_RAYS).filter(is_wrong_side).count() as f32 / VOXEL_RAYS as f32
}
