//! Metallic-roughness materials and their textures.

use std::sync::Arc;

use probelight_math::color::linear_from_srgb;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// How a material's alpha is used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// The surface exists where alpha ≥ cutoff.
    Mask {
        /// Smallest alpha that is still surface.
        cutoff: f32,
    },
}

/// A texture as used by one slot of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureSlot {
    /// Index into [`crate::Scene::textures`].
    pub texture: u32,
    /// Which texture coordinates to use: 0 or 1.
    pub tex_coord: u32,
}

/// A glTF 2.0 metallic-roughness material. Light transport uses base colour as the albedo of a two-sided
/// Lambertian surface, alpha mask and emission; the rest is for renderers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Linear base colour factor and alpha.
    pub base_color: Vec4,
    /// Base colour texture (sRGB).
    pub base_color_texture: Option<TextureSlot>,
    /// Metalness factor in [0, 1].
    pub metallic: f32,
    /// Perceptual roughness factor in [0, 1].
    pub roughness: f32,
    /// Metalness (blue) and roughness (green), linear.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Tangent-space normal map, linear.
    pub normal_texture: Option<TextureSlot>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Ambient occlusion (red), linear.
    pub occlusion_texture: Option<TextureSlot>,
    /// Emitted radiance Le of the front face, W·m⁻²·sr⁻¹: emissiveFactor · emissive strength.
    pub emission: Vec3,
    /// Factor on the emission (sRGB).
    pub emissive_texture: Option<TextureSlot>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Whether the back faces are meant to be seen. Light always meets both sides.
    pub double_sided: bool,
}

impl Material {
    /// The slots of all textures: base colour, metalness and roughness, normal, occlusion, emission. Content hash
    /// and shaders rely on the order.
    pub fn texture_slots(&self) -> [Option<TextureSlot>; 5] {
        [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.occlusion_texture,
            self.emissive_texture,
        ]
    }

    /// The same, to change them.
    pub(crate) fn texture_slots_mut(&mut self) -> [Option<&mut TextureSlot>; 5] {
        [
            self.base_color_texture.as_mut(),
            self.metallic_roughness_texture.as_mut(),
            self.normal_texture.as_mut(),
            self.occlusion_texture.as_mut(),
            self.emissive_texture.as_mut(),
        ]
    }
}

impl Default for Material {
    /// glTF's default material: white, rough metal factors as the specification has them.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            emission: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
        }
    }
}

/// An 8-bit RGBA image. Sampling is bilinear with repeat, on the full-size image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name or URI in the file, or empty.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// Rows from the top, four bytes a texel. Shared by all copies of the texture.
    pub rgba8: Arc<[u8]>,
}

impl Texture {
    /// Bilinear sample of an sRGB colour texture: colour is decoded to linear before filtering, alpha is
    /// linear already.
    pub fn sample_srgb(&self, uv: Vec2) -> Vec4 {
        let decode = |code: u8| SRGB_DECODE.with(|table| table[usize::from(code)]);
        let size = Vec2::new(self.width as f32, self.height as f32);
        // Wrapping to [0, 1) first keeps precision for far repeats; NaN becomes the first texel.
        let position = (uv - uv.floor()) * size - 0.5;
        let corner = position.floor();
        let fraction = position - corner;
        let fetch = |dx: i32, dy: i32| {
            let x = (corner.x as i32 + dx).rem_euclid(self.width as i32) as usize;
            let y = (corner.y as i32 + dy).rem_euclid(self.height as i32) as usize;
            let at = (y * self.width as usize + x) * 4;
            let [r, g, b, a] = [0, 1, 2, 3].map(|c| self.rgba8[at + c]);
            Vec4::new(decode(r), decode(g), decode(b), f32::from(a) / 255.0)
        };
        let top = fetch(0, 0).lerp(fetch(1, 0), fraction.x);
        let bottom = fetch(0, 1).lerp(fetch(1, 1), fraction.x);
        top.lerp(bottom, fraction.y)
    }
}

thread_local! {
    static SRGB_DECODE: [f32; 256] = std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_texels() -> Texture {
        Texture { name: String::new(), width: 2, height: 1, rgba8: [0, 0, 0, 255, 255, 255, 255, 0].into() }
    }

    #[test]
    fn sampling_is_bilinear_and_repeats() {
        let texture = two_texels();
        for shift in [-3.0, 0.0, 5.0] {
            let at = |u: f32| texture.sample_srgb(Vec2::new(u + shift, 0.5));
            assert!(at(0.25).abs_diff_eq(Vec4::W, 1e-5));
            assert!(at(0.75).abs_diff_eq(Vec4::new(1.0, 1.0, 1.0, 0.0), 1e-5));
            assert!(at(0.5).abs_diff_eq(Vec4::splat(0.5), 1e-5));
            assert!(at(0.0).abs_diff_eq(Vec4::splat(0.5), 1e-5));
        }
    }

    #[test]
    fn srgb_is_decoded_before_filtering() {
        let mixed = two_texels().sample_srgb(Vec2::new(0.5, 0.5));
        assert!((mixed.x - 0.5).abs() < 1e-5 && (mixed.w - 0.5).abs() < 1e-5);
    }
}
