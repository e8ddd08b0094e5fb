//! Pictures on the CPU: primary rays, direct light with shadows, indirect light from the lightmap, and
//! what it takes to look at the result.
//!
//! | module | job |
//! | --- | --- |
//! | `renderer` | radiance (or raw irradiance) seen by a camera: `render` |
//! | [`image`] | [`Image`]: linear RGB pixels |
//! | [`tone_map`] | exposure and a filmic curve: [`DisplayImage`] from [`Image`] |
//! | [`display_image`] | [`DisplayImage`]: 8-bit sRGB pixels |
//! | `image_files` | their files: OpenEXR and PNG |
//! | [`comparison`] | signed difference pictures |
//! | [`contact_sheet`] | pictures side by side with titles |
//!
//! | feature | on by default | what it brings |
//! | --- | --- | --- |
//! | `cpu` | yes | `render`, with rays and threads |
//! | `gpu` | yes | the module `gpu`, by Vulkan, Metal, Direct3D 12 or WebGPU |
//! | `blocking` | yes | functions that wait for the GPU |
//! | `files` | yes | PNG and OpenEXR files |
//!
//! In browsers (`wasm32-unknown-unknown`) take `gpu` alone.

pub mod comparison;
pub mod contact_sheet;
pub mod display_image;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
#[cfg(feature = "files")]
pub mod image_files;
#[cfg(feature = "cpu")]
mod pixel_filter;
#[cfg(feature = "cpu")]
pub mod renderer;
pub mod tone_map;

pub use contact_sheet::ContactSheet;
pub use display_image::DisplayImage;
pub use image::Image;
#[cfg(feature = "files")]
pub use image_files::ImageError;
#[cfg(feature = "cpu")]
pub use pixel_filter::PixelFilter;
#[cfg(feature = "cpu")]
pub use renderer::{RenderOptions, RenderOutput, Surfaces, View, render};
pub use tone_map::{Exposure, ToneMap};
