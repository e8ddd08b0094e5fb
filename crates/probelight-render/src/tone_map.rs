//! From radiance to a screen: exposure, then a filmic curve.
//!
//! The curve is Stephen Hill's fit of the ACES reference rendering transform with the sRGB output device
//! transform (MJP and S. Hill, *Baking Lab*, 2016): a matrix that mixes the channels a little, so that very
//! bright colours go towards white, a rational S-curve with a toe and a shoulder, and a matrix back.

use probelight_math::color::{luminance, srgb8_from_linear};
use probelight_math::glam::{Mat3, Vec3};

use crate::{DisplayImage, Image};

/// How bright a picture is made before the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Chosen from the picture so that its geometric mean luminance becomes a middle grey.
    Automatic,
    /// Radiance is multiplied by 2^EV.
    Ev(f32),
}

/// A resolved exposure followed by the filmic curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToneMap {
    /// Factor on radiance.
    pub scale: f32,
}

/// Exposed value of an automatically exposed picture's geometric mean luminance: the value that the curve
/// maps to 18 % grey, the middle of a photographer's scale.
pub(crate) const MIDDLE_GREY_IN: f32 = 0.27;

/// Mixes the channels a little before the curve.
pub(crate) const MIX: Mat3 = Mat3::from_cols_array(&[
    0.597_19, 0.076_00, 0.028_40, //
    0.354_58, 0.908_34, 0.133_83, //
    0.048_23, 0.015_66, 0.837_77,
]);

/// And back, with the primaries of sRGB.
pub(crate) const UNMIX: Mat3 = Mat3::from_cols_array(&[
    1.604_75, -0.102_08, -0.003_27, //
    -0.531_08, 1.108_13, -0.072_76, //
    -0.073_67, -0.006_05, 1.076_02,
]);

impl ToneMap {
    /// The exposure for `image`. A black picture, or one without a finite pixel, is left as it is.
    pub fn new(exposure: Exposure, image: &Image) -> Self {
        let scale = match exposure {
            Exposure::Ev(ev) => ev.exp2(),
            Exposure::Automatic => match geometric_mean_luminance(&image.pixels) {
                Some(mean) => MIDDLE_GREY_IN / mean,
                None => 1.0,
            },
        };
        Self { scale }
    }

    /// An exposure of 2^`ev`.
    pub fn of_ev(ev: f32) -> Self {
        Self { scale: ev.exp2() }
    }

    /// The exposure as a power of two.
    pub fn ev(&self) -> f32 {
        self.scale.log2()
    }

    /// What the screen emits for a pixel: linear Rec. 709 in [0, 1]. Values that are not finite become black.
    pub fn display_from_radiance(&self, radiance: Vec3) -> Vec3 {
        let exposed = radiance * self.scale;
        if exposed.is_nan() {
            return Vec3::ZERO;
        }
        filmic(exposed)
    }

    /// What the screen emits for the whole picture, linear.
    pub fn display_from_image(&self, image: &Image) -> Image {
        let pixels = image.pixels.iter().map(|pixel| self.display_from_radiance(*pixel)).collect();
        Image { width: image.width, height: image.height, pixels }
    }

    /// The whole picture in 8-bit sRGB.
    pub fn apply(&self, image: &Image) -> DisplayImage {
        let encode = |pixel: &Vec3| srgb8_from_linear(self.display_from_radiance(*pixel));
        DisplayImage {
            width: image.width,
            height: image.height,
            pixels: image.pixels.iter().map(encode).collect(),
        }
    }
}

/// Geometric mean of the luminance of pixels that are lit at all. Pixels darker than a thousandth of the
/// arithmetic mean count as that, so that a black corner does not decide how bright the rest is shown.
fn geometric_mean_luminance(pixels: &[Vec3]) -> Option<f32> {
    let lit = || pixels.iter().map(|p| luminance(*p)).filter(|l| l.is_finite() && *l > 0.0).map(f64::from);
    let count = lit().count();
    if count == 0 {
        return None;
    }
    let floor = lit().sum::<f64>() / count as f64 * 1e-3;
    let mean_log = lit().map(|l| l.max(floor).ln()).sum::<f64>() / count as f64;
    Some(mean_log.exp() as f32).filter(|mean| mean.is_normal())
}

/// The filmic curve on exposed linear Rec. 709; the result is in [0, 1].
fn filmic(exposed: Vec3) -> Vec3 {
    // Beyond 1e6 the curve is flat; the clamp keeps infinities out of the quotient.
    let v = MIX * exposed.clamp(Vec3::ZERO, Vec3::splat(1e6));
    let numerator = v * (v + 0.024_578_6) - 0.000_090_537;
    let denominator = v * (0.983_729 * v + 0.432_951) + 0.238_081;
    (UNMIX * (numerator / denominator)).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_is_monotone_and_bounded_for_greys() {
        let map = ToneMap { scale: 1.0 };
        let mut last = -1.0;
        for step in 0..400 {
            let value = map.display_from_radiance(Vec3::splat((step as f32 * 0.1 - 20.0).exp2()));
            let shown = luminance(value);
            assert!((0.0..=1.0001).contains(&shown));
            assert!(shown >= last, "step {step}: {shown} after {last}");
            assert!((value - value.x).abs().max_element() < 2e-3, "greys stay grey: {value}");
            last = shown;
        }
        assert!(last > 0.99);
    }

    #[test]
    fn extreme_pixels_stay_on_the_screen() {
        let map = ToneMap { scale: 4.0 };
        for pixel in
            [Vec3::INFINITY, Vec3::NAN, Vec3::NEG_INFINITY, Vec3::splat(-3.0), Vec3::new(1e9, 0.0, 0.0)]
        {
            let shown = map.display_from_radiance(pixel);
            assert!(shown.cmpge(Vec3::ZERO).all() && shown.cmple(Vec3::ONE).all(), "{pixel}: {shown}");
        }
    }

    #[test]
    fn automatic_exposure_shows_a_flat_picture_as_middle_grey_whatever_its_brightness() {
        for brightness in [1e-6, 0.3, 5e4] {
            let image = Image::filled(4, 4, Vec3::splat(brightness));
            let map = ToneMap::new(Exposure::Automatic, &image);
            let shown = map.display_from_radiance(image.pixels[0]).y;
            assert!((shown - 0.18).abs() < 0.01, "{shown}");
        }
    }

    #[test]
    fn black_and_broken_pictures_get_a_neutral_exposure() {
        for pixel in [Vec3::ZERO, Vec3::NAN] {
            assert_eq!(ToneMap::new(Exposure::Automatic, &Image::filled(2, 2, pixel)).scale, 1.0);
        }
        assert_eq!(ToneMap::new(Exposure::Ev(3.0), &Image::filled(2, 2, Vec3::ONE)).scale, 8.0);
    }
}
