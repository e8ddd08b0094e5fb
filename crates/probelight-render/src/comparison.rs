//! Two pictures of the same size: where they differ, and how alike they are.

use probelight_math::color::{luminance, srgb_from_linear};
use probelight_math::glam::Vec3;

use crate::{DisplayImage, Image, ToneMap};

/// A signed difference picture: mid-grey where both are equal, brighter where `image` is brighter than
/// `reference` and darker where it is darker.
///
/// The difference is taken between the values the screen would be sent (tone mapped and sRGB encoded),
/// which are about evenly spaced to the eye, and multiplied by `gain`: what one cannot see in the pictures
/// stays small here too, whether it lies in a bright or a dark place.
///
/// # Panics
/// If the pictures differ in size.
pub fn difference(image: &Image, reference: &Image, tone_map: ToneMap, gain: f32) -> DisplayImage {
    assert_same_size((image.width, image.height), (reference.width, reference.height));
    let code = |p: Vec3| Vec3::from_array(tone_map.display_from_radiance(p).to_array().map(srgb_from_linear));
    let pixels = image.pixels.iter().zip(&reference.pixels).map(|(ours, theirs)| {
        let shown = 0.5 + gain * (code(*ours) - code(*theirs));
        shown.to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    });
    DisplayImage { width: image.width, height: image.height, pixels: pixels.collect() }
}

/// Side of the windows of [`ssim`], pixels.
const WINDOW: u32 = 8;

/// Mean structural similarity of two pictures' encoded luma, 1 for equal ones (Wang et al. 2004, with
/// uniform 8×8 windows at every position). `None` for pictures smaller than a window.
///
/// # Panics
/// If the pictures differ in size.
pub fn ssim(image: &DisplayImage, reference: &DisplayImage) -> Option<f64> {
    assert_same_size((image.width, image.height), (reference.width, reference.height));
    if image.width < WINDOW || image.height < WINDOW {
        return None;
    }
    let (ours, theirs) = (luma(image), luma(reference));
    let (columns, rows) = (image.width - WINDOW + 1, image.height - WINDOW + 1);
    let mut sum = 0.0;
    for y in 0..rows {
        for x in 0..columns {
            let starts = (y..y + WINDOW).map(|row| (row * image.width + x) as usize);
            let pairs = starts.flat_map(|start| {
                let row = start..start + WINDOW as usize;
                ours[row.clone()].iter().copied().zip(theirs[row].iter().copied())
            });
            sum += window_similarity(pairs);
        }
    }
    Some(sum / (f64::from(columns) * f64::from(rows)))
}

/// Structural similarity of one window's luma pairs in [0, 1].
fn window_similarity(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let count = f64::from(WINDOW * WINDOW);
    let (mut a, mut b, mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, y) in pairs {
        (a, b, aa, bb, ab) = (a + x, b + y, aa + x * x, bb + y * y, ab + x * y);
    }
    let (a, b) = (a / count, b / count);
    let (variance_a, variance_b, covariance) = (aa / count - a * a, bb / count - b * b, ab / count - a * b);
    // The paper's constants (0.01 L)² and (0.03 L)² for a dynamic range L of 1.
    let (c1, c2) = (1e-4, 9e-4);
    (2.0 * a * b + c1) * (2.0 * covariance + c2) / ((a * a + b * b + c1) * (variance_a + variance_b + c2))
}

fn luma(picture: &DisplayImage) -> Vec<f64> {
    let value = |p: &[u8; 3]| f64::from(luminance(Vec3::from_array(p.map(f32::from)) / 255.0));
    picture.pixels.iter().map(value).collect()
}

fn assert_same_size(a: (u32, u32), b: (u32, u32)) {
    assert_eq!(a, b, "pictures of different size cannot be compared");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(seed: u32) -> DisplayImage {
        let mut picture = DisplayImage::filled(32, 24, [0; 3]);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = [(probelight_math::sampling::hash_pair(i as u32, seed) >> 24) as u8; 3];
        }
        picture
    }

    #[test]
    fn ssim_is_one_for_equal_pictures_only() {
        let picture = texture(1);
        assert!((ssim(&picture, &picture).unwrap() - 1.0).abs() < 1e-9);
        assert!(ssim(&picture, &texture(2)).unwrap().abs() < 0.1, "unrelated noise");
        let mut inverted = picture.clone();
        inverted.pixels.iter_mut().flatten().for_each(|c| *c = 255 - *c);
        assert!(ssim(&picture, &inverted).unwrap() < -0.5);
        assert_eq!(ssim(&DisplayImage::filled(4, 40, [0; 3]), &DisplayImage::filled(4, 40, [0; 3])), None);
    }

    #[test]
    fn ssim_of_flat_pictures_follows_the_formula() {
        let flat = |code| DisplayImage::filled(16, 16, [code; 3]);
        let (a, b) = (100.0 / 255.0, 200.0 / 255.0);
        let expected = (2.0 * a * b + 1e-4) / (a * a + b * b + 1e-4);
        assert!((ssim(&flat(100), &flat(200)).unwrap() - expected).abs() < 1e-5);
    }

    #[test]
    fn difference_is_grey_where_equal_and_signed_elsewhere() {
        let map = ToneMap { scale: 1.0 };
        let reference = Image::filled(3, 1, Vec3::splat(0.3));
        let mut image = reference.clone();
        image.pixels[1] *= 1.1;
        image.pixels[2] *= 0.9;
        let shown = difference(&image, &reference, map, 4.0);
        assert_eq!(shown.pixels[0], [128; 3]);
        assert!(shown.pixels[1][1] > 140 && shown.pixels[2][1] < 116, "{:?}", shown.pixels);
    }
}
