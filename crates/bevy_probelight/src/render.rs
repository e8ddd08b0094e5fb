//! The render world's side: a runtime for each scene, its lightmap among Bevy's images, and a frame of light before the
//! cameras draw.

use bevy::asset::Assets;
use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::prelude::*;
use bevy::log::warn;
use bevy::render::Extract;
use bevy::render::render_asset::RenderAssets;
use bevy::render::renderer::{RenderContext, RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;

use crate::collect::{SceneFrame, SceneLight};
use crate::instance::ProbelightInstance;
use crate::render_scene::{RenderScene, can_run};
use crate::scene::ProbelightScene;
use crate::settings::ProbelightSettings;

/// The scenes in the render world, by their entities in the main world.
#[derive(Resource, Default)]
pub struct RenderScenes {
    pub(crate) scenes: EntityHashMap<RenderScene>,
    /// What the device cannot hold; tried once.
    refused: EntityHashSet,
    /// Whether the device can do what is needed, once it was asked.
    is_usable: Option<bool>,
}

impl RenderScenes {
    /// Frames of light computed so far for the scene that the entity shows; while light stands still, there are no more.
    /// `None` without such a scene.
    pub fn frames(&self, scene: Entity) -> Option<u64> {
        Some(self.scenes.get(&scene)?.computed)
    }

    /// Whether the entity's scene may still be made.
    pub(crate) fn is_pending(&self, scene: Entity) -> bool {
        self.is_usable != Some(false) && !self.refused.contains(&scene)
    }
}

/// What is extracted of a scene.
type SceneParts = (Entity, &'static ProbelightInstance, Ref<'static, SceneLight>, Ref<'static, SceneFrame>);

/// After a lost device, everything is made anew.
pub(crate) fn forget_scenes(mut commands: Commands) {
    commands.insert_resource(RenderScenes::default());
}

/// Makes, changes and drops runtimes. It runs before Bevy looks for lightmaps, so that the first frame has its own.
pub(crate) fn extract_scenes(
    mut scenes: ResMut<RenderScenes>,
    mut images: ResMut<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    assets: Extract<Res<Assets<ProbelightScene>>>,
    settings: Extract<Res<ProbelightSettings>>,
    shown: Extract<Query<SceneParts>>,
) {
    let RenderScenes { scenes, refused, is_usable } = &mut *scenes;
    scenes.retain(|entity, scene| {
        let stays =
            shown.get(*entity).is_ok_and(|(_, instance, ..)| instance.lightmap.id() == scene.lightmap);
        if !stays {
            images.remove(scene.lightmap);
        }
        stays
    });
    refused.retain(|entity| shown.contains(*entity));
    for (entity, instance, light, frame) in shown.iter() {
        let is_new = !scenes.contains_key(&entity);
        if is_new {
            let wgpu_device = device.wgpu_device();
            let usable = *is_usable.get_or_insert_with(|| can_run(wgpu_device));
            let Some(asset) = assets.get(&instance.scene).filter(|_| usable && !refused.contains(&entity))
            else {
                continue;
            };
            match RenderScene::new(wgpu_device, &queue, &asset.baked, instance.lightmap.id()) {
                Ok(scene) => {
                    images.insert(instance.lightmap.id(), scene.gpu_image(wgpu_device));
                    scenes.insert(entity, scene);
                }
                Err(reason) => {
                    warn!("{entity}: the baked scene is not lit: {reason}");
                    refused.insert(entity);
                    continue;
                }
            }
        }
        let Some(scene) = scenes.get_mut(&entity) else { continue };
        scene.set_settings(&settings);
        if is_new || light.is_changed() {
            scene.set_light(&light);
        }
        if is_new || frame.is_changed() {
            scene.set_frame(&frame);
        }
    }
}

/// Encodes a frame of light for each scene that is not settled.
pub(crate) fn encode_light(mut scenes: ResMut<RenderScenes>, mut context: RenderContext) {
    if scenes.scenes.values().all(RenderScene::is_settled) {
        return;
    }
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    let span = diagnostics.as_ref().map(|recorder| {
        use bevy::render::diagnostic::RecordDiagnostics;
        recorder.time_span(encoder, "probelight")
    });
    for scene in scenes.scenes.values_mut() {
        scene.encode(encoder);
    }
    if let Some(span) = span {
        span.end(encoder);
    }
}
