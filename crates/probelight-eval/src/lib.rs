//! How far Probelight is from reference data.
//!
//! [`ReferencePoints`] reads path-traced irradiance at points of a scene; [`PointErrors`] compares predictions
//! with it, row by row; [`FloorErrors`] tells the light transport's part in them; [`write_predictions`] keeps them. [`BorderJumps`] measures the seams between clusters.
//! [`relative_mse`], [`ssim`] and [`flip`] compare images.
//!
//! Predictions are an argument, so that anything that answers "what irradiance arrives here?" can be held
//! against the same reference.

mod border_jumps;
mod error;
mod flip;
mod floor_errors;
mod image_metrics;
mod percentile;
mod point_errors;
#[cfg(feature = "files")]
mod predictions;
mod reference_points;

pub use border_jumps::BorderJumps;
pub use error::EvalError;
pub use flip::flip;
pub use floor_errors::FloorErrors;
pub use image_metrics::{ImageView, relative_mse, ssim};
pub use point_errors::{COMPARED, PointErrors, PointSelection, SMALL_TRIANGLE, largest_irradiance};
#[cfg(feature = "files")]
pub use predictions::write_predictions;
pub use reference_points::{PointKind, ReferencePoint, ReferencePoints, Sampling};
