//! Points that rays start from, and how these weigh directions.

use std::f32::consts::PI;

use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, world_from_tangent};
use probelight_trace::Tracer;

use crate::air::Outpost;

/// A point of a surface. There are millions: what follows from its triangle is not stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SurfacePoint {
    pub(crate) triangle: u32,
    /// Barycentric weights of the second and third corner.
    pub(crate) barycentric: Vec2,
    /// Whether it lies on the triangle's back face.
    pub(crate) is_back_face: bool,
    /// How much of what leaves the point gets away from the surface, percent; at least one. What lies under
    /// a carpet or behind a panel is surface, but hardly anything sees it.
    pub(crate) exposure: u8,
}

impl SurfacePoint {
    /// World position, metres.
    pub(crate) fn position(&self, tracer: &Tracer) -> Vec3 {
        tracer.scene().position(self.triangle as usize, self.barycentric)
    }

    /// Unit geometric normal on its side.
    pub(crate) fn normal(&self, tracer: &Tracer) -> Vec3 {
        tracer.side_normal(self.triangle, self.is_back_face)
    }

    /// The point, moved off its surface.
    pub(crate) fn outpost(&self, tracer: &Tracer) -> Outpost {
        let normal = self.normal(tracer);
        Outpost { origin: tracer.off_surface(self.position(tracer), normal), normal }
    }
}

/// A point that a site's rays start from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SamplePoint {
    /// Where they start, metres: off any surface.
    pub(crate) origin: Vec3,
    /// How light that meets the point is weighed.
    pub(crate) lobe: Lobe,
}

impl SamplePoint {
    /// On a surface.
    pub(crate) fn on_surface(tracer: &Tracer, point: &SurfacePoint) -> Self {
        let Outpost { origin, normal } = point.outpost(tracer);
        Self { origin, lobe: Lobe::cosine(normal) }
    }
}

/// How a place weighs the light that comes from each direction: by Lambert's cosine. All that draws or weighs directions
/// asks here, so a place in free space needs no more than a lobe of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobe {
    normal: Vec3,
}

impl Lobe {
    /// Integral over all directions, steradians.
    pub(crate) const TOTAL: f32 = PI;

    /// Of a surface with a unit normal.
    pub(crate) fn cosine(normal: Vec3) -> Self {
        Self { normal }
    }

    /// A unit direction drawn in proportion to the lobe, and its value there.
    pub(crate) fn draw(&self, u: Vec2) -> (Vec3, f32) {
        let local = cosine_hemisphere_from_square(u);
        (world_from_tangent(self.normal) * local, local.z.max(f32::MIN_POSITIVE))
    }

    /// Its value along a unit direction; not above zero where it takes no light from.
    pub(crate) fn value(&self, direction: Vec3) -> f32 {
        self.normal.dot(direction)
    }
}
