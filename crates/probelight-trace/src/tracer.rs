//! The ray tracer: closest hits and visibility, with alpha-masked surfaces tested by their alpha.

use std::sync::Arc;

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{AlphaMode, Scene};

use crate::wide_bvh::{Query, WideBvh};

/// A ray segment in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, metres.
    pub origin: Vec3,
    /// Direction; distances are multiples of its length (unit unless stated otherwise).
    pub direction: Vec3,
    /// Farthest distance.
    pub max_distance: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, max_distance: f32::INFINITY }
    }

    /// Whether start and direction are numbers; rays that have none hit nothing, and would not end.
    #[inline]
    fn is_finite(&self) -> bool {
        (self.origin + self.direction).is_finite()
    }
}

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub distance: f32,
    /// Triangle index in the scene.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: Vec2,
    /// Unit geometric normal, on the side the ray came from.
    pub normal: Vec3,
    /// Whether the ray met the triangle's back face.
    pub is_back_face: bool,
}

/// A scene prepared for ray queries. Cheap to share between threads.
pub struct Tracer {
    scene: Arc<Scene>,
    bvh: WideBvh,
    /// Unit geometric normals of the triangles.
    normals: Vec<Vec3>,
    /// Whether any triangle must be tested by alpha.
    has_masked: bool,
    offset: f32,
}

/// Ray origins leave the surface by this share of the scene's diagonal (as the ground truth does).
const OFFSET_PER_DIAGONAL: f32 = 1e-5;

/// But by this share of the largest coordinate at least, so that rounding does not put them behind the surface: two to
/// four steps of an `f32`. It counts in scenes that lie farther from the origin than 40 times their diagonal.
const OFFSET_PER_COORDINATE: f32 = 2.0 * f32::EPSILON;

impl std::fmt::Debug for Tracer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tracer").field("triangles", &self.scene.triangles.len()).finish_non_exhaustive()
    }
}

impl Tracer {
    /// Builds the BVH of a valid scene.
    pub fn new(scene: Arc<Scene>) -> Self {
        let corners: Vec<[Vec3; 3]> = (0..scene.triangles.len()).map(|t| scene.corners(t)).collect();
        let bvh = WideBvh::new(&corners);
        let normals = (0..scene.triangles.len()).map(|t| scene.geometric_normal(t)).collect();
        let masked = |t| matches!(scene.material(t).alpha_mode, AlphaMode::Mask { .. });
        let has_masked = (0..scene.triangles.len()).any(masked);
        let bounds = scene.bounds();
        let largest_coordinate = bounds.min.abs().max(bounds.max.abs()).max_element();
        let offset =
            (OFFSET_PER_DIAGONAL * bounds.diagonal()).max(OFFSET_PER_COORDINATE * largest_coordinate);
        Self { scene, bvh, normals, has_masked, offset }
    }

    /// The scene the rays meet.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// How far ray origins are moved off a surface along its normal, metres: 1e-5 of the scene's diagonal, or what
    /// rounding makes of it far from the origin.
    pub fn offset(&self) -> f32 {
        self.offset
    }

    /// Where rays from a point of a surface start: moved off it by [`Self::offset`] towards `normal` (unit).
    #[must_use]
    #[inline]
    pub fn off_surface(&self, position: Vec3, normal: Vec3) -> Vec3 {
        position + normal * self.offset
    }

    /// Unit geometric normal of a triangle's front face.
    pub fn front_normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    /// Unit geometric normal of one side of a triangle.
    #[inline]
    pub fn side_normal(&self, triangle: u32, is_back_face: bool) -> Vec3 {
        let front = self.front_normal(triangle);
        if is_back_face { -front } else { front }
    }

    /// The nearest hit along the ray, or `None` if it leaves the scene.
    #[inline]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if !ray.is_finite() {
            return None;
        }
        let query = Query::new(ray.origin, ray.direction, ray.max_distance);
        let nearest = self.bvh.closest_hit(&query, |triangle, at| self.is_solid(triangle, at))?;
        let normal = self.normals[nearest.triangle as usize];
        let is_back_face = normal.dot(ray.direction) > 0.0;
        Some(Hit {
            distance: nearest.distance,
            triangle: nearest.triangle,
            barycentric: nearest.barycentric,
            normal: if is_back_face { -normal } else { normal },
            is_back_face,
        })
    }

    /// Whether anything lies on the ray before its end.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        let query = Query::new(ray.origin, ray.direction, ray.max_distance);
        ray.is_finite() && self.bvh.is_occluded(&query, |triangle, at| self.is_solid(triangle, at))
    }

    /// Whether the straight line between two points is free. Both ends should already be off their
    /// surfaces.
    #[inline]
    pub fn is_visible(&self, from: Vec3, to: Vec3) -> bool {
        let direction = to - from;
        !self.is_occluded(&Ray { origin: from, direction, max_distance: 1.0 })
    }

    /// Whether there is surface, and no hole of a masked material, at a point of a triangle.
    #[inline(always)]
    fn is_solid(&self, triangle: u32, barycentric: Vec2) -> bool {
        !self.has_masked || self.passes_alpha_test(triangle as usize, barycentric)
    }

    #[cold]
    fn passes_alpha_test(&self, triangle: usize, barycentric: Vec2) -> bool {
        let material = self.scene.material(triangle);
        let AlphaMode::Mask { cutoff } = material.alpha_mode else { return true };
        material.base_color.w * self.scene.base_color_texel(triangle, barycentric).w >= cutoff
    }
}
