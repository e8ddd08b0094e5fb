//! A baked scene's triangles for renderers of others: with their places in the lightmap as texture coordinates.

use std::collections::HashMap;

use probelight_math::glam::{Vec2, Vec3, Vec4};

use crate::{BakedParts, LightmapFace};

/// All triangles of a material.
///
/// Fronts are there, and backs with light of their own as triangles of their own that face the other way: each side has its
/// own place in the lightmap. Vertices are shared where all of this is the same.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LitMesh {
    /// World positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Unit tangents; the sign of the bitangent last, as glTF has it.
    pub tangents: Vec<Vec4>,
    /// Texture coordinates of the material's textures: those that the first of them uses.
    pub uvs: Vec<Vec2>,
    /// Where the light of the vertices lies in the lightmap: 0 to 1, from the top left corner of the image of all pages.
    /// Zero for sides without light of their own.
    pub lightmap_uvs: Vec<Vec2>,
    /// Three for each triangle, counter-clockwise from its front.
    pub indices: Vec<u32>,
}

/// A vertex is told from others by its number in the scene, its side, and the bits of its place in the lightmap.
type VertexKey = (u32, bool, [u32; 2]);

impl LitMesh {
    /// The triangles of a material; none if it has none.
    pub fn of_material(baked: &BakedParts, material: usize) -> Self {
        let (scene, layout) = (&*baked.scene, &baked.lightmap);
        let slots = scene.materials[material].texture_slots();
        let uses_second = slots.into_iter().flatten().next().is_some_and(|slot| slot.tex_coord == 1);
        let uvs = if uses_second && !scene.uv1.is_empty() { &scene.uv1 } else { &scene.uv0 };
        let size = Vec2::new(layout.width as f32, layout.height as f32);
        let (mut mesh, mut known) = (Self::default(), HashMap::new());
        let of_material =
            scene.triangle_material.iter().enumerate().filter(|(_, m)| **m as usize == material);
        for (triangle, _) in of_material {
            let mut add = |face: LightmapFace, is_back: bool| {
                let order = if is_back { [0, 2, 1] } else { [0, 1, 2] };
                for corner in order {
                    let (vertex, place) = (scene.triangles[triangle][corner], face.corners[corner] / size);
                    let key: VertexKey = (vertex, is_back, place.to_array().map(f32::to_bits));
                    let index = *known.entry(key).or_insert_with(|| {
                        let v = vertex as usize;
                        // Normal, tangent and bitangent all turn round, as for the back of a double-sided material.
                        let sign = if is_back { -1.0 } else { 1.0 };
                        mesh.positions.push(scene.positions[v]);
                        mesh.normals.push(scene.normals[v] * sign);
                        mesh.tangents.push(scene.tangents[v] * sign);
                        mesh.uvs.push(uvs.get(v).copied().unwrap_or_default());
                        mesh.lightmap_uvs.push(place);
                        mesh.positions.len() as u32 - 1
                    });
                    mesh.indices.push(index);
                }
            };
            add(layout.face(triangle as u32, false).copied().unwrap_or_default(), false);
            if let Some(back) = layout.face(triangle as u32, true) {
                add(*back, true);
            }
        }
        mesh
    }
}
