//! What Probelight computes each frame, on the CPU or on a GPU: indirect light that follows lights, sky and materials.
//!
//! ```text
//!  lights, sky, materials ─► light_surfels ─► relight_probes ─► project_clusters ─► gather_receivers
//!                               ▲   │ signals        λ             ▲      b                │ E
//!                               │   └──────────────────────────────┘                       │
//!                               └───────────────── dilate_lightmap ◄───────────────────────┘
//! ```
//!
//! A [`Runtime`] holds a baked scene. Change its lighting or materials, [`step`](Runtime::step) once per frame
//! (each step adds one bounce) and read the [`IrradianceLightmap`]; or [`converge`](Runtime::converge) for a
//! still picture.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use std::sync::Arc;
//!
//! use probelight_asset::BakedScene;
//! use probelight_math::glam::Vec3;
//! use probelight_runtime::{FrameInput, Runtime};
//! use probelight_scene::{Light, Lighting, Sky};
//!
//! let baked = BakedScene::read("atrium.plight".as_ref())?;
//! let mut runtime = Runtime::new(Arc::new(baked));
//!
//! let sun = Light::Directional { direction: Vec3::new(0.3, -0.9, 0.1).normalize(), irradiance: Vec3::splat(4.0) };
//! let sky = Sky::Uniform(Vec3::new(0.4, 0.6, 1.0));
//! runtime.set_lighting(Lighting { lights: vec![sun], sky, ..Lighting::default() })?;
//! runtime.set_base_color(0, Vec3::new(0.8, 0.1, 0.1))?;
//!
//! let timings = runtime.step(&FrameInput::default());
//! println!("one frame: {:?}", timings.frame);
//!
//! let convergence = runtime.converge(1e-3, 100);
//! println!("converged after {} bounces", convergence.steps);
//! let on_the_floor = runtime.irradiance_at(Vec3::ZERO, Vec3::Y);
//! println!("irradiance there: {on_the_floor:?} W/m²");
//! # Ok(())
//! # }
//! ```
//!
//! `gpu::GpuRuntime` is the same on a GPU, with a device and command encoders of the caller's.
//!
//! Both compute what a [`FramePlan`] says: everything, or less by [`LodSettings`] and what [`FrameInput`] tells about the
//! frame.
//!
//! | feature | on by default | what it brings |
//! | --- | --- | --- |
//! | `cpu` | yes | `Runtime`, with shadow rays and threads |
//! | `gpu` | yes | `gpu::GpuRuntime`, by Vulkan, Metal, Direct3D 12 or WebGPU |
//! | `blocking` | yes | functions that wait for the GPU: constructors, reading back, measuring |
//!
//! In browsers (`wasm32-unknown-unknown`) take `gpu` alone, and `probelight-asset` and `probelight-scene` without default
//! features.
//!
//! The lightmap holds what arrives by way of surfels and probes: light that bounced, the sky, emissive surfaces.
//! Renderers add the direct light of the analytic lights, which is sharper than a lightmap could hold.

mod convergence;
#[cfg(feature = "cpu")]
pub mod cpu;
#[cfg(feature = "cpu")]
mod doors;
mod emissive_discs;
mod error;
mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
mod grid_light;
mod grid_places;
mod irradiance_grid;
mod irradiance_lightmap;
#[cfg(feature = "cpu")]
mod lightmap_position;
mod object_spheres;
mod objects;
#[cfg(feature = "cpu")]
mod runtime;
mod scene_state;
#[cfg(feature = "cpu")]
mod shadow_turns;
mod sky_signals;
mod spread_points;
mod surface_colors;
mod surfels_of_texels;
pub mod synthetic;

pub use convergence::Convergence;
#[cfg(feature = "cpu")]
pub use doors::Ways;
pub use emissive_discs::EmissiveDisc;
pub use error::RuntimeError;
pub use frame::{
    Budget, ClusterExtent, FADE_STEPS, FrameInput, FramePlan, LodChanges, LodGovernor, LodLevel, LodPreset,
    LodSettings, LodZones, PerStage, Planner, ProbeExtent, SimilaritySearch, Stage, StageTimings, View,
    Workload, stage_bytes,
};
pub use grid_light::{GridLight, Lamp};
pub use grid_places::GridPlaces;
pub use irradiance_grid::IrradianceGrid;
pub use irradiance_lightmap::IrradianceLightmap;
#[cfg(feature = "cpu")]
pub use lightmap_position::lightmap_position;
pub use object_spheres::{ObjectInfluence, ObjectSphere, SPHERES_PER_OBJECT};
pub use objects::{ObjectId, Objects};
#[cfg(feature = "cpu")]
pub use runtime::Runtime;
#[cfg(feature = "cpu")]
pub use shadow_turns::{ShadowTurn, ShadowWork};
pub use surface_colors::SurfaceColors;

/// The code of the page for those who write renderers is compiled with the examples of this documentation.
#[cfg(all(doctest, feature = "gpu"))]
#[doc = include_str!("../../../docs/your-renderer.md")]
struct YourRenderer;
