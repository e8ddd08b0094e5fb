//! What users set for all scenes at once.

use bevy::ecs::resource::Resource;
use bevy::math::Vec3;
use probelight_runtime::{Budget, LodSettings};
use probelight_scene::Sky;

use crate::convert::vec3;

/// How much is computed, for all scenes.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ProbelightSettings {
    /// Levels of detail around the main camera, the active `Camera3d` of lowest order. By default everything is computed.
    pub lod: LodSettings,
    /// What a frame of each scene may cost.
    pub budget: Option<Budget>,
}

/// The sky, as far as it lights scenes; it is not drawn. Luminance, cd/m² per linear channel. By default it is black.
///
/// A gradient belongs to the world's up, but is taken along with a scene that leans; scenes that are only turned about
/// +Y are lit as they should be.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub enum ProbelightSky {
    /// The same from everywhere.
    Uniform(Vec3),
    /// Blended by elevation.
    Gradient {
        /// Straight up.
        zenith: Vec3,
        /// At the horizon.
        horizon: Vec3,
        /// Straight down.
        ground: Vec3,
    },
}

impl Default for ProbelightSky {
    fn default() -> Self {
        Self::Uniform(Vec3::ZERO)
    }
}

impl ProbelightSky {
    /// The sky of a scene, as bright as `scale` times this one.
    pub(crate) fn scaled(&self, scale: f32) -> Sky {
        match *self {
            Self::Uniform(radiance) => Sky::Uniform(vec3(radiance) * scale),
            Self::Gradient { zenith, horizon, ground } => Sky::Gradient {
                zenith: vec3(zenith) * scale,
                horizon: vec3(horizon) * scale,
                ground: vec3(ground) * scale,
            },
        }
    }
}
