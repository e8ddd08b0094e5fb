//! Where light is evaluated and measured: samples, surfels and their groups, emitters, probes.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{Vec2, Vec3};

/// A place where incoming radiance is measured and projected to spherical harmonics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Probe {
    /// World position, metres.
    pub position: Vec3,
    /// Distance to the farthest receiver that draws on the probe, metres (for levels of detail).
    pub support_radius: f32,
}

/// A point of a surfel, which stands for a part of it. Where it lies and its texel follow from its triangle.
///
/// There is about one for each texel of the lightmap, so they are packed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct LightSample {
    /// Twice the index of its triangle, and 1 more on the back face; the low half first.
    pub side: [u16; 2],
    /// Barycentric weights of the triangle's second and third corner in 4095ths, twelve bits each, then the mean base
    /// colour texture without the material's factor, sRGB-encoded; low bits first.
    pub weights_and_color: [u16; 3],
}

/// What the weights of a light sample are multiples of, inverted.
const WEIGHT_STEPS: u32 = (1 << 12) - 1;

impl LightSample {
    /// A point on one side of a triangle, at barycentric weights of the second and third corner.
    pub fn new(triangle: u32, is_back_face: bool, barycentric: Vec2, base_color: [u8; 3]) -> Self {
        let steps = WEIGHT_STEPS as f32;
        let second = (barycentric.x * steps).round().clamp(0.0, steps) as u32;
        // Rounding must not lead out of the triangle.
        let third = ((barycentric.y * steps).round().clamp(0.0, steps) as u32).min(WEIGHT_STEPS - second);
        let side = 2 * triangle + u32::from(is_back_face);
        let [red, green, blue] = base_color.map(u32::from);
        let weights = second | third << 12;
        Self {
            side: [side as u16, (side >> 16) as u16],
            weights_and_color: [
                weights as u16,
                (weights >> 16 | red << 8) as u16,
                (green | blue << 8) as u16,
            ],
        }
    }

    /// Index of its triangle.
    #[inline]
    pub fn triangle(&self) -> u32 {
        let [low, high] = self.side.map(u32::from);
        (low | high << 16) / 2
    }

    /// Whether it lies on the back face of its triangle.
    #[inline]
    pub fn is_back_face(&self) -> bool {
        self.side[0] % 2 == 1
    }

    /// Barycentric weights of the triangle's second and third corner.
    #[inline]
    pub fn barycentric(&self) -> Vec2 {
        let [low, high, _] = self.weights_and_color.map(u32::from);
        let weights = low | high << 16;
        Vec2::new((weights & WEIGHT_STEPS) as f32, (weights >> 12 & WEIGHT_STEPS) as f32)
            / WEIGHT_STEPS as f32
    }

    /// Mean base colour texture without the material's factor, sRGB-encoded.
    #[inline]
    pub fn base_color(&self) -> [u8; 3] {
        let [_, red, rest] = self.weights_and_color;
        [(red >> 8) as u8, rest as u8, (rest >> 8) as u8]
    }
}

/// A patch of surface. Its radiance is the mean of its samples' outgoing radiance
/// `Le + ρ/π · (E_direct + E_lightmap)`; Le is left out where an [`Emitter`] carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Surfel {
    /// First of its samples (index into `light_samples`); surfels divide the samples among them in order.
    pub first_sample: u32,
    /// Number of samples, at least one.
    pub sample_count: u32,
    /// Area, m²: what rays of lights can meet. 0 for a surfel that is a point.
    pub area: f32,
}

/// A patch made of two smaller ones: its radiance is `w · first + (1 − w) · second`.
///
/// Surfels and groups share one numbering: surfel s is s, group g is `surfels.len() + g`. Children have
/// smaller numbers than their group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SurfelGroup {
    /// The two patches.
    pub children: [u32; 2],
    /// Share w of the first in the area, 0 to 1.
    pub first_weight: f32,
}

/// An emissive surface, or a part of one. Its signal is its mean emitted radiance: the material's present
/// emission times `mean_texel`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Emitter {
    /// Index of its material.
    pub material: u32,
    /// Mean of the emissive texture, linear RGB.
    pub mean_texel: Vec3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_samples_keep_their_side_color_and_place_in_ten_bytes() {
        assert_eq!(size_of::<LightSample>(), 10);
        for (triangle, is_back_face, color) in [(0, true, [1, 2, 3]), (0x7abc_def1, false, [255, 0, 128])] {
            for at in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, 0.7), Vec2::new(0.123, 0.456)] {
                let sample = LightSample::new(triangle, is_back_face, at, color);
                assert_eq!((sample.triangle(), sample.is_back_face()), (triangle, is_back_face));
                assert_eq!(sample.base_color(), color);
                let found = sample.barycentric();
                assert!(
                    found.abs_diff_eq(at, 1.5 / 4095.0) && found.element_sum() <= 1.0 + f32::EPSILON,
                    "{found} for {at}"
                );
            }
        }
    }
}
