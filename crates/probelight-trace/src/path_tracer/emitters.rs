//! Sampling points on emissive triangles.

use probelight_math::glam::{Vec2, Vec3, vec2};
use probelight_math::sampling::{choose_by_running_sum, triangle_from_square};
use probelight_scene::Scene;

/// Emissive triangles, chosen with probability proportional to their power (area times mean emission of the
/// three channels), uniformly within a triangle.
pub(super) struct Emitters {
    /// Scene indices of the triangles that emit.
    triangles: Vec<u32>,
    /// Running sum of the probabilities of `triangles`; the last is 1.
    cumulative: Vec<f32>,
    /// Probability density per area (1/m²) on the surfaces of each material.
    density: Vec<f32>,
}

/// A point on an emissive triangle.
pub(super) struct EmitterPoint {
    pub(super) triangle: u32,
    pub(super) barycentric: Vec2,
    pub(super) position: Vec3,
    /// Probability density per area, 1/m².
    pub(super) density: f32,
}

impl Emitters {
    /// Collects what emits in `scene`; nothing does if `emissive_scale` is 0.
    pub(super) fn new(scene: &Scene, emissive_scale: f32) -> Self {
        let strength = |emission: Vec3| f64::from((emission * emissive_scale).max(Vec3::ZERO).element_sum());
        let power =
            |t: u32| f64::from(scene.area(t as usize)) * strength(scene.material(t as usize).emission);
        let triangles: Vec<u32> = (0..scene.triangles.len() as u32).filter(|t| power(*t) > 0.0).collect();
        let total: f64 = triangles.iter().map(|t| power(*t)).sum();
        let mut running = 0.0;
        let cumulative = triangles
            .iter()
            .map(|t| {
                running += power(*t);
                (running / total) as f32
            })
            .collect();
        let share = |emission| if triangles.is_empty() { 0.0 } else { (strength(emission) / total) as f32 };
        let density = scene.materials.iter().map(|material| share(material.emission)).collect();
        Self { triangles, cumulative, density }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Probability density per area (1/m²) with which [`Self::sample`] returns a point of `triangle`.
    #[inline]
    pub(super) fn density(&self, scene: &Scene, triangle: u32) -> f32 {
        self.density[scene.triangle_material[triangle as usize] as usize]
    }

    /// Maps a point of the unit square to a point on an emitter. There must be one.
    #[inline]
    pub(super) fn sample(&self, scene: &Scene, u: Vec2) -> EmitterPoint {
        let (chosen, rest) = choose_by_running_sum(&self.cumulative, u.x);
        let triangle = self.triangles[chosen];
        let barycentric = triangle_from_square(vec2(rest, u.y));
        let position = scene.position(triangle as usize, barycentric);
        EmitterPoint { triangle, barycentric, position, density: self.density(scene, triangle) }
    }
}
