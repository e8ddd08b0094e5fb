//! Pictures on the GPU, into memory or onto a window through the same code.
//!
//! | module | job |
//! | --- | --- |
//! | [`gpu_renderer`] | [`GpuRenderer`]: draws a lit scene, or what lights it |
//! | [`view`] | what a picture shows |
//! | [`picture_target`] | [`PictureTarget`]: the picture while it is drawn, and its pixels |
//! | [`presenter`] | [`Presenter`]: exposure and tone map, onto a window |
//! | `uploaded_light` | `UploadedLight`: light that the CPU's runtime computed |
//! | `surface_attributes`, `materials`, `material_textures`, `finish`, `moving_surfaces`, `markers`, `cluster_colors` | what is drawn |
//! | `frame_record` | camera, sky and view as shaders read them |
//! | `pipelines`, `shaders` | how it is drawn; WGSL sources |
//!
//! Depth is near / distance: 1 at the eye, 0 infinitely far away, which is where floats are most precise.

mod cluster_colors;
mod finish;
mod frame_record;
pub mod gpu_renderer;
mod markers;
mod material_textures;
mod materials;
mod moving_surfaces;
pub mod picture_target;
mod pipelines;
pub mod presenter;
#[cfg(test)]
#[path = "../../../probelight-runtime/tests/support/reflection.rs"]
pub(crate) mod reflection;
#[cfg(test)]
mod shader_tests;
mod shaders;
mod surface_attributes;
#[cfg(feature = "cpu")]
pub mod uploaded_light;
pub mod view;

pub use gpu_renderer::{GpuRenderer, LitScene};
pub use picture_target::PictureTarget;
pub use presenter::{Coloring, Presenter, Shown};
#[cfg(feature = "cpu")]
pub use uploaded_light::UploadedLight;
pub use view::{GpuView, Shading, ViewOptions};
