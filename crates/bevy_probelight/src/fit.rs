//! Whether a mesh of the user's is a part of a baked scene, and the mesh with its places in the lightmap.
//!
//! The bake keeps, for each of its triangles, the triangle of the file that it is or is a piece of. A mesh fits if all
//! these pieces lie on its own triangles and cover them. The lit mesh is made of the mesh's own vertices, blended where the
//! bake has cut.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::math::{Affine3A, Vec3};
use bevy::mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues as Values};
use probelight_asset::{BakedScene, LightmapFace};
use probelight_math::glam::Vec2 as SceneVec2;

/// How much of a mesh's area may be missing, or too much, as a share.
const AREA: f32 = 0.005;

/// Weights closer than this to a corner's or an edge's are meant to be there: what rounding leaves, also in large triangles.
const ON_EDGE: f32 = 1e-5;

/// Index of each triangle's vertices; `None` for what is no triangles.
fn triangles_of(mesh: &Mesh, vertices: usize) -> Option<Vec<[u32; 3]>> {
    let indices: Vec<u32> = match mesh.try_indices_option().ok()? {
        Some(indices) => indices.iter().map(|index| index as u32).collect(),
        None => (0..vertices as u32).collect(),
    };
    if indices.iter().any(|index| *index as usize >= vertices) {
        return None;
    }
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => Some(indices.as_chunks().0.to_vec()),
        // Every other one turns round, which is of no interest here.
        PrimitiveTopology::TriangleStrip => Some(indices.windows(3).map(|w| [w[0], w[1], w[2]]).collect()),
        _ => None,
    }
}

/// A mesh of the user's where it is in a baked scene.
pub(crate) struct PlacedMesh<'a> {
    mesh: &'a Mesh,
    /// In the scene's space.
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> PlacedMesh<'a> {
    /// `None` for what has no triangles in the main world.
    pub(crate) fn new(mesh: &'a Mesh, scene_from_mesh: &Affine3A) -> Option<Self> {
        let Ok(Values::Float32x3(positions)) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) else {
            return None;
        };
        let triangles = triangles_of(mesh, positions.len())?;
        let positions =
            positions.iter().map(|p| scene_from_mesh.transform_point3(Vec3::from_array(*p))).collect();
        Some(Self { mesh, positions, triangles })
    }

    fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }

    fn area(&self) -> f32 {
        self.triangles.iter().map(|triangle| doubled_area(self.corners(*triangle)).length()).sum::<f32>()
    }
}

/// Normal, as long as the triangle's area is large, twice.
fn doubled_area([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// A point on a triangle of a mesh: a blend of its vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blend {
    vertices: [u32; 3],
    weights: [f32; 3],
}

impl Blend {
    fn at_vertex(vertex: u32) -> Self {
        Self { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// The point of a triangle that is closest to a position, nearly.
    fn near(position: Vec3, vertices: [u32; 3], corners: [Vec3; 3]) -> Self {
        let normal = doubled_area(corners);
        let weight = |from: usize, to: usize| {
            (corners[from] - position).cross(corners[to] - position).dot(normal) / normal.length_squared()
        };
        let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
        let weights = weights.map(|weight| if weight < ON_EDGE { 0.0 } else { weight });
        let sum: f32 = weights.iter().sum();
        match weights.iter().position(|weight| *weight >= (1.0 - ON_EDGE) * sum) {
            Some(corner) => Self::at_vertex(vertices[corner]),
            None => Self { vertices, weights: weights.map(|weight| weight / sum) },
        }
    }

    fn of<const N: usize>(&self, values: &[[f32; N]]) -> [f32; N] {
        let [a, b, c] = self.vertices.map(|vertex| values[vertex as usize]);
        if self.weights[0] == 1.0 {
            return a;
        }
        let [wa, wb, wc] = self.weights;
        std::array::from_fn(|i| wa * a[i] + wb * b[i] + wc * c[i])
    }

    /// What cannot be blended is that of the nearest vertex.
    fn nearest<T: Copy>(&self, values: &[T]) -> T {
        let heaviest = (0..3).max_by(|i, j| self.weights[*i].total_cmp(&self.weights[*j]));
        values[self.vertices[heaviest.unwrap_or(0)] as usize]
    }
}

/// A triangle of a baked scene on a mesh.
#[derive(Clone, Copy, Debug)]
struct Piece {
    triangle: u32,
    /// Where its corners are.
    corners: [Blend; 3],
    /// Whether it is wound as the mesh's own triangle; not so in mirrored meshes.
    keeps_order: bool,
}

/// How a mesh is made of triangles of a baked scene.
#[derive(Clone, Debug)]
pub(crate) struct Fit(Vec<Piece>);

impl Fit {
    /// Looks whether these triangles of a scene are those of a mesh, each point within a distance; metres.
    pub(crate) fn new(mesh: &PlacedMesh, baked: &BakedScene, triangles: &[u32], within: f32) -> Option<Self> {
        let scene = &*baked.scene;
        let mut area = 0.0;
        let piece_of = |triangle: &u32| {
            let source = scene.sources.triangles[*triangle as usize].triangle;
            let vertices = *mesh.triangles.get(source as usize)?;
            let piece = scene.corners(*triangle as usize).map(|corner| Vec3::from_array(corner.to_array()));
            area += doubled_area(piece).length();
            place(mesh, *triangle, vertices, piece, within)
        };
        let pieces: Option<Vec<Piece>> = triangles.iter().map(piece_of).collect();
        let own = mesh.area();
        let covers = (area - own).abs() <= AREA * own && own > 0.0;
        pieces.filter(|_| covers).map(Self)
    }

    /// Whether a back of one of the triangles has light of its own.
    pub(crate) fn has_backs(&self, baked: &BakedScene) -> bool {
        self.0.iter().any(|piece| baked.lightmap.face(piece.triangle, true).is_some())
    }

    /// The mesh with places in the lightmap as its second texture coordinates. With backs, they are triangles of their own
    /// that face the other way.
    pub(crate) fn lit_mesh(&self, mesh: &PlacedMesh, baked: &BakedScene, with_backs: bool) -> Mesh {
        let layout = &baked.lightmap;
        let mut corners = Corners::new([layout.width, layout.height]);
        for piece in &self.0 {
            let front = layout.face(piece.triangle, false).copied().unwrap_or_default();
            corners.add(piece, front, false);
            if let Some(back) = layout.face(piece.triangle, true).filter(|_| with_backs) {
                corners.add(piece, *back, true);
            }
        }
        corners.into_mesh(mesh.mesh)
    }
}

/// A piece on a triangle of a mesh, if it lies there.
fn place(
    mesh: &PlacedMesh,
    triangle: u32,
    vertices: [u32; 3],
    piece: [Vec3; 3],
    within: f32,
) -> Option<Piece> {
    let corners = mesh.corners(vertices);
    let normal = doubled_area(corners);
    if normal.length_squared() <= 0.0 {
        return None;
    }
    let keeps_order = normal.dot(doubled_area(piece)) > 0.0;
    let blends = whole(vertices, corners, piece, within)
        .unwrap_or_else(|| piece.map(|position| Blend::near(position, vertices, corners)));
    let positions: Vec<[f32; 3]> = corners.iter().map(Vec3::to_array).collect();
    let is_there = |(blend, wanted): (&Blend, Vec3)| {
        let local =
            blend.vertices.map(|vertex| vertices.iter().position(|v| *v == vertex).unwrap_or(0) as u32);
        let found = Blend { vertices: local, weights: blend.weights }.of(&positions);
        Vec3::from_array(found).distance(wanted) <= within
    };
    blends.iter().zip(piece).all(is_there).then_some(Piece { triangle, corners: blends, keeps_order })
}

/// The corners of a piece that is a whole triangle: no arithmetic may move them.
fn whole(vertices: [u32; 3], corners: [Vec3; 3], piece: [Vec3; 3], within: f32) -> Option<[Blend; 3]> {
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let distance =
        |order: &[usize; 3]| (0..3).map(|i| corners[order[i]].distance(piece[i])).fold(0.0, f32::max);
    let (far, order) =
        orders.iter().map(|order| (distance(order), order)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (far <= within).then(|| order.map(|i| Blend::at_vertex(vertices[i])))
}

/// Tells a vertex from others: which of the mesh's it blends, its side, its place in the lightmap.
type VertexKey = ([u32; 3], [u32; 3], bool, [u32; 2]);

/// The vertices of a lit mesh as they come.
struct Corners {
    size: SceneVec2,
    known: HashMap<VertexKey, u32>,
    vertices: Vec<(Blend, bool)>,
    lightmap_uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl Corners {
    fn new(size: [u32; 2]) -> Self {
        let size = SceneVec2::from_array(size.map(|texels| texels as f32));
        let (known, vertices, lightmap_uvs, indices) = Default::default();
        Self { size, known, vertices, lightmap_uvs, indices }
    }

    fn add(&mut self, piece: &Piece, face: LightmapFace, is_back: bool) {
        let order = if piece.keeps_order != is_back { [0, 1, 2] } else { [0, 2, 1] };
        for corner in order {
            let blend = piece.corners[corner];
            let uv = (face.corners[corner] / self.size).to_array();
            let key = (blend.vertices, blend.weights.map(f32::to_bits), is_back, uv.map(f32::to_bits));
            let next = self.vertices.len() as u32;
            let index = *self.known.entry(key).or_insert(next);
            if index == next {
                self.vertices.push((blend, is_back));
                self.lightmap_uvs.push(uv);
            }
            self.indices.push(index);
        }
    }

    fn into_mesh(self, source: &Mesh) -> Mesh {
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        for (attribute, values) in source.attributes() {
            let turns = [Mesh::ATTRIBUTE_NORMAL.id, Mesh::ATTRIBUTE_TANGENT.id].contains(&attribute.id);
            mesh.insert_attribute(*attribute, self.blended(values, turns));
        }
        mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, self.lightmap_uvs)
            .with_inserted_indices(Indices::U32(self.indices))
    }

    /// An attribute of the vertices; some turn round on backs.
    fn blended(&self, values: &Values, turns: bool) -> Values {
        fn floats<const N: usize>(
            vertices: &[(Blend, bool)],
            values: &[[f32; N]],
            turns: bool,
        ) -> Vec<[f32; N]> {
            let of = |(blend, is_back): &(Blend, bool)| {
                let value = blend.of(values);
                if turns && *is_back { value.map(|v| -v) } else { value }
            };
            vertices.iter().map(of).collect()
        }
        macro_rules! blended {
            ($($float:ident)*; $($other:ident)*) => {
                match values {
                    $(Values::$float(values) => Values::$float(floats(&self.vertices, values, turns)),)*
                    $(Values::$other(values) => {
                        Values::$other(self.vertices.iter().map(|(blend, _)| blend.nearest(values)).collect())
                    })*
                }
            };
        }
        blended! {
            Float32x2 Float32x3 Float32x4;
            Uint8 Uint8x2 Uint8x4 Sint8 Sint8x2 Sint8x4 Unorm8 Unorm8x2 Unorm8x4 Snorm8 Snorm8x2 Snorm8x4
            Uint16 Uint16x2 Uint16x4 Sint16 Sint16x2 Sint16x4 Unorm16 Unorm16x2 Unorm16x4 Snorm16 Snorm16x2 Snorm16x4
            Float16 Float16x2 Float16x4 Float32 Uint32 Uint32x2 Uint32x3 Uint32x4 Sint32 Sint32x2 Sint32x3 Sint32x4
            Float64 Float64x2 Float64x3 Float64x4 Unorm10_10_10_2 Unorm8x4Bgra
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy::math::Quat;
    use probelight_asset::BakedParts;
    use probelight_math::glam::Vec3 as SceneVec3;
    use probelight_scene::{Material, Scene, SourceInstance, SourceTriangle, Sources};

    use super::*;

    /// A quad of two triangles, the second with corners of its own; each with two texture coordinates.
    fn quad() -> Mesh {
        let positions = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, -2.0], [0.0, 0.0, -2.0]];
        let uvs: Vec<[f32; 2]> = positions.iter().map(|[x, _, z]: &[f32; 3]| [*x, *z]).collect();
        let joints: Vec<[u16; 4]> = (0..4).map(|i| [i; 4]).collect();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; 4])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, Values::Uint16x4(joints))
            .with_inserted_indices(Indices::U16(vec![0, 1, 2, 0, 2, 3]))
    }

    /// Where it is in the scene.
    fn place(is_mirrored: bool) -> Affine3A {
        let scale = Vec3::new(if is_mirrored { -0.5 } else { 0.5 }, 3.0, 0.5);
        Affine3A::from_scale_rotation_translation(
            scale,
            Quat::from_rotation_x(0.3),
            Vec3::new(4.0, 0.1, -2.0),
        )
    }

    /// The quad as a bake has cut it: the first triangle in two, between its second corner and a point of the opposite edge, which
    /// is close to the end.
    /// The second triangle has a back with light of its own.
    fn baked(world: &Affine3A, is_mirrored: bool) -> BakedScene {
        let points =
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, -2.0], [0.0, 0.0, -2.0], [0.001, 0.0, -0.001]];
        let positions = points
            .map(|point| SceneVec3::from_array(world.transform_point3(Vec3::from_array(point)).to_array()));
        let front = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let triangles = [[1, 2, 4], [4, 0, 1], [0, 2, 3]].map(front);
        let triangle = |triangle| SourceTriangle { instance: 0, triangle };
        let scene = Scene {
            positions: positions.to_vec(),
            normals: vec![SceneVec3::Y; 5],
            tangents: vec![SceneVec3::X.extend(1.0); 5],
            uv0: vec![SceneVec2::ZERO; 5],
            triangles: triangles.to_vec(),
            triangle_material: vec![0; 3],
            sources: Sources {
                instances: vec![SourceInstance::default()],
                triangles: [0, 0, 1].map(triangle).to_vec(),
            },
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let parts = BakedScene::unbaked(Arc::new(scene)).unwrap().into_parts();
        let mut lightmap = parts.lightmap.clone();
        (lightmap.width, lightmap.height) = (64, 32);
        let face = |triangle: usize| LightmapFace {
            corners: [0, 1, 2]
                .map(|corner| SceneVec2::new(10.0 * triangle as f32 + corner as f32, corner as f32 + 1.0)),
        };
        lightmap.faces = (0..4).map(face).collect();
        lightmap.back_faces[2] = 3;
        BakedScene::new(BakedParts { lightmap, ..parts }).unwrap()
    }

    fn floats<const N: usize>(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<[f32; N]> {
        let values = mesh.attribute(attribute).unwrap().get_bytes();
        bytemuck::cast_slice::<u8, f32>(values).as_chunks().0.to_vec()
    }

    #[test]
    fn pieces_are_found_on_the_mesh_and_keep_their_place_in_the_lightmap() {
        for is_mirrored in [false, true] {
            let world = place(is_mirrored);
            let (mesh, baked) = (quad(), baked(&world, is_mirrored));
            let placed = PlacedMesh::new(&mesh, &world).unwrap();
            let fit = Fit::new(&placed, &baked, &[0, 1, 2], 1e-4).expect("it fits");
            assert!(fit.has_backs(&baked));
            let lit = fit.lit_mesh(&placed, &baked, true);
            let positions = floats::<3>(&lit, Mesh::ATTRIBUTE_POSITION);
            let normals = floats::<3>(&lit, Mesh::ATTRIBUTE_NORMAL);
            let [uvs, lightmap_uvs] =
                [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1].map(|attribute| floats::<2>(&lit, attribute));
            let indices: Vec<usize> = lit.indices().unwrap().iter().collect();
            assert_eq!(indices.len(), 3 * 4);
            for (corners, (triangle, face)) in indices.chunks(3).zip([(0, 0), (1, 1), (2, 2), (2, 3)]) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from_array(positions[corners[i]]));
                let normal = Vec3::from_array(normals[corners[0]]);
                assert_eq!(normal.y, if face == 3 { -1.0 } else { 1.0 });
                // The transform may turn triangles round, but not in the mesh's own space.
                assert!((b - a).cross(c - a).dot(normal) > 0.0, "{face}");
                for corner in corners {
                    let position = positions[*corner];
                    assert_eq!(uvs[*corner], [position[0], position[2]]);
                    let in_scene = world.transform_point3(Vec3::from_array(position)).to_array();
                    let nearest = |i: &usize| {
                        let vertex = baked.scene.triangles[triangle][*i] as usize;
                        baked.scene.positions[vertex].distance(SceneVec3::from_array(in_scene))
                    };
                    let i = (0..3).min_by(|i, j| nearest(i).total_cmp(&nearest(j))).unwrap();
                    assert!(nearest(&i) < 1e-5);
                    let wanted = baked.lightmap.faces[face].corners[i] / SceneVec2::new(64.0, 32.0);
                    assert_eq!(lightmap_uvs[*corner], wanted.to_array());
                }
            }
            // Without backs there are the fronts alone; vertices that were there are not made anew.
            let fronts = fit.lit_mesh(&placed, &baked, false);
            assert_eq!(fronts.indices().unwrap().len(), 9);
            assert!(matches!(fronts.attribute(Mesh::ATTRIBUTE_JOINT_INDEX), Some(Values::Uint16x4(_))));
        }
    }

    #[test]
    fn what_lies_elsewhere_or_covers_less_does_not_fit() {
        let world = place(false);
        let (mesh, baked) = (quad(), baked(&world, false));
        let fits = |mesh: &Mesh, world: &Affine3A, triangles: &[u32]| {
            Fit::new(&PlacedMesh::new(mesh, world).unwrap(), &baked, triangles, 1e-4).is_some()
        };
        assert!(fits(&mesh, &world, &[0, 1, 2]));
        assert!(!fits(&mesh, &world, &[1, 2]), "a piece is missing");
        let moved = Affine3A::from_translation(Vec3::new(1e-3, 0.0, 0.0)) * world;
        assert!(!fits(&mesh, &moved, &[0, 1, 2]), "it was moved");
        let mut bent = mesh.clone();
        if let Some(Values::Float32x3(positions)) = bent.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
            positions[3][1] = 0.01;
        }
        assert!(!fits(&bent, &world, &[0, 1, 2]), "a vertex was moved");
        let less = mesh.clone().with_inserted_indices(Indices::U16(vec![0, 1, 2]));
        assert!(!fits(&less, &world, &[0, 1, 2]), "a triangle is missing");
        let more = mesh.clone().with_inserted_indices(Indices::U16(vec![0, 1, 2, 0, 2, 3, 0, 3, 1]));
        assert!(!fits(&more, &world, &[0, 1, 2]), "there is a triangle more");
        assert!(PlacedMesh::new(&mesh.with_inserted_indices(Indices::U16(vec![0, 1, 9])), &world).is_none());
    }
}
