//! The parts of a baked file that are JSON.

use probelight_scene::{Camera, Light, Material, Scene, Texture, Warning};
use serde::{Deserialize, Serialize};

use crate::error::DecodeError;
use crate::textures::TextureEntry;
use crate::{BakeReport, BakeSettings, BakedParts};

/// What the section `info` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct InfoSection {
    pub(crate) scene_hash: u64,
    pub(crate) lightmap_width: u32,
    pub(crate) lightmap_height: u32,
    pub(crate) lightmap_pages: u32,
    pub(crate) settings: BakeSettings,
    pub(crate) report: BakeReport,
}

impl InfoSection {
    pub(crate) fn of(baked: &BakedParts) -> Self {
        Self {
            scene_hash: baked.scene_hash,
            lightmap_width: baked.lightmap.width,
            lightmap_height: baked.lightmap.height,
            lightmap_pages: baked.lightmap.pages,
            settings: baked.settings.clone(),
            report: baked.report.clone(),
        }
    }
}

/// What the section `descript` holds: the scene but for its arrays.
#[derive(Serialize, Deserialize)]
pub(crate) struct DescriptionSection {
    pub(crate) materials: Vec<Material>,
    pub(crate) lights: Vec<Light>,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) textures: Vec<TextureEntry>,
}

impl DescriptionSection {
    pub(crate) fn of(scene: &Scene, textures: Vec<TextureEntry>) -> Self {
        Self {
            materials: scene.materials.clone(),
            lights: scene.lights.clone(),
            cameras: scene.cameras.clone(),
            warnings: scene.warnings.clone(),
            textures,
        }
    }

    /// A scene without arrays.
    pub(crate) fn into_scene(self, textures: Vec<Texture>) -> Scene {
        let Self { materials, lights, cameras, warnings, textures: _ } = self;
        Scene { materials, lights, cameras, warnings, textures, ..Scene::default() }
    }
}

/// Reads a JSON section.
pub(crate) fn decode_json<'a, T: Deserialize<'a>>(name: &str, bytes: &'a [u8]) -> Result<T, DecodeError> {
    serde_json::from_slice(bytes)
        .map_err(|error| DecodeError::Format(format!("its section '{name}' cannot be understood: {error}")))
}
