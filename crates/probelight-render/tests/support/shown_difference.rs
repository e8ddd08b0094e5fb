//! How different two pictures look.
#![allow(dead_code, reason = "each test binary uses a part")]

use probelight_eval::{ImageView, flip};
use probelight_render::{Exposure, Image, ToneMap};

/// Mean FLIP difference of two pictures, both shown with the exposure that suits the second.
pub(crate) fn shown_difference(image: &Image, reference: &Image) -> f64 {
    let tone_map = ToneMap::new(Exposure::Automatic, reference);
    let shown = [image, reference].map(|image| tone_map.display_from_image(image));
    difference(&shown[0], &shown[1])
}

/// Mean FLIP difference of two pictures as they are shown.
pub(crate) fn difference(image: &Image, reference: &Image) -> f64 {
    let [image, reference] =
        [image, reference].map(|i| ImageView::new(i.width as usize, i.height as usize, &i.pixels).unwrap());
    flip(&image, &reference).unwrap()
}
