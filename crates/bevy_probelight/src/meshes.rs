//! The triangles of a material as one of Bevy's meshes.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use probelight_asset::{BakedScene, LitMesh};

/// All triangles of a material; none if it has none. Bevy's second set of texture coordinates is the lightmap's.
pub(crate) fn surface_mesh(baked: &BakedScene, material: usize) -> Option<Mesh> {
    let LitMesh { positions, normals, tangents, uvs, lightmap_uvs, indices } =
        LitMesh::of_material(baked, material);
    if indices.is_empty() {
        return None;
    }
    fn arrays<V, A: From<V>>(vectors: Vec<V>) -> Vec<A> {
        vectors.into_iter().map(A::from).collect()
    }
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, arrays::<_, [f32; 3]>(positions))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, arrays::<_, [f32; 3]>(normals))
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, arrays::<_, [f32; 4]>(tangents))
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, arrays::<_, [f32; 2]>(uvs))
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, arrays::<_, [f32; 2]>(lightmap_uvs))
        .with_inserted_indices(Indices::U32(indices));
    Some(mesh)
}

#[cfg(test)]
mod tests {
    use bevy::math::{Vec2 as BevyVec2, Vec3 as BevyVec3};
    use bevy::mesh::VertexAttributeValues;
    use probelight_math::glam::Vec2;
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
