//! The stages of a frame on the GPU.
//!
//! | module | job |
//! | --- | --- |
//! | [`device`] | finds a GPU and opens it; errors |
//! | [`scene_geometry`] | the scene's triangles, for shadows and renderers |
//! | [`shadow_views`] | what each light sees the scene through; light records |
//! | [`shadow_maps`] | draws depth from the lights; visibility for any shader |
//! | [`shaders`] | sources to build shaders from |
//! | [`readback`] | copies to the CPU, for pictures and tests |

pub mod device;
pub mod readback;
pub mod scene_geometry;
pub mod shaders;
pub mod shadow_maps;
pub mod shadow_views;

pub use device::{GpuDevice, GpuError, adapter_names};
pub use scene_geometry::{MaterialPart, SceneGeometry};
pub use shadow_maps::{ShadowMapOptions, ShadowMaps};
