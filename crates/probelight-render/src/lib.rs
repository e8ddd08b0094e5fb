//! Pictures on the CPU: primary rays, direct light with shadows, indirect light from the lightmap, and
//! what it takes to look at the result.
//!
//! | module | job |
//! | --- | --- |
//! | [`renderer`] | radiance (or raw irradiance) seen by a camera: [`render`] |
//! | [`image`] | [`Image`]: linear RGB pixels; OpenEXR files |
//! | [`tone_map`] | exposure and a filmic curve: [`DisplayImage`] from [`Image`] |
//! | [`display_image`] | [`DisplayImage`]: 8-bit sRGB pixels; PNG files |
//! | [`comparison`] | signed difference pictures |
//! | [`contact_sheet`] | pictures side by side with titles |

pub mod comparison;
pub mod contact_sheet;
pub mod display_image;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
mod pixel_filter;
pub mod renderer;
pub mod tone_map;

pub use contact_sheet::ContactSheet;
pub use display_image::DisplayImage;
pub use image::{Image, ImageError};
pub use pixel_filter::PixelFilter;
pub use renderer::{RenderOptions, RenderOutput, Surfaces, View, render};
pub use tone_map::{Exposure, ToneMap};
