//! Light sources: analytic lights, the sky, and how strongly emissive materials shine.

use probelight_math::glam::Vec3;
use serde::{Deserialize, Serialize};

/// An analytic light without size. Units are radiometric, per linear Rec. 709 channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// Shines equally in all directions: E = I cosθ / d².
    Point {
        /// World position, metres.
        position: Vec3,
        /// Radiant intensity I, W/sr.
        intensity: Vec3,
    },
    /// A cone with the angular falloff of `KHR_lights_punctual`.
    Spot {
        /// World position, metres.
        position: Vec3,
        /// Unit vector along the cone's axis, away from the light.
        direction: Vec3,
        /// Radiant intensity inside the inner cone, W/sr.
        intensity: Vec3,
        /// Half angle within which the intensity is full, radians.
        inner_angle: f32,
        /// Half angle beyond which there is no light, radians.
        outer_angle: f32,
    },
    /// Light from infinitely far away, such as the sun: E = irradiance · cosθ.
    Directional {
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a surface facing the light, W/m².
        irradiance: Vec3,
    },
}

/// What a surface point receives from one light, before any shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Unit vector from the point towards the light.
    pub to_light: Vec3,
    /// Distance to the light, metres; infinite for directional lights.
    pub distance: f32,
    /// Irradiance on a surface that faces the light, W/m² (multiply by cosθ and visibility).
    pub irradiance: Vec3,
}

impl Light {
    /// What reaches `point` if nothing is in the way; `None` where the light does not shine.
    #[inline]
    pub fn illuminate(&self, point: Vec3) -> Option<Illumination> {
        let (position, intensity) = match self {
            Self::Directional { direction, irradiance } => {
                return Some(Illumination {
                    to_light: -*direction,
                    distance: f32::INFINITY,
                    irradiance: *irradiance,
                });
            }
            Self::Point { position, intensity } | Self::Spot { position, intensity, .. } => {
                (*position, *intensity)
            }
        };
        let offset = position - point;
        let squared = offset.length_squared();
        if squared == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let to_light = offset / distance;
        let attenuation = self.cone_attenuation(-to_light);
        (attenuation > 0.0).then(|| Illumination {
            to_light,
            distance,
            irradiance: intensity * (attenuation / squared),
        })
    }

    /// Angular falloff of a spot towards `direction` (unit, away from the light); 1 for other lights.
    #[inline]
    fn cone_attenuation(&self, direction: Vec3) -> f32 {
        let Self::Spot { direction: axis, inner_angle, outer_angle, .. } = self else { return 1.0 };
        let (cos_inner, cos_outer) = (inner_angle.cos(), outer_angle.cos());
        let scale = 1.0 / (cos_inner - cos_outer).max(0.001);
        let linear = ((axis.dot(direction) - cos_outer) * scale).clamp(0.0, 1.0);
        linear * linear
    }
}

/// Radiance that arrives from outside the scene, W·m⁻²·sr⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sky {
    /// The same radiance from every direction; black when there is no sky.
    Uniform(Vec3),
    /// A blend by elevation: from `horizon` up to `zenith` with the sine of the elevation, and down to
    /// `ground` at the nadir.
    Gradient {
        /// Radiance straight up.
        zenith: Vec3,
        /// Radiance at the horizon.
        horizon: Vec3,
        /// Radiance straight down.
        ground: Vec3,
    },
}

impl Default for Sky {
    fn default() -> Self {
        Self::Uniform(Vec3::ZERO)
    }
}

impl Sky {
    /// Radiance arriving from the unit vector `direction`.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Uniform(radiance) => *radiance,
            Self::Gradient { zenith, horizon, ground } => {
                let end = if direction.y >= 0.0 { zenith } else { ground };
                horizon.lerp(*end, direction.y.abs())
            }
        }
    }

    /// True if no light comes from the sky.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Uniform(radiance) => *radiance == Vec3::ZERO,
            Self::Gradient { zenith, horizon, ground } => *zenith + *horizon + *ground == Vec3::ZERO,
        }
    }
}

/// All light sources of one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Analytic lights.
    pub lights: Vec<Light>,
    /// Light from outside the scene.
    pub sky: Sky,
    /// Factor on the emission of every material; 0 switches emissive surfaces off.
    pub emissive_scale: f32,
}

impl Default for Lighting {
    /// Darkness, but for emissive surfaces at their own strength.
    fn default() -> Self {
        Self { lights: Vec::new(), sky: Sky::default(), emissive_scale: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn point_light_falls_off_with_the_square_of_distance() {
        let light = Light::Point { position: Vec3::Y, intensity: Vec3::splat(8.0) };
        let lit = light.illuminate(-Vec3::Y).unwrap();
        assert_eq!((lit.to_light, lit.distance, lit.irradiance), (Vec3::Y, 2.0, Vec3::splat(2.0)));
        assert_eq!(light.illuminate(Vec3::Y), None);
    }

    #[test]
    fn spot_is_full_inside_and_dark_outside_its_cones() {
        let (inner, outer) = (0.2f32, 0.4f32);
        let spot = Light::Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Vec3::ONE,
            inner_angle: inner,
            outer_angle: outer,
        };
        let at = |angle: f32| spot.illuminate(Vec3::new(angle.sin(), 0.0, angle.cos()));
        assert!((at(0.19).unwrap().irradiance.x - 1.0).abs() < 1e-5);
        assert_eq!(at(0.41), None);
        let between = at(0.3).unwrap().irradiance.x;
        let linear = (0.3f32.cos() - outer.cos()) / (inner.cos() - outer.cos());
        assert!((between - linear * linear).abs() < 1e-4);
    }

    #[test]
    fn gradient_sky_meets_its_three_colours() {
        let sky = Sky::Gradient { zenith: Vec3::X, horizon: Vec3::Y, ground: Vec3::Z };
        assert_eq!(sky.radiance(Vec3::Y), Vec3::X);
        assert_eq!(sky.radiance(Vec3::X), Vec3::Y);
        assert_eq!(sky.radiance(-Vec3::Y), Vec3::Z);
    }
}
