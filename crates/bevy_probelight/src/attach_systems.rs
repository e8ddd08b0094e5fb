//! Gives meshes of the user's the lightmap of a baked scene, and takes it back.

use bevy::asset::{AssetEvent, Assets, Handle};
use bevy::ecs::prelude::*;
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::log::warn;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Mesh, Mesh3d};
use bevy::pbr::{Lightmap, MeshMaterial3d, StandardMaterial};
use bevy::render::render_resource::Face;
use bevy::transform::components::GlobalTransform;

use crate::attach::{Attached, LitMesh, OwnMesh, Primitives, Unlit, number_in_file, shows_backs};
use crate::casters::ProbelightShadowCaster;
use crate::collect::SceneLight;
use crate::instance::ProbelightInstance;
use crate::movers::ProbelightMover;
use crate::scene::ProbelightScene;

/// Copies of materials that show no backs. Where backs are triangles with light of their own, they would show through.
#[derive(Resource, Default)]
pub(crate) struct OneSidedMaterials(Vec<OneSided>);

struct OneSided {
    of: Handle<StandardMaterial>,
    /// Whether triangles turn round by the transform.
    is_mirrored: bool,
    copy: Handle<StandardMaterial>,
}

impl OneSidedMaterials {
    fn is_copy(&self, material: &Handle<StandardMaterial>) -> bool {
        self.copied_by(material).is_some()
    }

    /// What is copied by that material, if it is a copy.
    fn copied_by(&self, copy: &Handle<StandardMaterial>) -> Option<&Handle<StandardMaterial>> {
        self.0.iter().find(|known| known.copy == *copy).map(|known| &known.of)
    }

    /// The copy of a material.
    fn copy(
        &mut self,
        of: &Handle<StandardMaterial>,
        is_mirrored: bool,
        materials: &mut Assets<StandardMaterial>,
    ) -> Option<Handle<StandardMaterial>> {
        if let Some(known) = self.0.iter().find(|known| known.of == *of && known.is_mirrored == is_mirrored) {
            return Some(known.copy.clone());
        }
        let copy = materials.add(one_sided(materials.get(of)?, is_mirrored));
        self.0.push(OneSided { of: of.clone(), is_mirrored, copy: copy.clone() });
        Some(copy)
    }
}

fn one_sided(material: &StandardMaterial, is_mirrored: bool) -> StandardMaterial {
    let cull_mode = Some(if is_mirrored { Face::Front } else { Face::Back });
    StandardMaterial { double_sided: false, cull_mode, ..material.clone() }
}

/// What is asked of a mesh.
#[derive(QueryData)]
pub(crate) struct Part {
    entity: Entity,
    mesh: &'static Mesh3d,
    at: &'static GlobalTransform,
    material: Option<&'static MeshMaterial3d<StandardMaterial>>,
    name: Option<&'static Name>,
    attached: Option<&'static Attached>,
    is_skinned: Has<SkinnedMesh>,
}

/// A scene that is attached to meshes.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct AttachedScene {
    entity: Entity,
    at: &'static GlobalTransform,
    instance: &'static mut ProbelightInstance,
    primitives: &'static mut Primitives,
}

/// Neither movers nor shadow casters, which are no part of a scene.
type Still = (Without<ProbelightMover>, Without<ProbelightShadowCaster>);

/// Meshes that may be parts of a scene.
#[derive(SystemParam)]
pub(crate) struct Candidates<'w, 's> {
    /// Light is new where a scene is.
    new_scenes: Query<'w, 's, Entity, (With<Primitives>, Added<SceneLight>)>,
    changed: Query<'w, 's, Entity, Changed<Mesh3d>>,
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    /// Those that were not loaded.
    waiting: Local<'s, Vec<Entity>>,
}

impl Candidates<'_, '_> {
    fn take(&mut self) -> Vec<Entity> {
        let mut found = std::mem::take(&mut *self.waiting);
        found.extend(&self.changed);
        for scene in &self.new_scenes {
            found.push(scene);
            found.extend(self.children.iter_descendants(scene));
        }
        found.sort();
        found.dedup();
        found
    }

    /// The next at or above an entity of which this holds.
    fn above(&self, entity: Entity, holds: impl Fn(Entity) -> bool) -> Option<Entity> {
        std::iter::once(entity).chain(self.parents.iter_ancestors(entity)).find(|ancestor| holds(*ancestor))
    }
}

/// Where meshes and materials are.
#[derive(SystemParam)]
pub(crate) struct Shelf<'w> {
    scenes: Res<'w, Assets<ProbelightScene>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    one_sided: ResMut<'w, OneSidedMaterials>,
}

impl Shelf<'_> {
    /// What a mesh becomes in a scene; `None` before it is loaded.
    fn lit_mesh(&self, part: &PartItem, scene: &AttachedSceneItem) -> Option<Result<LitMesh, Unlit>> {
        let baked = &self.scenes.get(&scene.instance.scene)?.baked;
        let own = OwnMesh {
            mesh: self.meshes.get(&part.mesh.0)?,
            number: number_in_file(&part.mesh.0),
            material: part.material.and_then(|material| self.materials.get(&material.0)),
            scene_from_mesh: scene.at.affine().inverse() * part.at.affine(),
            is_skinned: part.is_skinned,
        };
        Some(own.lit(baked, &scene.primitives))
    }

    /// Makes a mesh a part of a scene.
    fn attach(
        &mut self,
        entity: &mut EntityCommands,
        part: &PartItem,
        scene: &mut AttachedSceneItem,
        lit: LitMesh,
    ) {
        let instance = &mut *scene.instance;
        let attached = Attached {
            scene: scene.entity,
            lightmap: instance.lightmap.id(),
            primitive: lit.primitive,
            material: lit.material,
            has_backs: lit.has_backs,
            own_mesh: part.mesh.0.clone(),
            lit_mesh: self.meshes.add(lit.mesh),
        };
        scene.primitives.taken_by[lit.primitive] = Some(part.entity);
        instance.parts.push(part.entity);
        let lightmap = Lightmap { image: instance.lightmap.clone(), ..Lightmap::default() };
        entity.insert((Mesh3d(attached.lit_mesh.clone()), lightmap));
        if let Some(MeshMaterial3d(material)) = part.material {
            self.follow(entity, &attached, instance, material, part.at);
        }
        entity.insert(attached);
    }

    /// Lets the light follow a part's material, and draws it so that backs of their own are seen.
    fn follow(
        &mut self,
        entity: &mut EntityCommands,
        part: &Attached,
        instance: &mut ProbelightInstance,
        material: &Handle<StandardMaterial>,
        at: &GlobalTransform,
    ) {
        if self.one_sided.is_copy(material) {
            return;
        }
        instance.materials[part.material] = material.clone();
        let needs_copy = part.has_backs && self.materials.get(material).is_some_and(shows_backs);
        let is_mirrored = at.affine().matrix3.determinant() < 0.0;
        if needs_copy && let Some(copy) = self.one_sided.copy(material, is_mirrored, &mut self.materials) {
            entity.insert(MeshMaterial3d(copy));
        }
    }
}

/// Gives meshes their lightmap: all that are there when a scene has been loaded, later what is spawned or given another mesh.
pub(crate) fn attach_meshes(
    mut commands: Commands,
    mut candidates: Candidates,
    parts: Query<Part, Still>,
    mut scenes: Query<AttachedScene>,
    mut shelf: Shelf,
) {
    if scenes.is_empty() {
        return;
    }
    let found = candidates.take();
    if !found.is_empty() {
        scenes.iter_mut().for_each(|scene| forget_what_is_gone(scene, &parts));
    }
    for part in found.into_iter().filter_map(|entity| parts.get(entity).ok()) {
        if part.attached.is_some_and(|attached| attached.lit_mesh == part.mesh.0) {
            continue;
        }
        let Some(scene) = candidates.above(part.entity, |ancestor| scenes.contains(ancestor)) else {
            continue;
        };
        let Ok(mut scene) = scenes.get_mut(scene) else { continue };
        let mut entity = commands.entity(part.entity);
        scene.instance.unmatched.retain(|unmatched| *unmatched != part.entity);
        if let Some(before) = part.attached {
            scene.primitives.taken_by[before.primitive] = None;
            scene.instance.parts.retain(|lit| *lit != part.entity);
            entity.remove::<(Attached, Lightmap)>();
        }
        match shelf.lit_mesh(&part, &scene) {
            Some(Ok(lit)) => shelf.attach(&mut entity, &part, &mut scene, lit),
            Some(Err(reason)) => {
                let name = part.name.map_or_else(|| part.entity.to_string(), ToString::to_string);
                warn!("'{name}' gets no light of the baked scene: {reason}");
                scene.instance.unmatched.push(part.entity);
            }
            None => candidates.waiting.push(part.entity),
        }
    }
}

/// Lets others take the places of meshes that are there no more.
fn forget_what_is_gone(mut scene: AttachedSceneItem, parts: &Query<Part, Still>) {
    let is_part = |entity: &Entity| parts.get(*entity).is_ok_and(|part| part.attached.is_some());
    scene.instance.parts.retain(is_part);
    scene.instance.unmatched.retain(|entity| parts.get(*entity).is_ok_and(|part| part.attached.is_none()));
    scene.primitives.taken_by.iter_mut().for_each(|taken| *taken = taken.filter(is_part));
}

/// What is asked of a part with another material.
type PartLook =
    (Entity, &'static Attached, &'static MeshMaterial3d<StandardMaterial>, &'static GlobalTransform);

/// Follows users' changes of parts: other materials on them, and other looks of the materials.
pub(crate) fn follow_materials(
    mut commands: Commands,
    changed: Query<PartLook, Changed<MeshMaterial3d<StandardMaterial>>>,
    mut instances: Query<&mut ProbelightInstance>,
    mut events: MessageReader<AssetEvent<StandardMaterial>>,
    mut shelf: Shelf,
) {
    for (entity, part, MeshMaterial3d(material), at) in &changed {
        if let Ok(mut instance) = instances.get_mut(part.scene) {
            shelf.follow(&mut commands.entity(entity), part, &mut instance, material, at);
        }
    }
    for event in events.read() {
        let AssetEvent::Modified { id } = event else { continue };
        let Shelf { materials, one_sided: copies, .. } = &mut shelf;
        for known in copies.0.iter().filter(|known| known.of.id() == *id) {
            let Some(changed) = materials.get(*id).map(|of| one_sided(of, known.is_mirrored)) else {
                continue;
            };
            if let Some(mut copy) = materials.get_mut(&known.copy) {
                *copy = changed;
            }
        }
    }
}

/// Gives back what parts of scenes that are gone had before.
pub(crate) fn detach_meshes(
    mut commands: Commands,
    mut removed: RemovedComponents<ProbelightInstance>,
    parts: Query<(Entity, &Attached, &Mesh3d, Option<&MeshMaterial3d<StandardMaterial>>)>,
    scenes: Query<&ProbelightInstance, With<Primitives>>,
    mut copies: ResMut<OneSidedMaterials>,
) {
    if removed.read().count() == 0 {
        return;
    }
    let mut needed = Vec::new();
    for (entity, part, Mesh3d(mesh), material) in &parts {
        if scenes.get(part.scene).is_ok_and(|instance| instance.lightmap.id() == part.lightmap) {
            needed.extend(material.map(|material| material.0.id()));
            continue;
        }
        let mut entity = commands.entity(entity);
        entity.remove::<(Attached, Lightmap)>();
        if *mesh == part.lit_mesh {
            entity.insert(Mesh3d(part.own_mesh.clone()));
        }
        if let Some(of) = material.and_then(|material| copies.copied_by(&material.0)) {
            entity.insert(MeshMaterial3d(of.clone()));
        }
    }
    copies.0.retain(|known| needed.contains(&known.copy.id()));
}
