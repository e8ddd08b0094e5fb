//! Between Bevy's vectors and Probelight's, which are of two versions of `glam`.

use bevy::color::{Color, ColorToComponents};
use bevy::math::Vec3 as BevyVec3;
use probelight_math::glam::Vec3;

/// Bevy's vector as Probelight's.
pub(crate) fn vec3(v: BevyVec3) -> Vec3 {
    Vec3::from_array(v.to_array())
}

/// Linear Rec. 709; what is negative becomes black.
pub(crate) fn linear(color: Color) -> Vec3 {
    Vec3::from_array(color.to_linear().to_f32_array_no_alpha()).max(Vec3::ZERO)
}
