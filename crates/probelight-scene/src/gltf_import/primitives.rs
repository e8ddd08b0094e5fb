//! Mesh primitives as triangles in mesh space.

use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::{Mode, Semantic};
use probelight_math::glam::{Vec2, Vec3, Vec4};

use super::accessors::Elements;
use super::materials::Materials;
use super::resources::Resources;
use super::tangents::add_tangents;
use super::{Reason, Warnings};

/// Most vertices or triangles of a flattened scene, and so of a primitive.
pub(super) const MAX_ELEMENTS: usize = 1 << 26;

/// Triangles of one primitive. All per-vertex arrays have the same length, but for `uv1`, which may be empty.
#[derive(Default)]
pub(super) struct Primitive {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) tangents: Vec<Vec4>,
    pub(super) uv0: Vec<Vec2>,
    pub(super) uv1: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material: u32,
}

impl Primitive {
    /// Appends a copy of a vertex and returns its index.
    pub(super) fn duplicate_vertex(&mut self, vertex: usize) -> u32 {
        self.positions.push(self.positions[vertex]);
        self.normals.push(self.normals[vertex]);
        self.tangents.push(self.tangents[vertex]);
        self.uv0.push(self.uv0[vertex]);
        if !self.uv1.is_empty() {
            self.uv1.push(self.uv1[vertex]);
        }
        self.positions.len() as u32 - 1
    }

    fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }
}

/// Reads a primitive; `None` if it has no triangles.
pub(super) fn import_primitive(
    source: &gltf::Primitive<'_>,
    resources: &Resources<'_>,
    materials: &Materials,
    warnings: &mut Warnings,
) -> Result<Option<Primitive>, Reason> {
    let Some(positions) = attribute(source, &Semantic::Positions, Dimensions::Vec3, resources)? else {
        return Ok(None);
    };
    count_ignored(source, warnings);
    let corners = corner_indices(source, positions.count, resources)?;
    let Some(triangles) = triangles_from_mode(source.mode(), &corners) else {
        warnings.add("primitives of points or lines, left out", 1);
        return Ok(None);
    };
    let normals = attribute(source, &Semantic::Normals, Dimensions::Vec3, resources)?;
    let tangents = attribute(source, &Semantic::Tangents, Dimensions::Vec4, resources)?;
    let uvs = [0, 1].map(|set| attribute(source, &Semantic::TexCoords(set), Dimensions::Vec2, resources));
    let [uv0, uv1] = uvs;
    let (uv0, uv1) = (uv0?, uv1?);
    for other in [&normals, &tangents, &uv0, &uv1].into_iter().flatten() {
        if other.count < positions.count {
            return Err(format!(
                "an attribute has {} elements for {} positions",
                other.count, positions.count
            ));
        }
    }

    // Flat normals need vertices that no two triangles share.
    let (vertices, triangles) = if normals.is_some() { compact(&triangles) } else { unshared(&triangles) };
    let material = materials.index_of(&source.material());
    let transforms = &materials.uv_transforms[material as usize];
    let read_uv = |elements: &Elements<'_>, set: usize| -> Vec<Vec2> {
        let read = |v: &u32| transforms[set].apply(Vec2::from(elements.vector(*v as usize)));
        vertices.iter().map(read).collect()
    };
    let mut primitive = Primitive {
        positions: vertices.iter().map(|v| Vec3::from(positions.vector(*v as usize))).collect(),
        normals: Vec::new(),
        tangents: Vec::new(),
        uv0: uv0.as_ref().map_or_else(|| vec![Vec2::ZERO; vertices.len()], |uv| read_uv(uv, 0)),
        uv1: uv1.as_ref().map_or_else(Vec::new, |uv| read_uv(uv, 1)),
        triangles,
        material,
    };
    if let Some(v) = primitive.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!("position {} is not finite", vertices[v]));
    }
    add_normals(&mut primitive, &vertices, normals.as_ref(), warnings);
    match tangents {
        Some(tangents) => {
            primitive.tangents = vertices.iter().map(|v| Vec4::from(tangents.vector(*v as usize))).collect();
        }
        None => add_tangents(&mut primitive),
    }
    repair_uvs(&mut primitive, warnings);
    Ok(Some(primitive))
}

fn attribute<'a>(
    source: &gltf::Primitive<'_>,
    semantic: &Semantic,
    dimensions: Dimensions,
    resources: &'a Resources<'_>,
) -> Result<Option<Elements<'a>>, Reason> {
    source.get(semantic).map(|accessor| Elements::new(&accessor, dimensions, resources)).transpose()
}

fn count_ignored(source: &gltf::Primitive<'_>, warnings: &mut Warnings) {
    let has = |wanted: fn(&Semantic) -> bool| source.attributes().any(|(semantic, _)| wanted(&semantic));
    if has(|semantic| matches!(semantic, Semantic::Colors(_))) {
        warnings.add("primitives with vertex colours, which are ignored", 1);
    }
    if source.morph_targets().next().is_some() {
        warnings.add("primitives with morph targets, left at rest", 1);
    }
}

/// The vertex of each corner, checked to exist.
fn corner_indices(
    source: &gltf::Primitive<'_>,
    vertex_count: usize,
    resources: &Resources<'_>,
) -> Result<Vec<u32>, Reason> {
    let too_many = |count: usize| format!("it has {count} vertices; at most {MAX_ELEMENTS} can be used");
    let Some(accessor) = source.indices() else {
        if vertex_count > MAX_ELEMENTS {
            return Err(too_many(vertex_count));
        }
        return Ok((0..vertex_count as u32).collect());
    };
    if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("accessors[{}]: indices must be unsigned integers", accessor.index()));
    }
    let elements = Elements::new(&accessor, Dimensions::Scalar, resources)?;
    if elements.count > 3 * MAX_ELEMENTS {
        return Err(too_many(elements.count));
    }
    let indices: Vec<u32> = (0..elements.count).map(|i| elements.index(i)).collect();
    match indices.iter().find(|index| **index as usize >= vertex_count) {
        Some(index) => Err(format!("index {index} is out of range: there are {vertex_count} vertices")),
        None => Ok(indices),
    }
}

/// Triangles of a list, strip or fan, all with the strip's or fan's own front face; `None` for points and lines.
fn triangles_from_mode(mode: Mode, corners: &[u32]) -> Option<Vec<[u32; 3]>> {
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
        Mode::Triangles => Some(corners.as_chunks::<3>().0.to_vec()),
        Mode::TriangleStrip => Some(
            corners
                .windows(3)
                .enumerate()
                .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
                .collect(),
        ),
        Mode::TriangleFan => {
            let (&hub, rim) = corners.split_first()?;
            Some(rim.windows(2).map(|w| [hub, w[0], w[1]]).collect())
        }
    }
}

/// Only the vertices that triangles use, and the triangles renumbered to them.
fn compact(triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut vertices = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let position = |v: u32| vertices.partition_point(|other| *other < v) as u32;
    let renumbered = triangles.iter().map(|triangle| triangle.map(position)).collect();
    (vertices, renumbered)
}

/// Three vertices of its own for each triangle.
fn unshared(triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let renumbered = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    (triangles.as_flattened().to_vec(), renumbered)
}

/// Drops triangles without area, and gives every vertex a unit normal: the file's, or the face's where the
/// file has none or one that cannot be normalised.
fn add_normals(
    primitive: &mut Primitive,
    vertices: &[u32],
    normals: Option<&Elements<'_>>,
    warnings: &mut Warnings,
) {
    let mut face_normals = vec![Vec3::ZERO; vertices.len()];
    for triangle in &primitive.triangles {
        let [a, b, c] = primitive.corners(*triangle);
        let weighted = (b - a).cross(c - a);
        for vertex in triangle {
            face_normals[*vertex as usize] += weighted;
        }
    }
    let mut replaced = 0;
    primitive.normals = (0..vertices.len())
        .map(|v| {
            let face_normal = face_normals[v].normalize_or(Vec3::Y);
            let Some(normals) = normals else { return face_normal };
            let own = Vec3::from(normals.vector(vertices[v] as usize)).try_normalize();
            own.unwrap_or_else(|| {
                replaced += 1;
                face_normal
            })
        })
        .collect();
    warnings.add("normals of no length or direction, replaced by the faces'", replaced);
}

fn repair_uvs(primitive: &mut Primitive, warnings: &mut Warnings) {
    let mut repaired = 0;
    for uv in primitive.uv0.iter_mut().chain(&mut primitive.uv1).filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        repaired += 1;
    }
    warnings.add("texture coordinates that are not finite, set to 0", repaired);
}
