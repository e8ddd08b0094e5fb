//! Two pictures of the same size: where they differ.

use probelight_math::color::srgb_from_linear;
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

fn assert_same_size(a: (u32, u32), b: (u32, u32)) {
    assert_eq!(a, b, "pictures of different size cannot be compared");
}

#[cfg(test)]
mod tests {
    use super::*;

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
