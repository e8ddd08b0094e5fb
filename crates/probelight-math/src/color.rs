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

/// Linear Rec. 709 colour of a black body, kelvins, scaled so that the largest channel is 1. Channels outside the gamut are 0.
///
/// The Planckian locus by the cubic splines of Kim et al. (US patent 7024034, 2006), which hold from 1,667 K to 25,000 K;
/// others count as the nearest of these.
pub fn blackbody(kelvins: f32) -> Vec3 {
    let t = kelvins.clamp(1667.0, 25_000.0);
    let cubic = |a: [f32; 4], v: f32| ((a[0] * v + a[1]) * v + a[2]) * v + a[3];
    let inverse = 1000.0 / t;
    let x = if t <= 4000.0 {
        cubic([-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910], inverse)
    } else {
        cubic([-3.025_847, 2.107_037_9, 0.222_634_7, 0.240_390], inverse)
    };
    let y = match t {
        t if t <= 2222.0 => cubic([-1.106_381_4, -1.348_110_2, 2.185_558_3, -0.202_196_83], x),
        t if t <= 4000.0 => cubic([-0.954_947_6, -1.374_185_9, 2.091_37, -0.167_488_67], x),
        _ => cubic([3.081_758, -5.873_387, 3.751_13, -0.370_014_83], x),
    };
    let xyz = Vec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let rgb = Vec3::new(
        xyz.dot(Vec3::new(3.240_97, -1.537_383, -0.498_611)),
        xyz.dot(Vec3::new(-0.969_244, 1.875_968, 0.041_555)),
        xyz.dot(Vec3::new(0.055_63, -0.203_977, 1.056_972)),
    )
    .max(Vec3::ZERO);
    rgb / rgb.max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_go_from_red_over_white_to_blue() {
        let [candle, white, sky] = [1900.0, 6504.0, 15_000.0].map(blackbody);
        assert!(candle.x == 1.0 && candle.y < 0.4 && candle.z < 0.05, "{candle}");
        assert!((white - Vec3::ONE).abs().max_element() < 0.06, "D65 is white: {white}");
        assert!(sky.z == 1.0 && sky.x < 0.75, "{sky}");
        // The splines meet.
        for joint in [2222.0, 4000.0] {
            assert!(blackbody(joint - 0.5).distance(blackbody(joint + 0.5)) < 2e-3);
        }
        assert_eq!(blackbody(1.0), blackbody(1667.0));
    }

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
