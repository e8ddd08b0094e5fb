//! Lights and cameras at a node.

use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use probelight_math::glam::{Mat4, Vec3};

use super::Warnings;
use crate::{Camera, Light};

/// Distance of a camera's target, as a share of its distance from the origin: rounding turns the view by less than
/// a ten-thousandth.
const TARGET_SHARE: f32 = 1e-3;

/// Image height of cameras, which have no resolution in glTF, pixels.
const CAMERA_HEIGHT: u32 = 512;

/// A punctual light at a node, or `None` if its numbers cannot be used.
pub(super) fn light_at_node(
    light: &gltf::khr_lights_punctual::Light<'_>,
    world_from_node: Mat4,
    warnings: &mut Warnings,
) -> Option<Light> {
    let strength = Vec3::from(light.color()) * light.intensity();
    let position = world_from_node.w_axis.truncate();
    let direction = world_from_node.transform_vector3(Vec3::NEG_Z).try_normalize();
    if !(strength.is_finite() && strength.min_element() >= 0.0) {
        warnings.add("lights whose colour or intensity is negative or not finite, left out; correct them", 1);
        return None;
    }
    let range = usable_range(light.range(), warnings);
    let imported = match light.kind() {
        Kind::Point => Some(Light::Point { position, intensity: strength, range }),
        Kind::Directional => {
            direction.map(|direction| Light::Directional { direction, irradiance: strength })
        }
        Kind::Spot { inner_cone_angle, outer_cone_angle } => direction.map(|direction| {
            let outer_angle = outer_cone_angle.clamp(0.0, std::f32::consts::FRAC_PI_2);
            Light::Spot {
                position,
                direction,
                intensity: strength,
                inner_angle: inner_cone_angle.clamp(0.0, outer_angle),
                outer_angle,
                range,
            }
        }),
    };
    let imported = imported.filter(|light| light.validate().is_ok());
    warnings.add(
        "lights without a direction or with a number that is not finite, left out; correct them",
        usize::from(imported.is_none()),
    );
    imported
}

/// A light's range, metres; the scale of nodes does not change it. Like viewers, takes 0 as none.
fn usable_range(range: Option<f32>, warnings: &mut Warnings) -> Option<f32> {
    let usable = range.filter(|range| *range > 0.0 && range.is_finite());
    warnings.add(
        "lights with a range of 0, negative or not finite, taken as without; remove the range",
        usize::from(usable.is_none() && range.is_some()),
    );
    usable
}

/// A perspective camera at a node, or `None` if it cannot be used.
pub(super) fn camera_at_node(
    camera: &gltf::Camera<'_>,
    name: &str,
    world_from_node: Mat4,
    warnings: &mut Warnings,
) -> Option<Camera> {
    let Projection::Perspective(lens) = camera.projection() else {
        warnings.add("orthographic cameras, left out; make them perspective", 1);
        return None;
    };
    let aspect = lens.aspect_ratio().filter(|a| a.is_finite() && *a > 0.0).unwrap_or(4.0 / 3.0);
    let position = world_from_node.w_axis.truncate();
    let forward = world_from_node.transform_vector3(Vec3::NEG_Z).try_normalize();
    let up = world_from_node.transform_vector3(Vec3::Y).try_normalize();
    let width = (CAMERA_HEIGHT as f32 * aspect).round().clamp(1.0, 16.0 * CAMERA_HEIGHT as f32) as u32;
    let camera = Camera {
        name: name.into(),
        position,
        target: position + forward.unwrap_or_default() * (TARGET_SHARE * position.length()).max(1.0),
        up: up.unwrap_or_default(),
        vertical_fov: lens.yfov(),
        width,
        height: CAMERA_HEIGHT,
    };
    let unusable = camera.validate().err();
    warnings.add(
        "cameras without a direction or with an impossible field of view, left out; correct them",
        usize::from(unusable.is_some()),
    );
    unusable.is_none().then_some(camera)
}
