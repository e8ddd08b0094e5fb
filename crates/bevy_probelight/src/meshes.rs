//! The triangles of a material as one of Bevy's meshes.

use std::collections::HashMap;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use probelight_asset::{BakedScene, LightmapFace};
use probelight_math::glam::{Vec2, Vec4};
use probelight_scene::Scene;

/// The texture coordinates that a material's textures use, those of its colour first; Bevy's second set is the lightmap's.
fn texture_set(scene: &Scene, material: usize) -> u32 {
    scene.materials[material].texture_slots().into_iter().flatten().next().map_or(0, |slot| slot.tex_coord)
}

/// All triangles of a material; none if it has none.
///
/// Fronts are there, and backs with light of their own as triangles of their own that face the other way: each side has its own
/// place in the lightmap, and both cast shadows.
pub(crate) fn surface_mesh(baked: &BakedScene, material: usize) -> Option<Mesh> {
    let scene = &*baked.scene;
    let mut draft = Draft::new(scene, texture_set(scene, material));
    let size = Vec2::new(baked.lightmap.width as f32, baked.lightmap.height as f32);
    let of_material = scene.triangle_material.iter().enumerate().filter(|(_, m)| **m as usize == material);
    for (triangle, _) in of_material {
        let front = baked.lightmap.face(triangle as u32, false).copied().unwrap_or_default();
        draft.add(triangle, &front, size, false);
        if let Some(back) = baked.lightmap.face(triangle as u32, true) {
            draft.add(triangle, back, size, true);
        }
    }
    draft.finish()
}

/// A vertex is told from others by its number in the scene, its side, and the bits of its place in the lightmap.
type VertexKey = (u32, bool, [u32; 2]);

struct Draft<'a> {
    scene: &'a Scene,
    uvs: &'a [Vec2],
    known: HashMap<VertexKey, u32>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    uv0: Vec<[f32; 2]>,
    uv1: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl<'a> Draft<'a> {
    fn new(scene: &'a Scene, set: u32) -> Self {
        let uvs = if set == 1 && !scene.uv1.is_empty() { &scene.uv1 } else { &scene.uv0 };
        Self {
            scene,
            uvs,
            known: HashMap::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uv0: Vec::new(),
            uv1: Vec::new(),
            indices: Vec::new(),
        }
    }

    fn add(&mut self, triangle: usize, face: &LightmapFace, size: Vec2, is_back: bool) {
        let vertices = self.scene.triangles[triangle];
        let order = if is_back { [0, 2, 1] } else { [0, 1, 2] };
        for corner in order {
            let index = self.vertex(vertices[corner], face.corners[corner] / size, is_back);
            self.indices.push(index);
        }
    }

    fn vertex(&mut self, vertex: u32, place: Vec2, is_back: bool) -> u32 {
        let key = (vertex, is_back, place.to_array().map(f32::to_bits));
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let index = self.positions.len() as u32;
        self.known.insert(key, index);
        let v = vertex as usize;
        // Tangent, bitangent and normal all turn round, as for the back of a double-sided material.
        let sign = if is_back { -1.0 } else { 1.0 };
        let tangent: Vec4 = self.scene.tangents[v] * sign;
        self.positions.push(self.scene.positions[v].to_array());
        self.normals.push((self.scene.normals[v] * sign).to_array());
        self.tangents.push(tangent.to_array());
        self.uv0.push(self.uvs[v].to_array());
        self.uv1.push(place.to_array());
        index
    }

    fn finish(self) -> Option<Mesh> {
        if self.indices.is_empty() {
            return None;
        }
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, self.tangents)
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, self.uv0)
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, self.uv1)
            .with_inserted_indices(Indices::U32(self.indices));
        Some(mesh)
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Vec2 as BevyVec2, Vec3 as BevyVec3};
    use bevy::mesh::VertexAttributeValues;
    use probelight_runtime::synthetic::{SyntheticSize, synthetic_room};

    use super::*;

    fn floats(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec<f32>> {
        match mesh.attribute(attribute).unwrap() {
            VertexAttributeValues::Float32x2(values) => values.iter().map(|v| v.to_vec()).collect(),
            VertexAttributeValues::Float32x3(values) => values.iter().map(|v| v.to_vec()).collect(),
            _ => panic!("another format"),
        }
    }

    #[test]
    fn corners_keep_their_place_in_the_lightmap() {
        let baked = BakedScene::new(synthetic_room(SyntheticSize::hybrid(2_000))).unwrap();
        let size = Vec2::new(baked.lightmap.width as f32, baked.lightmap.height as f32);
        let mut seen = 0;
        for material in 0..baked.scene.materials.len() {
            let Some(mesh) = surface_mesh(&baked, material) else { continue };
            let [positions, normals, uv1] =
                [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_UV_1]
                    .map(|a| floats(&mesh, a));
            let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
            let of_material = (0..baked.scene.triangles.len() as u32)
                .filter(|t| baked.scene.triangle_material[*t as usize] as usize == material);
            let sides = of_material.flat_map(|t| [(t, false), (t, true)]);
            let drawn = sides.filter(|(t, is_back)| !is_back || baked.lightmap.face(*t, true).is_some());
            for ((triangle, is_back), corners) in drawn.zip(indices.chunks(3)) {
                seen += 1;
                let at = |i: usize| BevyVec3::from_slice(&positions[corners[i]]);
                let faces = (at(1) - at(0)).cross(at(2) - at(0));
                assert!(faces.dot(BevyVec3::from_slice(&normals[corners[0]])) > 0.0);
                let face = baked.lightmap.face(triangle, is_back).copied().unwrap_or_default();
                let wanted = face.corners[0] / size;
                let found = BevyVec2::from_slice(&uv1[corners[0]]);
                assert!(found.abs_diff_eq(BevyVec2::from_array(wanted.to_array()), 1e-6));
            }
        }
        assert!(seen >= baked.scene.triangles.len());
    }
}
