//! Rays against a scene: BVH traversal, visibility, and the reference path tracer.

mod progress;
mod tracer;

pub use progress::{Progress, Silent};
pub use tracer::{Hit, Ray, Tracer};
