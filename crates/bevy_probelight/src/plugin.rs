//! The plugin.

use bevy::app::{App, Plugin, PostUpdate, PreStartup, Update};
use bevy::asset::{AssetApp, AssetEventSystems};
use bevy::camera::visibility::VisibilitySystems;
use bevy::core_pipeline::schedule::camera_driver;
use bevy::ecs::prelude::*;
use bevy::light::GlobalAmbientLight;
use bevy::log::warn;
use bevy::pbr::MeshExtractionSystems;
use bevy::render::renderer::{RenderGraph, RenderGraphSystems};
use bevy::render::{ExtractSchedule, RenderApp, RenderStartup};
use bevy::transform::TransformSystems;

use crate::loader::ProbelightLoader;
use crate::scene::ProbelightScene;
use crate::settings::{ProbelightSettings, ProbelightSky};
use crate::{attach_systems, collect, environment, instance, mover_material, movers, render};

/// Lights baked scenes. Goes behind Bevy's own plugins, of which it needs those for assets, rendering and physically based
/// materials.
///
/// Scenes hold all their soft light, so Bevy's global ambient light is told at startup not to affect meshes with lightmaps.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbelightPlugin;

/// When the plugin works in the main world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ProbelightSystems {
    /// Children of loaded scenes are spawned (`Update`).
    Spawn,
    /// Meshes of users get their lightmap (`PostUpdate`, after transforms).
    Attach,
    /// Movers get their materials (`PostUpdate`, after transforms).
    Movers,
    /// What lights the scenes is gathered (`PostUpdate`, after transforms and visibility).
    Collect,
}

impl Plugin for ProbelightPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<ProbelightScene>()
            .register_asset_loader(ProbelightLoader)
            .init_resource::<ProbelightSettings>()
            .init_resource::<ProbelightSky>()
            .init_resource::<environment::Environment>()
            .add_systems(PreStartup, leave_ambient_light_out)
            .init_resource::<movers::GridLitMaterials>()
            .init_resource::<attach_systems::OneSidedMaterials>()
            .add_systems(Update, instance::spawn_scenes.in_set(ProbelightSystems::Spawn))
            .add_systems(
                PostUpdate,
                (
                    // Before Bevy looks for new meshes.
                    (
                        attach_systems::detach_meshes,
                        attach_systems::attach_meshes,
                        attach_systems::follow_materials,
                    )
                        .chain()
                        .in_set(ProbelightSystems::Attach)
                        .after(TransformSystems::Propagate)
                        .before(VisibilitySystems::CalculateBounds)
                        .before(AssetEventSystems),
                    // Before Bevy looks for new materials, so that a mover's first frame has its own.
                    (movers::release_movers, movers::prepare_movers, movers::follow_changes)
                        .chain()
                        .in_set(ProbelightSystems::Movers)
                        .after(TransformSystems::Propagate)
                        .before(AssetEventSystems),
                    (environment::read_environment, collect::collect)
                        .chain()
                        .in_set(ProbelightSystems::Collect)
                        .after(ProbelightSystems::Attach)
                        .after(TransformSystems::Propagate)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .after(VisibilitySystems::CalculateBounds),
                ),
            );
        mover_material::add(app);
        #[cfg(feature = "bake")]
        crate::baking::add(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            warn!("there is nothing to render with, so baked scenes are not lit");
            return;
        };
        render_app
            .init_resource::<render::RenderScenes>()
            .add_systems(RenderStartup, render::forget_scenes)
            .add_systems(ExtractSchedule, render::extract_scenes.before(MeshExtractionSystems))
            .add_systems(
                RenderGraph,
                render::encode_light.in_set(RenderGraphSystems::Render).before(camera_driver),
            );
    }
}

/// What surrounds the scenes is in their lightmaps.
fn leave_ambient_light_out(ambient: Option<ResMut<GlobalAmbientLight>>) {
    if let Some(mut ambient) = ambient {
        ambient.affects_lightmapped_meshes = false;
    }
}
