//! Rays against a scene: BVH traversal, visibility, and the reference path tracer.

mod direct_light;
mod path_tracer;
mod progress;
mod tracer;
mod wide_bvh;
mod world;

pub use direct_light::{direct_irradiance, shadow_ray, smooth_direct_irradiance};
pub use path_tracer::{PathTracer, PointIrradiance};
pub use progress::{Cancelled, Progress, Silent};
pub use tracer::{Hit, Ray, Tracer};
pub use world::{Occluder, TracedObject, World, WorldHit};
