//! What users change between frames, and what that makes stale.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::{Light, Lighting, Sky};

use crate::{RuntimeError, SurfaceColors};

/// Present lighting and colours.
#[derive(Clone, Debug)]
pub(crate) struct SceneState {
    pub(crate) lighting: Lighting,
    pub(crate) colors: Vec<SurfaceColors>,
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
            stale: Stale { direct: true, shading: true, sky: true },
        }
    }

    pub(crate) fn set_lighting(&mut self, lighting: Lighting) -> Result<(), RuntimeError> {
        check_lighting(&lighting)?;
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

    /// What the coming frame must renew; afterwards nothing is stale.
    pub(crate) fn take_stale(&mut self) -> Stale {
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

/// Whether a lighting can be added to what is there: NaN and infinity would stay in the feedback forever.
pub(crate) fn check_lighting(lighting: &Lighting) -> Result<(), RuntimeError> {
    let refuse = |what: String| Err(RuntimeError::InvalidLighting { what });
    let is_light = |light: Vec3| light.is_finite() && light.min_element() >= 0.0;
    for (index, light) in lighting.lights.iter().enumerate() {
        let (power, place) = match light {
            Light::Point { position, intensity } => (intensity, position.is_finite()),
            Light::Spot { position, direction, intensity, inner_angle, outer_angle } => {
                let angles = inner_angle.is_finite() && outer_angle.is_finite();
                (intensity, position.is_finite() && direction.is_normalized() && angles)
            }
            Light::Directional { direction, irradiance } => (irradiance, direction.is_normalized()),
        };
        if !(is_light(*power) && place) {
            return refuse(format!("light {index}"));
        }
    }
    let is_sky = match lighting.sky {
        Sky::Uniform(radiance) => is_light(radiance),
        Sky::Gradient { zenith, horizon, ground } => [zenith, horizon, ground].into_iter().all(is_light),
    };
    if !is_sky {
        return refuse("the sky".into());
    }
    if !(lighting.emissive_scale.is_finite() && lighting.emissive_scale >= 0.0) {
        return refuse("the factor on emission".into());
    }
    Ok(())
}
