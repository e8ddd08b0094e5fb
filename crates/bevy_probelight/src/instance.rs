//! Baked scenes in the world: what they are spawned as.

use bevy::asset::{AssetEvent, AssetId, Assets, Handle};
use bevy::camera::visibility::Visibility;
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::mesh::Mesh3d;
use bevy::pbr::{Lightmap, MeshMaterial3d, StandardMaterial};
use bevy::transform::components::Transform;

use crate::attach::{Primitives, ProbelightAttach};
use crate::collect::{SceneFrame, SceneLight};
use crate::scene::ProbelightScene;

/// Shows a baked scene, lit: children are spawned as soon as it is loaded.
///
/// The entity may be moved, turned and scaled evenly. Remove the component, or despawn the entity, to remove the scene; give it
/// another handle to replace it. When the asset changes, it is shown anew.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility)]
pub struct Probelight(pub Handle<ProbelightScene>);

/// What a [`Probelight`] became when its scene was loaded.
#[derive(Component, Clone, Debug)]
pub struct ProbelightInstance {
    pub(crate) scene: Handle<ProbelightScene>,
    pub(crate) lightmap: Handle<Image>,
    pub(crate) parts: Vec<Entity>,
    /// What the light of each of the scene's materials follows.
    pub(crate) materials: Vec<Handle<StandardMaterial>>,
    pub(crate) unmatched: Vec<Entity>,
    /// Whether the parts are meshes of the user's.
    is_attached: bool,
}

impl ProbelightInstance {
    /// The lightmap: E/π per texel, cd/m². It exists in the render world only, under this handle from the first frame on, and
    /// stays the same texture (`Rgba16Float`).
    pub fn lightmap(&self) -> &Handle<Image> {
        &self.lightmap
    }

    /// The children with the meshes, in the order of [`ProbelightScene::parts`]; for a [`ProbelightAttach`], the meshes that
    /// have a place in the lightmap, as they came.
    pub fn parts(&self) -> &[Entity] {
        &self.parts
    }

    /// Meshes below a [`ProbelightAttach`] that have no place in the lightmap.
    pub fn unmatched(&self) -> &[Entity] {
        &self.unmatched
    }
}

/// Spawns what was loaded, and despawns what is no longer shown or has changed.
pub(crate) fn spawn_scenes(
    mut commands: Commands,
    scenes: Res<Assets<ProbelightScene>>,
    images: Res<Assets<Image>>,
    mut changes: MessageReader<AssetEvent<ProbelightScene>>,
    shown: Query<(Entity, &Probelight, Has<ProbelightAttach>, Option<&ProbelightInstance>)>,
    left: Query<(Entity, &ProbelightInstance), Without<Probelight>>,
) {
    let changed = |event: &AssetEvent<ProbelightScene>| match event {
        AssetEvent::Modified { id } => Some(*id),
        _ => None,
    };
    let changed: Vec<AssetId<ProbelightScene>> = changes.read().filter_map(changed).collect();
    for (entity, instance) in &left {
        remove_parts(&mut commands, entity, instance);
    }
    for (entity, Probelight(handle), is_attached, instance) in &shown {
        if let Some(instance) = instance {
            let is_same = instance.scene == *handle && !changed.contains(&handle.id());
            if is_same && instance.is_attached == is_attached {
                continue;
            }
            remove_parts(&mut commands, entity, instance);
        }
        let Some(scene) = scenes.get(handle) else { continue };
        let lightmap = images.reserve_handle();
        let parts =
            if is_attached { Vec::new() } else { spawn_parts(&mut commands, entity, scene, &lightmap) };
        let instance = ProbelightInstance {
            scene: handle.clone(),
            lightmap,
            parts,
            materials: scene.materials.clone(),
            unmatched: Vec::new(),
            is_attached,
        };
        let mut entity = commands.entity(entity);
        entity.insert((instance, SceneLight::default(), SceneFrame::default()));
        if is_attached {
            entity.insert(Primitives::of(&scene.baked));
        }
    }
}

/// Meshes of the user's get back what they had as soon as their scene is gone.
fn remove_parts(commands: &mut Commands, entity: Entity, instance: &ProbelightInstance) {
    if !instance.is_attached {
        for part in &instance.parts {
            commands.entity(*part).try_despawn();
        }
    }
    commands.entity(entity).remove::<(ProbelightInstance, Primitives, SceneLight, SceneFrame)>();
}

fn spawn_parts(
    commands: &mut Commands,
    entity: Entity,
    scene: &ProbelightScene,
    lightmap: &Handle<Image>,
) -> Vec<Entity> {
    let parts = scene.parts.iter().map(|part| {
        let name = &scene.baked.scene.materials[part.material].name;
        let components = (
            Name::new(if name.is_empty() { format!("Material{}", part.material) } else { name.clone() }),
            Mesh3d(part.mesh.clone()),
            MeshMaterial3d(scene.materials[part.material].clone()),
            Lightmap { image: lightmap.clone(), ..Lightmap::default() },
            ChildOf(entity),
        );
        commands.spawn(components).id()
    });
    parts.collect()
}
