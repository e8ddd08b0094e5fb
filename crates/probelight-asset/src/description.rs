//! The parts of a baked file that are JSON.

use probelight_scene::{Camera, Light, Material, Scene, Warning};
use serde::{Deserialize, Serialize};

use crate::{BakeReport, BakeSettings, BakedParts, GridLayout};

/// What the section `info` holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct InfoSection {
    pub(crate) scene_hash: u64,
    pub(crate) lightmap_width: u32,
    pub(crate) lightmap_height: u32,
    pub(crate) lightmap_pages: u32,
    pub(crate) grid: GridLayout,
    /// Bytes of what belongs to the grid alone.
    pub(crate) grid_bytes: u64,
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
            grid: baked.grid,
            grid_bytes: baked.grid_bytes().total(),
            settings: baked.settings.clone(),
            report: baked.report.clone(),
        }
    }

    pub(crate) fn put_into(self, parts: &mut BakedParts) {
        let lightmap = &mut parts.lightmap;
        (lightmap.width, lightmap.height) = (self.lightmap_width, self.lightmap_height);
        lightmap.pages = self.lightmap_pages;
        parts.scene_hash = self.scene_hash;
        parts.grid = self.grid;
        parts.settings = self.settings;
        parts.report = self.report;
    }
}

/// What the section `description` holds: the scene but for its arrays.
#[derive(Serialize, Deserialize)]
pub(crate) struct DescriptionSection {
    materials: Vec<Material>,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    warnings: Vec<Warning>,
    /// Names.
    textures: Vec<String>,
}

impl DescriptionSection {
    pub(crate) fn of(scene: &Scene) -> Self {
        Self {
            materials: scene.materials.clone(),
            lights: scene.lights.clone(),
            cameras: scene.cameras.clone(),
            warnings: scene.warnings.clone(),
            textures: scene.textures.iter().map(|texture| texture.name.clone()).collect(),
        }
    }

    /// Returns the names of the textures, which are still to be read.
    pub(crate) fn put_into(self, scene: &mut Scene) -> Vec<String> {
        scene.materials = self.materials;
        scene.lights = self.lights;
        scene.cameras = self.cameras;
        scene.warnings = self.warnings;
        self.textures
    }
}
