//! The ray tracer: closest hits and visibility, with alpha-masked surfaces tested by their alpha.

use std::sync::Arc;
use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use probelight_math::glam::{Vec2, Vec3, Vec3A};
use probelight_scene::{AlphaMode, Scene};

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
    bvh: CwBvh,
    /// Triangles in the order of the BVH's leaves.
    leaf_triangles: Vec<RtTriangle>,
    /// Unit geometric normals by scene index.
    normals: Vec<Vec3>,
    /// Whether each triangle, by scene index, must be tested by alpha; empty if none.
    alpha_tested: Vec<bool>,
    offset: f32,
}

/// Ray origins leave the surface by this share of the scene's diagonal (as the ground truth does).
const OFFSET_PER_DIAGONAL: f32 = 1e-5;

impl Tracer {
    /// Builds the BVH of a valid scene.
    pub fn new(scene: Arc<Scene>) -> Self {
        let triangles: Vec<Triangle> = (0..scene.triangles.len())
            .map(|t| {
                let [v0, v1, v2] = scene.corners(t).map(Vec3A::from);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::slow_build(), &mut Duration::default());
        let leaf_triangles = bvh.primitive_indices.iter().map(|t| (&triangles[*t as usize]).into()).collect();
        let normals = (0..scene.triangles.len()).map(|t| scene.geometric_normal(t)).collect();
        let masked = |t| matches!(scene.material(t).alpha_mode, AlphaMode::Mask { .. });
        let alpha_tested = if (0..scene.triangles.len()).any(masked) {
            (0..scene.triangles.len()).map(masked).collect()
        } else {
            Vec::new()
        };
        let offset = scene.bounds().diagonal() * OFFSET_PER_DIAGONAL;
        Self { scene, bvh, leaf_triangles, normals, alpha_tested, offset }
    }

    /// The scene the rays meet.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// How far ray origins are moved off a surface along its normal, metres: 1e-5 of the scene's diagonal.
    pub fn offset(&self) -> f32 {
        self.offset
    }

    /// Unit geometric normal of a triangle's front face.
    pub fn front_normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    /// The nearest hit along the ray, or `None` if it leaves the scene.
    #[inline]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let query = query_from_ray(ray);
        let mut nearest = RayHit::none();
        let found = self.bvh.ray_traverse(query, &mut nearest, |query, leaf| self.intersect(query, leaf));
        if !found {
            return None;
        }
        let triangle = self.bvh.primitive_indices[nearest.primitive_id as usize];
        let barycentric = self.leaf_triangles[nearest.primitive_id as usize].compute_barycentric(&query);
        let normal = self.normals[triangle as usize];
        let is_back_face = normal.dot(ray.direction) > 0.0;
        Some(Hit {
            distance: nearest.t,
            triangle,
            barycentric,
            normal: if is_back_face { -normal } else { normal },
            is_back_face,
        })
    }

    /// Whether anything lies on the ray before its end.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        let query = query_from_ray(ray);
        !self.bvh.ray_traverse_miss(query, |query, leaf| self.intersect(query, leaf))
    }

    /// Whether the straight line between two points is free. Both ends should already be off their
    /// surfaces.
    #[inline]
    pub fn is_visible(&self, from: Vec3, to: Vec3) -> bool {
        let direction = to - from;
        !self.is_occluded(&Ray { origin: from, direction, max_distance: 1.0 })
    }

    /// Distance along the ray to a leaf's triangle; infinite for a miss or a hole in a masked surface.
    #[inline(always)]
    fn intersect(&self, ray: &obvhs::ray::Ray, leaf: usize) -> f32 {
        let distance = self.leaf_triangles[leaf].intersect(ray);
        if !self.alpha_tested.is_empty() && distance < f32::INFINITY && self.is_hole(ray, leaf) {
            return f32::INFINITY;
        }
        distance
    }

    #[cold]
    fn is_hole(&self, ray: &obvhs::ray::Ray, leaf: usize) -> bool {
        let triangle = self.bvh.primitive_indices[leaf] as usize;
        if !self.alpha_tested[triangle] {
            return false;
        }
        let material = self.scene.material(triangle);
        let AlphaMode::Mask { cutoff } = material.alpha_mode else { return false };
        let barycentric = self.leaf_triangles[leaf].compute_barycentric(ray);
        let alpha = material.base_color.w * self.scene.base_color_texel(triangle, barycentric).w;
        alpha < cutoff
    }
}

/// The BVH's form of a ray. Adding zero turns −0 into +0: the traversal takes the sign of the direction and
/// of its inverse separately, and misses boxes where the two disagree.
#[inline(always)]
fn query_from_ray(ray: &Ray) -> obvhs::ray::Ray {
    let direction = Vec3A::from(ray.direction) + Vec3A::ZERO;
    obvhs::ray::Ray::new(ray.origin.into(), direction, 0.0, ray.max_distance)
}
