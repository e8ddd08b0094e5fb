//! Meshes that are not part of a scene, lit by the place where they are.

use std::collections::HashMap;

use bevy::asset::{AssetEvent, AssetId, Assets, Handle};
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::log::warn_once;
use bevy::material::OpaqueRendererMethod;
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::render::renderer::RenderDevice;
use bevy::transform::components::GlobalTransform;

use crate::instance::ProbelightInstance;
use crate::mover_material::{GridLight, GridLitMaterial, is_supported};
use crate::pose::ScenePose;
use crate::scene::ProbelightScene;

/// On a mesh with a [`StandardMaterial`]: it gets the soft light of the place where it is, from a scene's grid in free space.
///
/// While there is a scene, the mesh is drawn with a [`GridLitMaterial`] made of its material, whose changes are followed; scenes
/// baked without a grid (`--grid 0`) are dark in free space. Light is up to date in the very frame in which a mover arrives.
/// What it keeps from the scene needs a [`ProbelightShadowCaster`](crate::ProbelightShadowCaster).
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ProbelightMover {
    /// The entity with the scene; by default the one in whose bounds the mover is when it appears, or any.
    pub scene: Option<Entity>,
}

/// What a mover had before.
#[derive(Component, Clone, Debug)]
pub(crate) struct LitFrom {
    standard: Handle<StandardMaterial>,
    scene: Entity,
}

/// The extended materials there are, by what they extend and their scene.
#[derive(Resource, Default)]
pub(crate) struct GridLitMaterials(HashMap<(AssetId<StandardMaterial>, Entity), Handle<GridLitMaterial>>);

/// Materials as users have them, and what extends them.
#[derive(SystemParam)]
pub(crate) struct MoverMaterials<'w> {
    standard: Res<'w, Assets<StandardMaterial>>,
    lit: ResMut<'w, Assets<GridLitMaterial>>,
    known: ResMut<'w, GridLitMaterials>,
}

type Scenes<'w, 's> = Query<'w, 's, (Entity, &'static ProbelightInstance, Ref<'static, GlobalTransform>)>;

/// The scene that lights a mover, and where it is.
fn scene_of(
    mover: &ProbelightMover,
    at: &GlobalTransform,
    scenes: &Scenes,
    assets: &Assets<ProbelightScene>,
) -> Option<(Entity, ScenePose)> {
    let distance = |instance: &ProbelightInstance, pose: &ScenePose| -> Option<f32> {
        let bounds = assets.get(&instance.scene)?.baked.scene.bounds();
        Some(bounds.distance(pose.point(at.translation())) * pose.scale())
    };
    let near = scenes.iter().filter(|(entity, ..)| mover.scene.is_none_or(|wanted| wanted == *entity));
    let near = near.filter_map(|(entity, instance, place)| {
        let pose = ScenePose::of(&place)?;
        Some((distance(instance, &pose)?, entity, pose))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, entity, pose)| (entity, pose))
}

/// Gives movers the material that reads the grid.
pub(crate) fn prepare_movers(
    mut commands: Commands,
    movers: Query<(Entity, &ProbelightMover, &GlobalTransform, &MeshMaterial3d<StandardMaterial>)>,
    scenes: Scenes,
    assets: Res<Assets<ProbelightScene>>,
    device: Option<Res<RenderDevice>>,
    mut materials: MoverMaterials,
) {
    if movers.is_empty() || scenes.is_empty() {
        return;
    }
    if !device.is_some_and(|device| is_supported(&device)) {
        warn_once!("movers keep their materials: the GPU binds too few storage buffers");
        return;
    }
    let MoverMaterials { standard, lit, known } = &mut materials;
    for (entity, mover, at, MeshMaterial3d(handle)) in &movers {
        let Some((scene, pose)) = scene_of(mover, at, &scenes, &assets) else { continue };
        let Some(base) = standard.get(handle) else { continue };
        let make = || {
            let extension = GridLight { scene, scene_from_world: pose.scene_from_world() };
            lit.add(GridLitMaterial { base: forward(base), extension })
        };
        let material = known.0.entry((handle.id(), scene)).or_insert_with(make).clone();
        let from = LitFrom { standard: handle.clone(), scene };
        let mut entity = commands.entity(entity);
        entity.remove::<MeshMaterial3d<StandardMaterial>>().insert((MeshMaterial3d(material), from));
    }
}

/// Deferred passes know nothing of the grid.
fn forward(material: &StandardMaterial) -> StandardMaterial {
    StandardMaterial { opaque_render_method: OpaqueRendererMethod::Forward, ..material.clone() }
}

/// Gives back the materials of movers that are none any more, or whose scene is gone.
pub(crate) fn release_movers(
    mut commands: Commands,
    movers: Query<(Entity, &LitFrom, Has<ProbelightMover>)>,
    scenes: Query<(), With<ProbelightInstance>>,
    mut known: ResMut<GridLitMaterials>,
) {
    for (entity, LitFrom { standard, scene }, is_mover) in &movers {
        if !is_mover || !scenes.contains(*scene) {
            let mut entity = commands.entity(entity);
            entity
                .remove::<(MeshMaterial3d<GridLitMaterial>, LitFrom)>()
                .insert(MeshMaterial3d(standard.clone()));
        }
    }
    known.0.retain(|(_, scene), _| scenes.contains(*scene));
}

/// Takes changes of materials and places over into the extended ones.
pub(crate) fn follow_changes(
    mut changes: MessageReader<AssetEvent<StandardMaterial>>,
    scenes: Scenes,
    mut materials: MoverMaterials,
) {
    let MoverMaterials { standard, lit, known } = &mut materials;
    for event in changes.read() {
        let AssetEvent::Modified { id } = event else { continue };
        let Some(base) = standard.get(*id) else { continue };
        for (_, material) in known.0.iter().filter(|((of, _), _)| of == id) {
            if let Some(mut material) = lit.get_mut(material) {
                material.base = forward(base);
            }
        }
    }
    for (scene, _, place) in scenes.iter().filter(|(.., place)| place.is_changed()) {
        let Some(matrix) = ScenePose::of(&place).map(|pose| pose.scene_from_world()) else { continue };
        for (_, material) in known.0.iter().filter(|((_, of), _)| *of == scene) {
            if lit.get(material).is_some_and(|material| material.extension.scene_from_world != matrix)
                && let Some(mut material) = lit.get_mut(material)
            {
                material.extension.scene_from_world = matrix;
            }
        }
    }
}
