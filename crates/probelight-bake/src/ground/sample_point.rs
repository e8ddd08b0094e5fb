//! Points that rays start from, and how these weigh directions.

use std::f32::consts::PI;

use probelight_asset::{GridBasis, MAX_GRID_ROWS};
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, sphere_from_square, world_from_tangent};
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
        Self { origin, lobe: Lobe::Cosine(normal) }
    }
}

/// How the rays of a point are spread over the directions.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lobe {
    /// By the cosine with a unit normal.
    Cosine(Vec3),
    /// Evenly.
    Sphere,
}

impl Lobe {
    /// Integral over all directions, steradians.
    pub(crate) const fn total(self) -> f32 {
        match self {
            Self::Cosine(_) => PI,
            Self::Sphere => 4.0 * PI,
        }
    }

    /// A unit direction drawn in proportion to the lobe, and its value there.
    pub(crate) fn draw(self, u: Vec2) -> (Vec3, f32) {
        match self {
            Self::Cosine(normal) => {
                let local = cosine_hemisphere_from_square(u);
                (world_from_tangent(normal) * local, local.z.max(f32::MIN_POSITIVE))
            }
            Self::Sphere => (sphere_from_square(u), 1.0),
        }
    }

    /// Its value along a unit direction; not above zero where it takes no light from.
    pub(crate) fn value(self, direction: Vec3) -> f32 {
        match self {
            Self::Cosine(normal) => normal.dot(direction),
            Self::Sphere => 1.0,
        }
    }
}

/// What a place keeps of the light that its lobe brings: one number or several, the rows of its transport.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Reception {
    /// All of it: irradiance.
    #[default]
    Irradiance,
    /// As much as each function of a basis takes.
    Basis(GridBasis),
}

impl Reception {
    /// Number of rows.
    pub(crate) const fn rows(self) -> usize {
        match self {
            Self::Irradiance => 1,
            Self::Basis(basis) => basis.rows(),
        }
    }

    /// Which rows are compressed together.
    pub(crate) const fn part_of(self, row: usize) -> usize {
        match self {
            Self::Irradiance => 0,
            Self::Basis(basis) => basis.part_of(row),
        }
    }

    /// How much of the lobe's light from a unit direction each row takes.
    pub(crate) fn factors(self, direction: Vec3) -> [f32; MAX_GRID_ROWS] {
        match self {
            Self::Irradiance => {
                let mut one = [0.0; MAX_GRID_ROWS];
                one[0] = 1.0;
                one
            }
            Self::Basis(basis) => basis.received(direction),
        }
    }
}
