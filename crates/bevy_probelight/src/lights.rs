//! Bevy's lights as Probelight's.
//!
//! Bevy draws a surface of base colour ρ with exposure · (ρ · F · E + ρ · lightmap), E being the irradiance of its lights in
//! lux and F its diffuse lobe, about 1/π. So all sources are passed on times 1/π ([`PER_LUX`]): then what the lightmap holds
//! is E/π, in cd/m², and what surfaces reflect from it is right.

use std::f32::consts::{FRAC_1_PI, PI};

use bevy::ecs::component::Component;
use bevy::light::{DirectionalLight, PointLight, SpotLight};
use bevy::transform::components::GlobalTransform;
use probelight_math::glam::Vec3;
use probelight_scene::Light;

use crate::convert::linear;
use crate::pose::ScenePose;

/// On a light: it does not bounce, in any scene.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ProbelightIgnore;

/// What all sources are multiplied by.
pub(crate) const PER_LUX: f32 = FRAC_1_PI;

/// Bevy's window of a light's range is the square of Probelight's, (1 − (d / r)⁴)². A range shorter by this factor, the fourth
/// root of ½, has the same window as long as (d / r)⁸ is small.
const RANGE: f32 = 0.840_896_4;

/// Candela per channel of a lamp of so many lumens, as Bevy has it for point and spot lights alike, in a scene's own length.
fn intensity(color: bevy::color::Color, lumens: f32, pose: &ScenePose) -> Vec3 {
    let candela = (lumens / (4.0 * PI)).max(0.0);
    // Irradiance stays as it is where lengths are others.
    linear(color) * candela * PER_LUX / (pose.scale() * pose.scale())
}

fn range(meters: f32, pose: &ScenePose) -> Option<f32> {
    let range = RANGE * meters / pose.scale();
    range.is_finite().then(|| range.max(1e-3))
}

/// A point light in a scene.
pub(crate) fn point(light: &PointLight, at: &GlobalTransform, pose: &ScenePose) -> Light {
    Light::Point {
        position: pose.point(at.translation()),
        intensity: intensity(light.color, light.intensity, pose),
        range: range(light.range, pose),
    }
}

/// A spot light in a scene.
pub(crate) fn spot(light: &SpotLight, at: &GlobalTransform, pose: &ScenePose) -> Light {
    let outer_angle = light.outer_angle.clamp(0.0, PI);
    Light::Spot {
        position: pose.point(at.translation()),
        direction: pose.direction(at.forward().as_vec3()),
        intensity: intensity(light.color, light.intensity, pose),
        inner_angle: light.inner_angle.clamp(0.0, outer_angle),
        outer_angle,
        range: range(light.range, pose),
    }
}

/// A directional light in a scene.
pub(crate) fn directional(light: &DirectionalLight, at: &GlobalTransform, pose: &ScenePose) -> Light {
    Light::Directional {
        direction: pose.direction(at.forward().as_vec3()),
        irradiance: linear(light.color) * light.illuminance.max(0.0) * PER_LUX,
    }
}

/// Whether a light shines at all, and has numbers that mean something.
pub(crate) fn is_lit(light: &Light) -> bool {
    let power = match light {
        Light::Point { intensity, .. } | Light::Spot { intensity, .. } => *intensity,
        Light::Directional { irradiance, .. } => *irradiance,
    };
    power != Vec3::ZERO && light.validate().is_ok()
}

#[cfg(test)]
mod tests {
    use bevy::color::Color;
    use bevy::transform::components::Transform;

    use super::*;

    fn pose(scale: f32) -> ScenePose {
        let transform = Transform::from_xyz(5.0, 0.0, 0.0).with_scale(bevy::math::Vec3::splat(scale));
        ScenePose::of(&GlobalTransform::from(transform)).unwrap()
    }

    /// Irradiance that Bevy's shader has for a lamp, lux.
    fn in_bevy(lumens: f32, distance: f32, range: f32) -> f32 {
        let window = 1.0 - (distance / range).powi(4);
        lumens / (4.0 * PI) / (distance * distance) * window * window
    }

    #[test]
    fn lamps_are_as_bright_as_bevys() {
        let light =
            PointLight { color: Color::WHITE, intensity: 1000.0, range: 20.0, ..PointLight::default() };
        for scale in [1.0, 0.5, 4.0] {
            let light = point(&light, &GlobalTransform::from_xyz(5.0, 3.0, 0.0), &pose(scale));
            // Three and ten metres below, in the world.
            for (distance, tolerance) in [(3.0, 1e-4), (10.0, 5e-3)] {
                let below = Vec3::Y * (3.0 - distance) / scale;
                let lit = light.illuminate(below).unwrap().irradiance.x * PI;
                let wanted = in_bevy(1000.0, distance, 20.0);
                assert!((lit / wanted - 1.0).abs() < tolerance, "{lit} {wanted} at scale {scale}");
            }
        }
    }

    #[test]
    fn spots_and_suns_point_where_bevys_do() {
        let down = GlobalTransform::from(
            Transform::from_xyz(5.0, 2.0, 0.0)
                .looking_at(bevy::math::Vec3::new(5.0, 0.0, 0.0), bevy::math::Vec3::Z),
        );
        let sun = DirectionalLight { color: Color::WHITE, illuminance: 10.0, ..DirectionalLight::default() };
        let Light::Directional { direction, irradiance } = directional(&sun, &down, &pose(2.0)) else {
            panic!()
        };
        assert!(direction.abs_diff_eq(Vec3::NEG_Y, 1e-5));
        assert!((irradiance.x * PI - 10.0).abs() < 1e-4);
        let lamp = spot(&SpotLight::default(), &down, &pose(1.0));
        assert!(lamp.illuminate(Vec3::ZERO).is_some());
        assert!(lamp.illuminate(Vec3::Y * 4.0).is_none());
    }

    #[test]
    fn lights_without_sense_are_left_out() {
        let at = GlobalTransform::from_xyz(5.0, 2.0, 0.0);
        let of = |intensity| point(&PointLight { intensity, ..PointLight::default() }, &at, &pose(1.0));
        assert!(is_lit(&of(100.0)));
        assert!(!is_lit(&of(0.0)));
        assert!(!is_lit(&of(-5.0)));
        assert!(!is_lit(&of(f32::INFINITY)));
    }
}
