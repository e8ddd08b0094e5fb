//! Linear Rec. 709 colour: luminance and the sRGB transfer curve.

use glam::Vec3;

/// Relative luminance of a linear Rec. 709 colour.
#[inline]
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Decodes one sRGB-encoded value in `[0, 1]` to linear (IEC 61966-2-1).
#[inline]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encodes one linear value in `[0, 1]` as sRGB (IEC 61966-2-1).
#[inline]
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Decodes an 8-bit sRGB colour to linear.
#[inline]
pub fn linear_from_srgb8(encoded: [u8; 3]) -> Vec3 {
    Vec3::from_array(encoded.map(|c| linear_from_srgb(f32::from(c) / 255.0)))
}

/// Encodes a linear colour, clamped to `[0, 1]`, as 8-bit sRGB, rounding to nearest.
#[inline]
pub fn srgb8_from_linear(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| (srgb_from_linear(c.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_survives_the_round_trip_for_every_code() {
        for code in 0..=255u8 {
            assert_eq!(srgb8_from_linear(linear_from_srgb8([code; 3])), [code; 3]);
        }
    }

    #[test]
    fn middle_grey_is_a_fifth_of_white() {
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-5);
    }
}
