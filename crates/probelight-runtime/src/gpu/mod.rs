//! The stages of a frame on the GPU, and what they need.
//!
//! ```text
//!  lights ─► shadow_maps ─► light_surfels ─► relight_probes ─► project_clusters ─► gather_receivers
//!                              ▲   │ signals        λ             ▲      b                │ E
//!                              │   └──────────────────────────────┘                       │
//!                              └──────────────────────────────────────────────────────────┤
//!                                             lightmap ◄─ reduce_lightmap ◄─ dilate_lightmap
//! ```
//!
//! A [`GpuRuntime`] is the twin of `Runtime`: the same stages under the same names, their shaders in
//! `src/shaders`. Each stage can run by itself ([`GpuRuntime::encode_stage`]), which is how tests compare it with the CPU's.
//!
//! Nothing on the way of a frame or of a change of light waits for the GPU. What waits (opening it, reading back,
//! measuring) needs the feature `blocking`. Browsers cannot wait; for them what is called `open` or `read_lightmap` has
//! an `async` twin called `open_async` or `read_lightmap_async`.
//!
//! | module | job |
//! | --- | --- |
//! | [`device`] | finds a GPU and opens it; errors |
//! | [`gpu_runtime`] | the runtime |
//! | [`frame_buffers`] | what the stages hand to each other |
//! | `exchange` | reading it, and replacing it in tests |
//! | `light_surfels` … `reduce_lightmap` | a stage each |
//! | `surfel_shards`, `surfel_groups`, `cluster_shards` | the baked scene, arranged for the shaders |
//! | `plan`, `frame_extents`, `frame_work`, `choose_work` | how much of it a frame computes, and what of that is new |
//! | [`stage_shaders`], `kernel`, `storage`, [`filled_buffer`] | shaders, what they are bound to, buffers |
//! | [`bindings`] | bind groups of resources in their order |
//! | [`timestamps`], `stage_bytes`, `benchmark` | how long stages take, what they move, and what the memory allows |
//! | [`scene_geometry`] | the scene's triangles, for shadows and renderers |
//! | [`grid_tables`] | the grid in free space, for shaders |
//! | [`moving_geometry`] | the triangles of objects, and where these are |
//! | [`shadow_views`] | what each light sees the scene through; light records |
//! | `eye_views` | views of lights that are fitted to what a picture shows |
//! | [`shadow_maps`] | depth as lights see it (drawn by `cast_shadows`); visibility for any shader |
//! | [`shaders`] | sources to build shaders from |
//! | [`readback`] | copies to the CPU, for pictures and tests |

#[cfg(feature = "blocking")]
pub mod benchmark;
pub mod bindings;
mod blend_borders;
mod cast_shadows;
mod choose_work;
mod cluster_shards;
mod converge;
pub mod device;
mod dilate_lightmap;
mod exchange;
mod eye_views;
mod fill_receivers;
pub mod filled_buffer;
pub mod frame_buffers;
mod frame_extents;
mod frame_work;
mod gather_receivers;
pub mod gpu_runtime;
pub mod grid_tables;
mod kernel;
mod light_surfels;
mod lit_points;
pub mod moving_geometry;
mod objects;
mod plan;
mod project_clusters;
pub mod readback;
mod reduce_lightmap;
#[cfg(test)]
#[path = "../../tests/support/reflection.rs"]
pub(crate) mod reflection;
mod relight_probes;
pub mod scene_geometry;
#[cfg(test)]
mod shader_tests;
pub mod shaders;
pub mod shadow_maps;
pub mod shadow_views;
mod stage_bytes;
pub mod stage_shaders;
mod storage;
mod surfel_groups;
mod surfel_shards;
pub mod timestamps;

#[cfg(feature = "blocking")]
pub use benchmark::copy_bandwidth;
pub use device::{GpuDevice, GpuError};
pub use frame_buffers::FrameBuffers;
pub use gpu_runtime::{GpuOptions, GpuRuntime};
pub use grid_tables::GridTables;
pub use moving_geometry::{MovingGeometry, MovingModel};
pub use scene_geometry::{MaterialPart, SceneGeometry};
pub use shadow_maps::{ShadowMapOptions, ShadowMaps};
pub use timestamps::FrameTimestamps;
