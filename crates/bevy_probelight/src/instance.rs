//! Baked scenes in the world: what they are spawned as.

use bevy::asset::{Assets, Handle};
use bevy::camera::visibility::Visibility;
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::mesh::Mesh3d;
use bevy::pbr::{Lightmap, MeshMaterial3d};
use bevy::transform::components::Transform;

use crate::collect::{SceneFrame, SceneLight};
use crate::scene::ProbelightScene;

/// Shows a baked scene, lit: children are spawned as soon as it is loaded.
///
/// The entity may be moved, turned and scaled evenly. Remove the component, or despawn the entity, to remove the scene; give it
/// another handle to replace it.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility)]
pub struct Probelight(pub Handle<ProbelightScene>);

/// What a [`Probelight`] became when its scene was loaded.
#[derive(Component, Clone, Debug)]
pub struct ProbelightInstance {
    pub(crate) scene: Handle<ProbelightScene>,
    pub(crate) lightmap: Handle<Image>,
    pub(crate) parts: Vec<Entity>,
}

impl ProbelightInstance {
    /// The lightmap: E/π per texel, cd/m². It exists in the render world only, under this handle from the first frame on, and
    /// stays the same texture (`Rgba16Float`).
    pub fn lightmap(&self) -> &Handle<Image> {
        &self.lightmap
    }

    /// The children with the meshes, in the order of [`ProbelightScene::parts`].
    pub fn parts(&self) -> &[Entity] {
        &self.parts
    }
}

/// Spawns what was loaded, and despawns what is no longer shown.
pub(crate) fn spawn_scenes(
    mut commands: Commands,
    scenes: Res<Assets<ProbelightScene>>,
    images: Res<Assets<Image>>,
    shown: Query<(Entity, &Probelight, Option<&ProbelightInstance>)>,
    left: Query<(Entity, &ProbelightInstance), Without<Probelight>>,
) {
    for (entity, instance) in &left {
        remove_parts(&mut commands, entity, instance);
    }
    for (entity, Probelight(handle), instance) in &shown {
        if let Some(instance) = instance.filter(|instance| instance.scene != *handle) {
            remove_parts(&mut commands, entity, instance);
        } else if instance.is_some() {
            continue;
        }
        if let Some(scene) = scenes.get(handle) {
            spawn_parts(&mut commands, entity, handle, scene, images.reserve_handle());
        }
    }
}

fn remove_parts(commands: &mut Commands, entity: Entity, instance: &ProbelightInstance) {
    for part in &instance.parts {
        commands.entity(*part).try_despawn();
    }
    commands.entity(entity).remove::<(ProbelightInstance, SceneLight, SceneFrame)>();
}

fn spawn_parts(
    commands: &mut Commands,
    entity: Entity,
    handle: &Handle<ProbelightScene>,
    scene: &ProbelightScene,
    lightmap: Handle<Image>,
) {
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
    let parts = parts.collect();
    let instance = ProbelightInstance { scene: handle.clone(), lightmap, parts };
    commands.entity(entity).insert((instance, SceneLight::default(), SceneFrame::default()));
}
