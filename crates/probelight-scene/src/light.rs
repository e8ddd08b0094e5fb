//! Light sources: analytic lights, the sky, and how strongly emissive materials shine.

use std::f32::consts::PI;

use probelight_math::glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::Unusable;
use crate::unusable::{check_position, check_radiometric};

/// How far from 1 the length of a unit vector may be: a rotation that rounds for hours stays far below.
const UNIT_TOLERANCE: f32 = 1e-3;

/// An analytic light without size. Units are radiometric, per linear Rec. 709 channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// Shines equally in all directions: E = I cosθ / d², times the window of its range.
    Point {
        /// World position, metres.
        position: Vec3,
        /// Radiant intensity I, W/sr.
        intensity: Vec3,
        /// Distance at which its light ends, metres (see [`range_window`]); `None` for light without end.
        range: Option<f32>,
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
        /// Distance at which its light ends, metres (see [`range_window`]); `None` for light without end.
        range: Option<f32>,
    },
    /// Light from infinitely far away, such as the sun: E = irradiance · cosθ.
    Directional {
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a surface facing the light, W/m².
        irradiance: Vec3,
    },
}

/// Share of a light's irradiance that its `range` (metres) leaves at a squared distance (m²): 1 − (d / range)⁴, and
/// never below 0. `KHR_lights_punctual` has it so that the light of lamps ends somewhere; without range it is 1.
#[inline]
pub fn range_window(squared_distance: f32, range: Option<f32>) -> f32 {
    let Some(range) = range else { return 1.0 };
    let share = squared_distance / (range * range);
    (1.0 - share * share).max(0.0)
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
        let (position, intensity, range) = match self {
            Self::Directional { direction, irradiance } => {
                return Some(Illumination {
                    to_light: -*direction,
                    distance: f32::INFINITY,
                    irradiance: *irradiance,
                });
            }
            Self::Point { position, intensity, range } | Self::Spot { position, intensity, range, .. } => {
                (*position, *intensity, *range)
            }
        };
        let offset = position - point;
        let squared = offset.length_squared();
        if squared == 0.0 {
            return None;
        }
        let distance = squared.sqrt();
        let to_light = offset / distance;
        let attenuation = self.cone_attenuation(-to_light) * range_window(squared, range);
        (attenuation > 0.0).then(|| Illumination {
            to_light,
            distance,
            irradiance: intensity * (attenuation / squared),
        })
    }

    /// Where it is, metres; `None` if it is infinitely far away.
    pub fn position(&self) -> Option<Vec3> {
        match self {
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(*position),
            Self::Directional { .. } => None,
        }
    }

    /// Where it shines: a unit vector; `None` if that is all around.
    pub fn direction(&self) -> Option<Vec3> {
        match self {
            Self::Directional { direction, .. } | Self::Spot { direction, .. } => Some(*direction),
            Self::Point { .. } => None,
        }
    }

    /// Intensity, W/sr, or irradiance, W/m².
    pub fn strength(&self) -> Vec3 {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => *intensity,
            Self::Directional { irradiance, .. } => *irradiance,
        }
    }

    /// The same, to change it.
    pub fn strength_mut(&mut self) -> &mut Vec3 {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
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

    /// Checks that the light's numbers mean something. [`Lighting::validate`] does so for all.
    ///
    /// # Errors
    /// [`Unusable`] if a number is not finite, an intensity or irradiance is negative, a direction is no unit vector,
    /// a spot's angles are not 0 ≤ inner ≤ outer ≤ π, or a range is not positive.
    pub fn validate(&self) -> Result<(), Unusable> {
        match self {
            Self::Directional { direction, irradiance } => {
                check_unit(*direction)?;
                check_radiometric("irradiance", *irradiance)
            }
            Self::Point { position, intensity, range } => check_lamp(*position, *intensity, *range),
            Self::Spot { position, direction, intensity, inner_angle, outer_angle, range } => {
                check_lamp(*position, *intensity, *range)?;
                check_unit(*direction)?;
                let ordered = (0.0..=*outer_angle).contains(inner_angle) && *outer_angle <= PI;
                Unusable::unless(ordered, || {
                    format!(
                        "its angles are {inner_angle} and {outer_angle}; 0 ≤ inner ≤ outer ≤ π is allowed"
                    )
                })
            }
        }
    }
}

fn check_lamp(position: Vec3, intensity: Vec3, range: Option<f32>) -> Result<(), Unusable> {
    check_position("position", position)?;
    check_radiometric("intensity", intensity)?;
    let is_positive = range.is_none_or(|range| range.is_finite() && range > 0.0);
    Unusable::unless(is_positive, || {
        format!("its range is {} m; it must be positive, or absent", range.unwrap_or_default())
    })
}

fn check_unit(direction: Vec3) -> Result<(), Unusable> {
    let is_unit = (direction.length() - 1.0).abs() <= UNIT_TOLERANCE;
    Unusable::unless(is_unit, || format!("its direction is {direction}; it must have length 1"))
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

    /// Checks that the sky's numbers mean something.
    ///
    /// # Errors
    /// [`Unusable`] if a radiance is negative or not finite.
    pub fn validate(&self) -> Result<(), Unusable> {
        match self {
            Self::Uniform(radiance) => check_radiometric("radiance", *radiance),
            Self::Gradient { zenith, horizon, ground } => {
                let parts = [("zenith", zenith), ("horizon", horizon), ("ground", ground)];
                parts.iter().try_for_each(|(name, radiance)| check_radiometric(name, **radiance))
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

impl Lighting {
    /// Checks every light, the sky and the emissive scale. Whoever takes lights from outside calls it: light that is
    /// not a number would be reflected on and on, and never leave again.
    ///
    /// # Errors
    /// [`Unusable`], naming the first light or part that makes no sense and what is allowed.
    pub fn validate(&self) -> Result<(), Unusable> {
        for (l, light) in self.lights.iter().enumerate() {
            light.validate().map_err(|unusable| unusable.of(format_args!("light {l}")))?;
        }
        self.sky.validate().map_err(|unusable| unusable.of("the sky"))?;
        let scale = self.emissive_scale;
        let allowed = scale.is_finite() && scale >= 0.0;
        Unusable::unless(allowed, || {
            format!("the emissive scale is {scale}; it must be finite and not negative")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(range: Option<f32>) -> Light {
        Light::Point { position: Vec3::ZERO, intensity: Vec3::splat(16.0), range }
    }

    #[test]
    fn range_is_the_window_of_the_gltf_extension() {
        let at =
            |light: &Light, distance: f32| light.illuminate(Vec3::X * distance).map(|lit| lit.irradiance.x);
        // 16 / d² · (1 − (d / 2)⁴)
        let near = lamp(Some(2.0));
        assert!((at(&near, 1.0).unwrap() - 15.0).abs() < 1e-5);
        assert!((at(&near, 0.5).unwrap() - 64.0 * (1.0 - 1.0 / 256.0)).abs() < 1e-3);
        assert_eq!([at(&near, 2.0), at(&near, 2.5)], [None; 2]);
        for distance in [0.1, 1.0, 7.3, 1e6] {
            assert_eq!(at(&lamp(None), distance), Some(16.0 / (distance * distance)));
        }
    }

    #[test]
    fn light_that_makes_no_sense_is_refused_with_its_index() {
        let spot = |inner_angle, outer_angle, direction| Light::Spot {
            position: Vec3::ZERO,
            direction,
            intensity: Vec3::ONE,
            inner_angle,
            outer_angle,
            range: None,
        };
        let sun = |direction, irradiance| Light::Directional { direction, irradiance };
        let good = vec![lamp(Some(3.0)), spot(0.1, 0.2, Vec3::X), sun(Vec3::Y, Vec3::ZERO)];
        let mut lighting = Lighting { lights: good, sky: Sky::Uniform(Vec3::ONE), emissive_scale: 2.0 };
        assert_eq!(lighting.validate(), Ok(()));
        for (light, message) in [
            (lamp(Some(0.0)), "its range is 0 m"),
            (lamp(Some(f32::NAN)), "its range is NaN m"),
            (Light::Point { position: Vec3::NAN, intensity: Vec3::ONE, range: None }, "position"),
            (Light::Point { position: Vec3::X, intensity: Vec3::INFINITY, range: None }, "intensity"),
            (
                Light::Point { position: Vec3::X, intensity: Vec3::new(1.0, -1e-9, 0.0), range: None },
                "intensity",
            ),
            (spot(0.3, 0.2, Vec3::X), "its angles are 0.3 and 0.2"),
            (spot(f32::NAN, 0.2, Vec3::X), "its angles"),
            (spot(0.1, 4.0, Vec3::X), "its angles"),
            (spot(0.1, 0.2, Vec3::splat(1.0)), "its direction is [1, 1, 1]; it must have length 1"),
            (sun(Vec3::NAN, Vec3::ONE), "its direction"),
            (sun(Vec3::X, Vec3::NEG_ONE), "its irradiance"),
        ] {
            lighting.lights[1] = light;
            let reason = lighting.validate().unwrap_err().reason;
            assert!(reason.starts_with("light 1: ") && reason.contains(message), "{reason}");
        }
        let of = |sky, emissive_scale| Lighting { lights: Vec::new(), sky, emissive_scale }.validate();
        let dark = Sky::default();
        assert!(of(dark, -1.0).unwrap_err().reason.contains("the emissive scale is -1"));
        assert!(of(dark, f32::INFINITY).unwrap_err().reason.contains("the emissive scale is inf"));
        assert!(of(Sky::Uniform(Vec3::NAN), 1.0).unwrap_err().reason.contains("the sky: its radiance"));
        let below = Sky::Gradient { zenith: Vec3::ONE, horizon: Vec3::ONE, ground: Vec3::NEG_ONE };
        assert!(of(below, 1.0).unwrap_err().reason.contains("the sky: its ground"));
    }

    #[test]
    fn point_light_falls_off_with_the_square_of_distance() {
        let light = Light::Point { position: Vec3::Y, intensity: Vec3::splat(8.0), range: None };
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
            range: None,
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
