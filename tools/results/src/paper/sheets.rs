//! Pictures: reading, comparing, cutting, setting side by side.

use std::io::Cursor;
use std::path::Path;

use anyhow::Context;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use probelight_eval::{ImageView, ssim};
use probelight_render::contact_sheet::ContactSheetRow;
use probelight_render::{ContactSheet, DisplayImage, Image, ToneMap};

use super::workshop::write_whole;

/// A rectangle of a picture, pixels: left, top, width, height.
pub(crate) type Cut = [u32; 4];

/// Reads a linear picture.
pub(crate) fn linear(path: &Path) -> anyhow::Result<Image> {
    Ok(Image::read_exr(path)?)
}

/// Reads a picture as a screen shows it.
pub(crate) fn displayed(path: &Path) -> anyhow::Result<DisplayImage> {
    let picture = image::open(path).with_context(|| format!("cannot read {}", path.display()))?.into_rgb8();
    let (width, height) = picture.dimensions();
    Ok(DisplayImage { width, height, pixels: picture.into_raw().as_chunks().0.to_vec() })
}

/// A part of a picture.
pub(crate) fn cut(image: &Image, [left, top, width, height]: Cut) -> Image {
    let places = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
    Image { width, height, pixels: places.map(|(x, y)| image.pixel(x, y)).collect() }
}

/// SSIM of two linear pictures as a screen shows them.
pub(crate) fn similarity(image: &Image, reference: &Image, tone_map: ToneMap) -> anyhow::Result<f64> {
    let shown = [image, reference].map(|image| tone_map.display_from_image(image));
    let [image, reference] = &shown;
    Ok(ssim(&view(image)?, &view(reference)?)?)
}

fn view(image: &Image) -> anyhow::Result<ImageView<'_>> {
    Ok(ImageView::new(image.width as usize, image.height as usize, &image.pixels)?)
}

/// A sheet of pictures with titles over the columns and captions under the rows.
pub(crate) fn sheet(columns: &[&str], rows: Vec<(String, Vec<DisplayImage>)>) -> DisplayImage {
    let row = |(caption, pictures)| ContactSheetRow { caption, pictures };
    ContactSheet {
        title: String::new(),
        columns: columns.iter().map(ToString::to_string).collect(),
        rows: rows.into_iter().map(row).collect(),
    }
    .draw()
}

/// Writes a picture in as few bytes as the format allows.
pub(crate) fn write(picture: &DisplayImage, path: &Path) -> anyhow::Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(
            picture.pixels.as_flattened(),
            picture.width,
            picture.height,
            image::ExtendedColorType::Rgb8,
        )
        .with_context(|| format!("cannot make {}", path.display()))?;
    write_whole(path, bytes.get_ref())
}
