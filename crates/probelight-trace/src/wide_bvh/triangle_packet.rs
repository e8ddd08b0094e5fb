//! Four triangles that are tested against a ray together.

use probelight_math::glam::{Vec2, Vec3};
use wide::f32x4;

/// Triangles per packet.
pub(super) const LANES: usize = 4;

/// How far outside its edges a triangle is still hit, in barycentric units. Rounding moves the common edge of
/// two triangles apart by less than this, so rays do not slip between them.
const EDGE_TOLERANCE: f32 = 1e-6;

/// Up to four triangles, component by component.
#[repr(C, align(64))]
pub(super) struct TrianglePacket {
    corner: [f32x4; 3],
    /// First corner minus second.
    edge1: [f32x4; 3],
    /// Third corner minus first.
    edge2: [f32x4; 3],
    /// cross(edge1, edge2); zero in empty lanes, which then never count as hit.
    normal: [f32x4; 3],
    /// Scene indices.
    pub(super) triangles: [u32; LANES],
}

/// Where a ray meets the lanes of a packet.
pub(super) struct PacketHits {
    /// Bit i is set if lane i is hit.
    pub(super) lanes: u32,
    pub(super) distances: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
}

impl PacketHits {
    /// Weights of the second and third corner of a lane's triangle.
    #[inline]
    pub(super) fn barycentric(&self, lane: usize) -> Vec2 {
        let v = self.v[lane].clamp(0.0, 1.0);
        Vec2::new(self.u[lane].clamp(0.0, 1.0 - v), v)
    }
}

/// A ray in the form that packets are tested against: each component in all lanes.
pub(super) struct PacketRay {
    origin: [f32x4; 3],
    direction: [f32x4; 3],
}

impl PacketRay {
    #[inline]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin: origin.to_array().map(f32x4::splat),
            direction: direction.to_array().map(f32x4::splat),
        }
    }
}

impl TrianglePacket {
    /// Packs the `members` among `triangles`, at most four.
    pub(super) fn new(members: &[u32], triangles: &[[Vec3; 3]]) -> Self {
        let mut lanes = [[Vec3::ZERO; 3]; LANES];
        let mut indices = [0; LANES];
        for (lane, member) in members.iter().enumerate() {
            lanes[lane] = triangles[*member as usize];
            indices[lane] = *member;
        }
        let components = |of: fn(&[Vec3; 3]) -> Vec3| {
            std::array::from_fn(|axis| f32x4::new(std::array::from_fn(|lane| of(&lanes[lane])[axis])))
        };
        Self {
            corner: components(|[a, _, _]| *a),
            edge1: components(|[a, b, _]| a - b),
            edge2: components(|[a, _, c]| c - a),
            normal: components(|[a, b, c]| (a - b).cross(c - a)),
            triangles: indices,
        }
    }

    /// Möller and Trumbore's test (1997) in the arrangement of madmann91's "bvh" library: everything relative
    /// to the ray's origin, normals precomputed.
    #[inline(always)]
    pub(super) fn intersect(&self, ray: &PacketRay, max_distance: f32) -> PacketHits {
        let to_corner: [f32x4; 3] = std::array::from_fn(|axis| self.corner[axis] - ray.origin[axis]);
        let moment = cross(ray.direction, to_corner);
        let inverse = f32x4::ONE / dot(self.normal, ray.direction);
        let u = dot(moment, self.edge2) * inverse;
        let v = dot(moment, self.edge1) * inverse;
        let distance = dot(self.normal, to_corner) * inverse;
        let outside = f32x4::splat(-EDGE_TOLERANCE);
        // Comparisons with the NaN of an empty or edge-on lane are false.
        let hit = u.simd_ge(outside)
            & v.simd_ge(outside)
            & (u + v).simd_le(f32x4::splat(1.0 + EDGE_TOLERANCE))
            & distance.simd_ge(f32x4::ZERO)
            & distance.simd_le(f32x4::splat(max_distance));
        PacketHits {
            lanes: hit.to_bitmask(),
            distances: distance.to_array(),
            u: u.to_array(),
            v: v.to_array(),
        }
    }
}

#[inline(always)]
fn cross(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    std::array::from_fn(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        a[next].mul_sub(b[last], a[last] * b[next])
    })
}

#[inline(always)]
fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}
