//! Mesh primitives as triangles in mesh space.

use gltf::accessor::Dimensions;
use gltf::mesh::{Mode, Semantic};
use probelight_math::glam::{Vec2, Vec3, Vec4};

use super::accessors::Elements;
use super::materials::Materials;
use super::resources::Resources;
use super::tangents::add_tangents;
use super::topology::{claimed_triangles, compact, corner_indices, triangles_from_mode, unshared};
use super::{Reason, Warnings};

/// Triangles of one primitive. All per-vertex arrays have the same length, but for those that may be empty.
#[derive(Default)]
pub(super) struct Primitive {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) tangents: Vec<Vec4>,
    pub(super) uv0: Vec<Vec2>,
    pub(super) uv1: Vec<Vec2>,
    /// Joints of a skin and their weights, or both empty.
    pub(super) joints: Vec<[u16; 4]>,
    pub(super) weights: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material: u32,
    /// Its index in the mesh.
    pub(super) index: u32,
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
        if !self.joints.is_empty() {
            self.joints.push(self.joints[vertex]);
            self.weights.push(self.weights[vertex]);
        }
        self.positions.len() as u32 - 1
    }

    /// Normals of the adjacent triangles, weighted by area, one per vertex.
    fn face_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
            for vertex in triangle {
                normals[*vertex as usize] += (b - a).cross(c - a);
            }
        }
        normals
    }
}

/// The vertex attributes of a primitive that Probelight uses.
struct Attributes<'a> {
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    tangents: Option<Elements<'a>>,
    uvs: [Option<Elements<'a>>; 2],
    /// Joints and weights of a skin. Those that cannot be read only matter to what moves, and are left out.
    skin: Option<[Elements<'a>; 2]>,
}

impl<'a> Attributes<'a> {
    /// Checks all attributes; `None` without positions, which means nothing to draw.
    fn new(source: &gltf::Primitive<'_>, resources: &'a Resources<'_>) -> Result<Option<Self>, Reason> {
        let optional = |semantic: Semantic, dimensions: Dimensions| {
            source.get(&semantic).map(|accessor| Elements::new(&accessor, dimensions, resources)).transpose()
        };
        let Some(accessor) = source.get(&Semantic::Positions) else { return Ok(None) };
        let positions = Elements::new(&accessor, Dimensions::Vec3, resources)?.backed(&accessor)?;
        let normals = optional(Semantic::Normals, Dimensions::Vec3)?;
        let tangents = optional(Semantic::Tangents, Dimensions::Vec4)?;
        let uvs = [
            optional(Semantic::TexCoords(0), Dimensions::Vec2)?,
            optional(Semantic::TexCoords(1), Dimensions::Vec2)?,
        ];
        for other in [&normals, &tangents, &uvs[0], &uvs[1]].into_iter().flatten() {
            if other.count < positions.count {
                let counts = (other.count, positions.count);
                return Err(format!("an attribute has {} elements for {} positions", counts.0, counts.1));
            }
        }
        let of_skin = |semantic: Semantic| {
            optional(semantic, Dimensions::Vec4).ok().flatten().filter(|it| it.count >= positions.count)
        };
        let skin = of_skin(Semantic::Joints(0)).zip(of_skin(Semantic::Weights(0))).map(<[_; 2]>::from);
        Ok(Some(Self { positions, normals, tangents, uvs, skin }))
    }
}

/// Reads a primitive; `None` if it has no triangles.
pub(super) fn import_primitive(
    source: &gltf::Primitive<'_>,
    resources: &Resources<'_>,
    materials: &Materials,
    warnings: &mut Warnings,
) -> Result<Option<Primitive>, Reason> {
    if matches!(source.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        warnings.add("primitives of points or lines, left out; light meets only triangles", 1);
    }
    if claimed_triangles(source) == 0 {
        return Ok(None);
    }
    let material = materials.index_of(&source.material());
    if materials.lets_everything_through(material) {
        warnings.add(
            "triangles of materials whose alpha is below their cutoff everywhere, left out; they would be invisible",
            claimed_triangles(source),
        );
        return Ok(None);
    }
    let Some(attributes) = Attributes::new(source, resources)? else { return Ok(None) };
    let corners = corner_indices(source, attributes.positions.count, resources)?;
    let triangles = triangles_from_mode(source.mode(), &corners);
    count_ignored(source, warnings);

    // Flat normals need vertices that no two triangles share.
    let (vertices, triangles) =
        if attributes.normals.is_some() { compact(&triangles) } else { unshared(&triangles) };
    let mut primitive =
        Primitive { triangles, material, index: source.index() as u32, ..Primitive::default() };
    read_positions(&mut primitive, &vertices, &attributes.positions)?;
    read_normals(&mut primitive, &vertices, attributes.normals.as_ref(), warnings);
    read_uvs(&mut primitive, &vertices, &attributes.uvs, materials, warnings);
    if let Some([joints, weights]) = &attributes.skin {
        let joint = |v: &u32| joints.vector(*v as usize).map(|joint: f32| joint as u16);
        primitive.joints = vertices.iter().map(joint).collect();
        primitive.weights = vertices.iter().map(|v| Vec4::from(weights.vector(*v as usize))).collect();
    }
    match &attributes.tangents {
        // Without normals the specification has tangents ignored.
        Some(tangents) if attributes.normals.is_some() => {
            primitive.tangents = vertices.iter().map(|v| Vec4::from(tangents.vector(*v as usize))).collect();
        }
        _ => add_tangents(&mut primitive),
    }
    Ok(Some(primitive))
}

fn count_ignored(source: &gltf::Primitive<'_>, warnings: &mut Warnings) {
    if source.attributes().any(|(semantic, _)| matches!(semantic, Semantic::Colors(_))) {
        warnings.add("primitives with vertex colours, which are ignored; bake them into a texture", 1);
    }
}

fn read_positions(
    primitive: &mut Primitive,
    vertices: &[u32],
    positions: &Elements<'_>,
) -> Result<(), Reason> {
    primitive.positions = vertices.iter().map(|v| Vec3::from(positions.vector(*v as usize))).collect();
    match primitive.positions.iter().position(|position| !position.is_finite()) {
        Some(v) => Err(format!("position {} is not finite", vertices[v])),
        None => Ok(()),
    }
}

/// Gives every vertex a unit normal: the file's, or the faces' where it has none that can be used.
fn read_normals(
    primitive: &mut Primitive,
    vertices: &[u32],
    normals: Option<&Elements<'_>>,
    warnings: &mut Warnings,
) {
    let mut replaced = 0;
    let face_normals = primitive.face_normals().into_iter().map(|normal| normal.normalize_or(Vec3::Y));
    let Some(normals) = normals else {
        primitive.normals = face_normals.collect();
        return;
    };
    primitive.normals = face_normals
        .zip(vertices)
        .map(|(face_normal, v)| {
            let own = Vec3::from(normals.vector(*v as usize)).try_normalize();
            replaced += usize::from(own.is_none());
            own.unwrap_or(face_normal)
        })
        .collect();
    warnings.add(
        "normals of no length or not finite, replaced by the faces'; recompute them if shading looks wrong",
        replaced,
    );
}

/// Reads both sets of texture coordinates, with the material's texture transforms.
fn read_uvs(
    primitive: &mut Primitive,
    vertices: &[u32],
    uvs: &[Option<Elements<'_>>; 2],
    materials: &Materials,
    warnings: &mut Warnings,
) {
    let mut repaired = 0;
    let transforms = &materials.uv_transforms[primitive.material as usize];
    let mut read = |elements: &Elements<'_>, set: usize| -> Vec<Vec2> {
        let uv = |v: &u32| transforms[set].apply(Vec2::from(elements.vector(*v as usize)));
        let finite = |uv: Vec2| {
            repaired += usize::from(!uv.is_finite());
            if uv.is_finite() { uv } else { Vec2::ZERO }
        };
        vertices.iter().map(uv).map(finite).collect()
    };
    primitive.uv0 =
        uvs[0].as_ref().map_or_else(|| vec![Vec2::ZERO; vertices.len()], |elements| read(elements, 0));
    primitive.uv1 = uvs[1].as_ref().map_or_else(Vec::new, |elements| read(elements, 1));
    warnings.add("texture coordinates that are not finite, set to 0; unwrap their mesh again", repaired);
}
