//! A setup for a scene that came without one.

use std::f32::consts::FRAC_PI_4;

use probelight_math::glam::Vec3;

use super::Setup;
use crate::{Camera, Lighting, Scene, Sky};

/// Radiance of the sky over a scene that has no light of its own, W·m⁻²·sr⁻¹.
const DEFAULT_SKY_RADIANCE: f32 = 1.0;

impl Setup {
    /// The scene's own lights, emission and cameras. A scene without any light gets a soft uniform sky, one
    /// without camera a view of the whole scene.
    pub fn from_scene(scene: &Scene) -> Self {
        let is_dark = scene.lights.is_empty() && scene.emissive_triangles().is_empty();
        let sky = if is_dark { Sky::Uniform(Vec3::splat(DEFAULT_SKY_RADIANCE)) } else { Sky::default() };
        let cameras =
            if scene.cameras.is_empty() { vec![framing_camera(scene)] } else { scene.cameras.clone() };
        Self {
            name: "from the scene".into(),
            scene: String::new(),
            lighting: Lighting { lights: scene.lights.clone(), sky, ..Lighting::default() },
            cameras,
            eval_bounds: None,
        }
    }
}

/// A camera that sees the sphere around the scene, from the front, a little to the right and above.
fn framing_camera(scene: &Scene) -> Camera {
    let bounds = scene.bounds();
    let target = bounds.min.midpoint(bounds.max);
    let vertical_fov = FRAC_PI_4;
    let distance = (0.5 * bounds.diagonal()).max(1e-3) / (0.5 * vertical_fov).sin();
    Camera {
        name: "overview".into(),
        position: target + Vec3::new(0.4, 0.5, 1.0).normalize() * distance,
        target,
        up: Vec3::Y,
        vertical_fov,
        width: 640,
        height: 480,
    }
}
