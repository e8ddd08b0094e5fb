//! Irradiance straight from analytic lights, with shadow rays.

use probelight_math::glam::Vec3;
use probelight_scene::{Illumination, Light};

use crate::{Occluder, Ray};

/// Irradiance (W/m²) that `lights` send straight to the surface at `position` on the side of its unit
/// `normal`: every light in full, minus what a shadow ray finds to be hidden.
///
/// `position` lies on the surface; the shadow rays leave it by [`Occluder::offset`] themselves.
#[inline]
pub fn direct_irradiance(occluder: &impl Occluder, lights: &[Light], position: Vec3, normal: Vec3) -> Vec3 {
    smooth_direct_irradiance(occluder, lights, position, normal, normal)
}

/// [`direct_irradiance`] of a surface that is shaded as if it faced along `shading_normal` (unit): of lights in front of
/// both.
#[inline]
pub fn smooth_direct_irradiance(
    occluder: &impl Occluder,
    lights: &[Light],
    position: Vec3,
    normal: Vec3,
    shading_normal: Vec3,
) -> Vec3 {
    let from = |light: &Light| {
        let Some(arriving) = light.illuminate(position) else { return Vec3::ZERO };
        let cosine = shading_normal.dot(arriving.to_light);
        let is_in_front = cosine > 0.0 && normal.dot(arriving.to_light) > 0.0;
        if !is_in_front || occluder.is_occluded(&shadow_ray(position, normal, &arriving, occluder.offset())) {
            return Vec3::ZERO;
        }
        arriving.irradiance * cosine
    };
    lights.iter().map(from).sum()
}

/// The segment that must be free for `arriving` light to reach a surface: from `position`, moved off the
/// surface by `offset` metres along its unit `normal`, to just before the light.
#[inline]
pub fn shadow_ray(position: Vec3, normal: Vec3, arriving: &Illumination, offset: f32) -> Ray {
    let origin = position + normal * offset;
    if arriving.distance.is_infinite() {
        return Ray::new(origin, arriving.to_light);
    }
    // Aim from the moved origin at the light itself, so that a lamp close to a wall is not missed, and stop
    // short of it: lamps are often modelled right on a surface.
    let to_light = position + arriving.to_light * arriving.distance - origin;
    let distance = to_light.length();
    Ray { origin, direction: to_light / distance, max_distance: distance - offset }
}
