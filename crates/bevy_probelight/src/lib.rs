//! Real-time global illumination by [Probelight] in Bevy: bake a static scene once, then let its lights, sky, emission
//! and colours change, and the bounced light follows.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_probelight::{Probelight, ProbelightPlugin};
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, ProbelightPlugin)).add_systems(Startup, setup).run();
//! }
//!
//! fn setup(mut commands: Commands, assets: Res<AssetServer>) {
//!     commands.spawn(Probelight(assets.load("atrium.plight")));
//!     commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 2.0, 8.0)));
//!     commands.spawn((PointLight { shadow_maps_enabled: true, ..default() }, Transform::from_xyz(0.0, 3.0, 0.0)));
//! }
//! ```
//!
//! # What happens
//!
//! ```text
//!  main world                                        render world
//!  .plight ─► ProbelightScene ─► children with       GpuRuntime on Bevy's device, one per Probelight
//!             meshes, materials, Lightmap ──────────────────────────┐ texture
//!  lights, ProbelightSky, materials, camera ─► a frame of light ─► lightmap ─► cameras
//! ```
//!
//! * [`Probelight`] on an entity shows a scene: children with one mesh per material and Bevy's own [`Lightmap`], all of
//!   which refer to one texture. The texture is filled anew before the cameras draw whenever something changed; while
//!   nothing does, nothing is computed.
//! * Bevy's point, spot and directional lights bounce, unless they have [`ProbelightIgnore`]; [`ProbelightSky`] shines in.
//!   Colour and emission of the scene's [`StandardMaterial`]s count as they are.
//! * [`ProbelightMover`] gives meshes of your own the light at the place where they are, [`ProbelightShadowCaster`] lets them
//!   stand in the light that bounces.
//! * [`ProbelightAttach`] lights the meshes of a glTF scene that Bevy loaded, in place of the scene's own.
//! * [`ProbelightSettings`] has levels of detail and a budget.
//! * [`BakeScene`] bakes a glTF file in the app (feature `bake`, on by default).
//!
//! # Units
//!
//! Bevy's: lumens, lux, candela per square metre, metres. Bevy multiplies a lightmap by the base colour, so the texture holds
//! E/π, E being the irradiance in lux; `lightmap_exposure` stays 1. A material's `emissive` is what Bevy shows: cd/m² with an
//! `emissive_exposure_weight` of 1, which the scene's own materials have, and with weight 0 as bright as it looks through the
//! main camera's exposure.
//!
//! # What is not here
//!
//! Lights of no size only: the radius of a light and [`RectLight`]s do not count, nor do light textures. Lights shine through
//! walls in Bevy unless `shadow_maps_enabled` is set; their bounced light never does. A scene may be moved, turned and scaled
//! evenly; others are refused with a warning. Two scenes do not light each other.
//!
//! [Probelight]: https://github.com/probelight/probelight
//! [`Lightmap`]: bevy::pbr::Lightmap
//! [`StandardMaterial`]: bevy::pbr::StandardMaterial
//! [`RectLight`]: bevy::light::RectLight

mod attach;
mod attach_systems;
#[cfg(feature = "bake")]
mod baking;
mod casters;
mod collect;
mod convert;
mod cube_map;
mod environment;
mod fit;
mod instance;
mod lights;
mod loader;
mod materials;
mod meshes;
mod mipmaps;
mod mover_material;
mod movers;
mod plugin;
mod pose;
mod render;
mod render_scene;
mod scene;
mod settings;

pub use attach::ProbelightAttach;
#[cfg(feature = "bake")]
pub use baking::{BakeFailure, BakeFinished, BakeProgress, BakeScene};
pub use casters::ProbelightShadowCaster;
pub use instance::{Probelight, ProbelightInstance};
pub use lights::ProbelightIgnore;
pub use loader::{LoadError, ProbelightLoader};
pub use mover_material::{GridLight, GridLitMaterial};
pub use movers::ProbelightMover;
pub use plugin::{ProbelightPlugin, ProbelightSystems};
pub use render::RenderScenes;
pub use scene::{ProbelightScene, ScenePart};
pub use settings::{ProbelightSettings, ProbelightSky};

pub use {probelight_asset, probelight_math, probelight_runtime, probelight_scene};
#[cfg(feature = "bake")]
pub use {probelight_bake, probelight_trace};
