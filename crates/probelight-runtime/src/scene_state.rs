//! What users change between frames, and what that makes stale.

use std::borrow::Cow;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::{Lighting, Scene};

use crate::emissive_discs::EmissiveDiscs;
use crate::{Objects, RuntimeError, SurfaceColors};

/// Present lighting, colours and objects.
#[derive(Clone, Debug)]
pub(crate) struct SceneState {
    pub(crate) lighting: Lighting,
    pub(crate) colors: Vec<SurfaceColors>,
    /// Whether surfaces pass on what they receive.
    pub(crate) bounces: bool,
    pub(crate) objects: Objects,
    pub(crate) discs: EmissiveDiscs,
    pub(crate) stale: Stale,
}

/// What changed since the last frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stale {
    /// Analytic lights: direct light is needed anew.
    pub(crate) direct: bool,
    /// Anything else that surfaces shine with.
    pub(crate) shading: bool,
    /// The sky.
    pub(crate) sky: bool,
}

impl Stale {
    pub(crate) const NOTHING: Self = Self { direct: false, shading: false, sky: false };
}

impl SceneState {
    /// The lights and colours of the scene's file, a black sky; everything is stale.
    pub(crate) fn new(baked: &BakedScene) -> Self {
        Self {
            lighting: Lighting { lights: baked.scene.lights.clone(), ..Lighting::default() },
            colors: SurfaceColors::of(&baked.scene),
            bounces: true,
            objects: Objects::default(),
            discs: EmissiveDiscs::default(),
            stale: Stale { direct: true, shading: true, sky: true },
        }
    }

    pub(crate) fn set_lighting(&mut self, lighting: Lighting) -> Result<(), RuntimeError> {
        // NaN and infinity would stay in the feedback forever.
        lighting.validate()?;
        self.stale.direct |= lighting.lights != self.lighting.lights;
        self.stale.shading |= lighting.emissive_scale != self.lighting.emissive_scale;
        self.stale.sky |= lighting.sky != self.lighting.sky;
        self.lighting = lighting;
        Ok(())
    }

    pub(crate) fn set_base_color(&mut self, material: usize, base_color: Vec3) -> Result<(), RuntimeError> {
        let colors = checked(&mut self.colors, material, base_color, "base colour")?;
        self.stale.shading |= colors.base_color != base_color;
        colors.base_color = base_color;
        Ok(())
    }

    pub(crate) fn set_emission(&mut self, material: usize, radiance: Vec3) -> Result<(), RuntimeError> {
        let colors = checked(&mut self.colors, material, radiance, "emission")?;
        self.stale.shading |= colors.emission != radiance;
        colors.emission = radiance;
        Ok(())
    }

    pub(crate) fn set_bounces(&mut self, bounces: bool) {
        self.stale.shading |= bounces != self.bounces;
        self.bounces = bounces;
    }

    /// The colours with which surfaces light each other.
    pub(crate) fn bouncing_colors(&self) -> Cow<'_, [SurfaceColors]> {
        if self.bounces {
            return Cow::Borrowed(&self.colors);
        }
        self.colors.iter().map(|colors| SurfaceColors { base_color: Vec3::ZERO, ..*colors }).collect()
    }

    /// What the coming frame must renew; afterwards nothing is stale.
    pub(crate) fn take_stale(&mut self, scene: &Scene) -> Stale {
        if self.stale.shading {
            self.discs.update(scene, &self.colors, self.lighting.emissive_scale);
        }
        std::mem::replace(&mut self.stale, Stale::NOTHING)
    }
}

/// The colours of an existing material, if `color` is one that a surface can have.
fn checked<'a>(
    colors: &'a mut [SurfaceColors],
    material: usize,
    color: Vec3,
    quantity: &'static str,
) -> Result<&'a mut SurfaceColors, RuntimeError> {
    if !(color.is_finite() && color.min_element() >= 0.0) {
        return Err(RuntimeError::InvalidColor { quantity, material });
    }
    let count = colors.len();
    colors.get_mut(material).ok_or(RuntimeError::UnknownMaterial { material, count })
}
