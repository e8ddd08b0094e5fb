//! What materials and emitters contribute to light transport.

use probelight_asset::{BakedScene, Emitter};
use probelight_math::glam::Vec3;
use probelight_scene::{Lighting, MaterialColors, Scene};

/// What a material contributes to light transport, before textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceColors {
    /// Linear base colour factor.
    pub base_color: Vec3,
    /// Emitted radiance of the front face, W·m⁻²·sr⁻¹.
    pub emission: Vec3,
}

impl SurfaceColors {
    /// The colours of a scene's materials.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let colors = |m: &probelight_scene::Material| Self {
            base_color: m.base_color.truncate(),
            emission: m.emission,
        };
        scene.materials.iter().map(colors).collect()
    }

    /// The same with the changes of a setup, in their order.
    pub fn changed(scene: &Scene, changes: &[MaterialColors]) -> Vec<Self> {
        let mut colors = Self::of(scene);
        for change in changes {
            for material in change.materials(scene) {
                let colors = &mut colors[material];
                colors.base_color = change.base_color.unwrap_or(colors.base_color);
                colors.emission = change.emission.unwrap_or(colors.emission);
            }
        }
        colors
    }
}

/// Whether emitters carry the emission of each material.
pub(crate) fn has_emitter(baked: &BakedScene) -> Vec<bool> {
    let mut has_emitter = vec![false; baked.scene.materials.len()];
    for emitter in &baked.emitters {
        has_emitter[emitter.material as usize] = true;
    }
    has_emitter
}

/// Mean radiance that an emitter sends out, W·m⁻²·sr⁻¹.
pub(crate) fn emitter_radiance(emitter: &Emitter, lighting: &Lighting, colors: &[SurfaceColors]) -> Vec3 {
    colors[emitter.material as usize].emission * lighting.emissive_scale * emitter.mean_texel
}
