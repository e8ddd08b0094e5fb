//! A picture of where the compression loses light: each lightmap texel in the colour of its error.

use probelight_asset::{BakedScene, ERROR_STEPS};
use probelight_render::DisplayImage;
use serde::Serialize;

/// Colours at equal steps from no error to twice the wanted one. Lightness rises evenly from the first to the
/// last, so that the order is plain in greys and to the colour-blind too.
const RAMP: [(&str, [u8; 3]); 5] = [
    ("violet", [68, 1, 84]),
    ("blue", [59, 82, 139]),
    ("teal", [33, 145, 140]),
    ("green", [94, 201, 98]),
    ("yellow", [253, 231, 37]),
];

/// Error at the end of the ramp, as a multiple of the wanted one.
const END: f32 = 2.0;

/// What a colour of the map stands for.
#[derive(Debug, PartialEq, Serialize)]
pub(crate) struct LegendEntry {
    /// In words.
    color: &'static str,
    /// sRGB.
    srgb: [u8; 3],
    /// Relative error of a texel.
    pub(crate) error: f32,
}

impl LegendEntry {
    /// For people, such as "teal 3.0 %".
    pub(crate) fn describe(&self) -> String {
        format!("{} {:.1} %", self.color, 100.0 * self.error)
    }
}

/// The picture, one pixel a lightmap texel; black where no receiver lies.
pub(crate) fn error_map(baked: &BakedScene) -> DisplayImage {
    let (width, height) = (baked.lightmap.width, baked.lightmap.height);
    let mut image = DisplayImage::filled(width, height, [0; 3]);
    for (texel, error) in baked.receiver_texels.iter().zip(&baked.receiver_errors) {
        image.pixels[*texel as usize] = color_of(f32::from(*error) / ERROR_STEPS);
    }
    image
}

/// What the colours stand for, from no error to twice the wanted one and above.
pub(crate) fn legend(wanted_error: f32) -> Vec<LegendEntry> {
    let step = END * wanted_error / (RAMP.len() - 1) as f32;
    let entry = |(i, (color, srgb)): (usize, &(&'static str, [u8; 3]))| LegendEntry {
        color,
        srgb: *srgb,
        error: i as f32 * step,
    };
    RAMP.iter().enumerate().map(entry).collect()
}

/// Colour of an error, as a multiple of the wanted one.
fn color_of(share: f32) -> [u8; 3] {
    let place = (share / END).clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let lower = (place as usize).min(RAMP.len() - 2);
    let fraction = place - lower as f32;
    let [from, to] = [RAMP[lower].1, RAMP[lower + 1].1];
    std::array::from_fn(|channel| {
        let [from, to] = [from, to].map(|color| f32::from(color[channel]));
        (from + (to - from) * fraction).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_ends_at_twice_the_wanted_error_and_becomes_ever_lighter() {
        assert_eq!(color_of(0.0), RAMP[0].1);
        assert_eq!(color_of(1.0), RAMP[2].1);
        assert_eq!([2.0, 9.0, f32::INFINITY].map(color_of), [RAMP[4].1; 3]);
        assert_eq!(color_of(f32::NAN).len(), 3);
        let lightness = |share: f32| {
            let [r, g, b] = color_of(share).map(f32::from);
            0.21 * r + 0.72 * g + 0.07 * b
        };
        let steps: Vec<f32> = (0..=20).map(|i| lightness(0.1 * i as f32)).collect();
        assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    }

    #[test]
    fn the_legend_names_what_the_map_shows() {
        let legend = legend(0.03);
        assert_eq!(legend[2].describe(), "teal 3.0 %");
        for entry in legend {
            assert_eq!(color_of(entry.error / 0.03), entry.srgb);
        }
    }
}
