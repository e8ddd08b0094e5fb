//! Meshes that are not part of a scene but stand in its light.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::asset::{AssetId, Assets};
use bevy::camera::visibility::InheritedVisibility;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::log::warn_once;
use bevy::mesh::{Mesh, Mesh3d, PrimitiveTopology, VertexAttributeValues};
use bevy::transform::components::GlobalTransform;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{Material, Placement, Scene};

use crate::pose::ScenePose;

/// On a mesh: what Bevy's lights no longer reach behind it does not bounce either, in any scene. It may be a
/// [mover](crate::ProbelightMover) as well.
///
/// Whenever one moves, shadow maps and light are computed anew. The mesh is taken as it was when it first appeared, without
/// skin, and may only be scaled evenly.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ProbelightShadowCaster;

/// A shadow caster in a scene's own space.
#[derive(Clone, Debug)]
pub(crate) struct Caster {
    pub(crate) entity: Entity,
    pub(crate) model: Arc<Scene>,
    pub(crate) placement: Placement,
}

impl PartialEq for Caster {
    fn eq(&self, other: &Self) -> bool {
        self.entity == other.entity
            && Arc::ptr_eq(&self.model, &other.model)
            && self.placement == other.placement
    }
}

type CasterParts = (Entity, &'static Mesh3d, &'static GlobalTransform, &'static InheritedVisibility);

/// All shadow casters in the world, and their meshes as models; none for what is no triangles.
#[derive(SystemParam)]
pub(crate) struct Casters<'w, 's> {
    shown: Query<'w, 's, CasterParts, With<ProbelightShadowCaster>>,
    meshes: Res<'w, Assets<Mesh>>,
    models: Local<'s, HashMap<AssetId<Mesh>, Option<Arc<Scene>>>>,
}

impl Casters<'_, '_> {
    /// Those that can be in a scene, by entity.
    pub(crate) fn in_scene(&mut self, scene: &ScenePose) -> Vec<Caster> {
        let Self { shown, meshes, models } = self;
        models.retain(|mesh, _| meshes.contains(*mesh));
        let mut casters = Vec::new();
        for (entity, Mesh3d(mesh), at, _) in shown.iter().filter(|(.., visibility)| visibility.get()) {
            let Some(source) = meshes.get(mesh) else { continue };
            let model = models.entry(mesh.id()).or_insert_with(|| model_of(source));
            let pose = ScenePose::of(at);
            let (Some(model), Some(pose)) = (model, pose) else {
                warn_once!(
                    "{entity} casts no shadow into bounced light: it is not made of triangles, or scaled unevenly"
                );
                continue;
            };
            casters.push(Caster { entity, model: Arc::clone(model), placement: scene.placement(&pose) });
        }
        casters.sort_by_key(|caster| caster.entity);
        casters
    }
}

/// The triangles of a mesh that have area.
fn model_of(mesh: &Mesh) -> Option<Arc<Scene>> {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        return None;
    };
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let indices: Vec<u32> = match mesh.indices() {
        Some(indices) => indices.iter().map(|index| index as u32).collect(),
        None => (0..positions.len() as u32).collect(),
    };
    let positions: Vec<Vec3> = positions.iter().copied().map(Vec3::from_array).collect();
    let has_area = |corners: &[u32; 3]| {
        let at = corners.map(|corner| positions.get(corner as usize).copied());
        let [Some(a), Some(b), Some(c)] = at else { return false };
        (b - a).cross(c - a).length_squared() > 0.0
    };
    let triangles: Vec<[u32; 3]> = indices.as_chunks().0.iter().copied().filter(has_area).collect();
    let count = positions.len();
    let scene = Scene {
        normals: vec![Vec3::Y; count],
        tangents: vec![Vec4::X; count],
        uv0: vec![Vec2::ZERO; count],
        triangle_material: vec![0; triangles.len()],
        materials: vec![Material::default()],
        positions,
        triangles,
        ..Scene::default()
    };
    scene.validate().is_ok().then(|| Arc::new(scene))
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::math::primitives::Cuboid;

    use super::*;

    #[test]
    fn meshes_become_models() {
        let model = model_of(&Mesh::from(Cuboid::new(1.0, 2.0, 3.0))).unwrap();
        assert_eq!(model.triangles.len(), 12);
        assert!((model.surface_area() - 22.0).abs() < 1e-4);
        // Neither lines, nor nothing, nor indices of nowhere.
        let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0f32, 1.0, 2.0], [2.0, 1.0, 0.0]]);
        assert!(model_of(&lines).is_none());
        let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        assert!(model_of(&empty).is_none());
        let lost = empty
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0f32; 3]; 3])
            .with_inserted_indices(bevy::mesh::Indices::U32(vec![0, 1, 9]));
        assert!(model_of(&lost).is_none());
    }
}
