//! The reference path tracer: slow, unbiased, and the truth that everything faster is held against.
//!
//! Surfaces are two-sided opaque Lambertian reflectors with the base colour as albedo and geometric normals;
//! emissive triangles shine from their front face. At every vertex of a path, analytic lights are summed
//! with shadow rays, one point on an emissive triangle is sampled, and the path goes on in a cosine-
//! distributed direction that may find emitters and the sky by itself; the two ways to find an emitter are
//! combined by the balance heuristic (Veach 1997, §9.2). Paths end by Russian roulette only.

mod emitters;
mod integrator;
mod irradiance;
mod render;
mod sampler;

use std::sync::Arc;

use probelight_scene::Lighting;

use crate::Tracer;
use emitters::Emitters;

pub use irradiance::PointIrradiance;

/// Estimates radiance and irradiance in a lit scene by tracing paths.
pub struct PathTracer {
    tracer: Arc<Tracer>,
    lighting: Lighting,
    emitters: Emitters,
}

impl PathTracer {
    /// Prepares to sample the emissive triangles of the tracer's scene under `lighting`.
    pub fn new(tracer: Arc<Tracer>, lighting: Lighting) -> Self {
        let emitters = Emitters::new(tracer.scene(), lighting.emissive_scale);
        Self { tracer, lighting, emitters }
    }

    /// The scene's tracer.
    pub fn tracer(&self) -> &Arc<Tracer> {
        &self.tracer
    }

    /// The light sources.
    pub fn lighting(&self) -> &Lighting {
        &self.lighting
    }
}
