//! Where light is evaluated and measured: samples, surfels and their groups, emitters, probes.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec3;

/// A place where incoming radiance is measured and projected to spherical harmonics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Probe {
    /// World position, metres.
    pub position: Vec3,
    /// Distance to the farthest receiver that draws on the probe, metres (for levels of detail).
    pub support_radius: f32,
}

/// A point whose light is evaluated each frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightSample {
    /// World position on the surface, metres.
    pub position: Vec3,
    /// Index of its triangle.
    pub triangle: u32,
    /// Its lightmap texel on its side of the triangle, or [`crate::NONE`] if that side has no light of its own.
    pub texel: u32,
    /// Base colour texture without the material's factor (sRGB-encoded); the fourth byte is 1 on the back
    /// face, else 0.
    pub base_color_and_side: [u8; 4],
    /// Emissive texture without the material's factor (sRGB-encoded); the fourth byte is 0.
    pub emission_texel: [u8; 4],
}

impl LightSample {
    /// Whether the sample lies on the back face of its triangle.
    #[inline]
    pub fn is_back_face(&self) -> bool {
        self.base_color_and_side[3] != 0
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
