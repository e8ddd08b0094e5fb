//! Tangents by MikkTSpace, the convention that normal maps are baked for.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use probelight_math::glam::{Vec3, Vec4};

use super::primitives::Primitive;

/// Gives a primitive tangents. Vertices whose triangles disagree are split, so the vertex count may grow.
pub(super) fn add_tangents(primitive: &mut Primitive) {
    let mut corners = Corners { tangents: vec![None; primitive.triangles.len() * 3], primitive: &*primitive };
    // The error type has no values.
    let _ = generate_tangents(&mut corners);
    let corners = corners.tangents;
    split_vertices(primitive, &corners);
}

/// Any unit vector perpendicular to a normal, for surfaces without usable texture coordinates.
pub(super) fn arbitrary_tangent(normal: Vec3) -> Vec4 {
    normal.any_orthonormal_vector().extend(1.0)
}

struct Corners<'a> {
    primitive: &'a Primitive,
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)].into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)].into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // glTF's v points down, MikkTSpace's up.
        let uv = self.primitive.uv0[self.vertex(face, corner)];
        [uv.x, -uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face * 3 + corner] = tangent.map(|tangent| Vec4::from(tangent.tangent_encoded()));
    }
}

/// Writes corner tangents to their vertices; a corner that differs from the vertex's first one gets (or
/// shares) a copy of the vertex.
fn split_vertices(primitive: &mut Primitive, corner_tangents: &[Option<Vec4>]) {
    const NONE: u32 = u32::MAX;
    let original = primitive.positions.len();
    primitive.tangents = vec![Vec4::ZERO; original];
    let mut assigned = vec![false; original];
    let mut next_copy = vec![NONE; original];
    for (corner, tangent) in corner_tangents.iter().enumerate() {
        let (triangle, slot) = (corner / 3, corner % 3);
        let mut vertex = primitive.triangles[triangle][slot] as usize;
        let tangent = tangent
            .filter(|t| t.is_finite() && t.truncate().is_normalized())
            .unwrap_or_else(|| arbitrary_tangent(primitive.normals[vertex]));
        while assigned[vertex] && primitive.tangents[vertex] != tangent {
            if next_copy[vertex] == NONE {
                next_copy[vertex] = primitive.duplicate_vertex(vertex);
                next_copy.push(NONE);
                assigned.push(false);
            }
            vertex = next_copy[vertex] as usize;
        }
        primitive.tangents[vertex] = tangent;
        assigned[vertex] = true;
        primitive.triangles[triangle][slot] = vertex as u32;
    }
}
