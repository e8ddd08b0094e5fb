//! Lights and cameras at a node.

use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use probelight_math::glam::{Mat4, Vec3};

use super::Warnings;
use crate::{Camera, Light};

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
        warnings.add("lights whose colour or intensity is negative or not finite, left out", 1);
        return None;
    }
    let imported = match light.kind() {
        Kind::Point => Some(Light::Point { position, intensity: strength }),
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
            }
        }),
    };
    if imported.is_none() {
        warnings.add("lights without a direction, left out", 1);
    }
    imported
}

/// A perspective camera at a node, or `None` if it cannot be used.
pub(super) fn camera_at_node(
    camera: &gltf::Camera<'_>,
    name: &str,
    world_from_node: Mat4,
    warnings: &mut Warnings,
) -> Option<Camera> {
    let Projection::Perspective(lens) = camera.projection() else {
        warnings.add("orthographic cameras, left out", 1);
        return None;
    };
    let aspect = lens.aspect_ratio().filter(|a| a.is_finite() && *a > 0.0).unwrap_or(4.0 / 3.0);
    let position = world_from_node.w_axis.truncate();
    let forward = world_from_node.transform_vector3(Vec3::NEG_Z).try_normalize();
    let up = world_from_node.transform_vector3(Vec3::Y).try_normalize();
    let field_of_view = Some(lens.yfov()).filter(|angle| *angle > 0.0 && *angle < std::f32::consts::PI);
    let (Some(forward), Some(up), Some(vertical_fov)) = (forward, up, field_of_view) else {
        warnings.add("cameras without a direction or with an impossible field of view, left out", 1);
        return None;
    };
    let width = (CAMERA_HEIGHT as f32 * aspect).round().clamp(1.0, 16.0 * CAMERA_HEIGHT as f32) as u32;
    let target = position + forward;
    Some(Camera { name: name.into(), position, target, up, vertical_fov, width, height: CAMERA_HEIGHT })
}
