//! What users set for all scenes at once.

use bevy::ecs::resource::Resource;
use bevy::math::Vec3;
use probelight_runtime::{Budget, LodSettings};
use probelight_scene::Sky;

use crate::convert::vec3;
use crate::cube_map::ByElevation;

/// How much is computed, for all scenes.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ProbelightSettings {
    /// Levels of detail around the main camera, the active `Camera3d` of lowest order. By default everything is computed.
    pub lod: LodSettings,
    /// What a frame of each scene may cost.
    pub budget: Option<Budget>,
}

/// The sky, as far as it lights scenes; it is not drawn. Luminance, cd/m² per linear channel.
///
/// A gradient belongs to the world's up, but is taken along with a scene that leans; scenes that are only turned about
/// +Y are lit as they should be.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub enum ProbelightSky {
    /// What surrounds the main camera in Bevy: the source of its [`GeneratedEnvironmentMapLight`], its [`EnvironmentMapLight`]
    /// or its [`Skybox`], the first that it has; black if it has none.
    ///
    /// The cube map is read on the CPU, when it is there and when it changes, and becomes the closest gradient. Maps of
    /// eight bits, half and whole floats and packed floats (`Rgb9e5Ufloat`, `Rg11b10Ufloat`) are read if the main world keeps
    /// their texels; compressed ones and what the GPU draws, such as Bevy's atmosphere, are not.
    ///
    /// [`GeneratedEnvironmentMapLight`]: bevy::light::GeneratedEnvironmentMapLight
    /// [`EnvironmentMapLight`]: bevy::light::EnvironmentMapLight
    /// [`Skybox`]: bevy::light::Skybox
    #[default]
    Environment,
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

impl ProbelightSky {
    /// The sky of a scene, as bright as `scale` times this one.
    pub(crate) fn scaled(&self, environment: &ByElevation, scale: f32) -> Sky {
        let gradient = |zenith, horizon, ground| Sky::Gradient {
            zenith: vec3(zenith) * scale,
            horizon: vec3(horizon) * scale,
            ground: vec3(ground) * scale,
        };
        match *self {
            Self::Environment if *environment == ByElevation::default() => Sky::default(),
            Self::Environment => gradient(environment.zenith, environment.horizon, environment.ground),
            Self::Uniform(radiance) => Sky::Uniform(vec3(radiance) * scale),
            Self::Gradient { zenith, horizon, ground } => gradient(zenith, horizon, ground),
        }
    }
}
