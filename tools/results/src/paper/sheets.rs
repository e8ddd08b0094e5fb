//! Pictures: reading, comparing, cutting, setting side by side.

use std::io::Cursor;
use std::path::Path;

use anyhow::Context;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use probelight_eval::{ImageView, ssim};
use probelight_render::contact_sheet::ContactSheetRow;
use probelight_render::{ContactSheet, DisplayImage, Image, ToneMap};

use crate::documents::write_whole;

/// A rectangle of a picture, pixels: left, top, width, height.
pub(crate) type Cut = [u32; 4];

/// Bytes of a picture in a document.
const MOST_BYTES: usize = 245_000;

/// Height of the title's line in a contact sheet, pixels.
const UNTITLED: u32 = 22;

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

/// A sheet of pictures with titles over the columns and captions under the rows; the place of its own title is cut off.
pub(crate) fn sheet(columns: &[&str], rows: Vec<(String, Vec<DisplayImage>)>) -> DisplayImage {
    let row = |(caption, pictures)| ContactSheetRow { caption, pictures };
    let sheet = ContactSheet {
        title: String::new(),
        columns: columns.iter().map(ToString::to_string).collect(),
        rows: rows.into_iter().map(row).collect(),
    };
    without_top(&sheet.draw(), UNTITLED)
}

/// A picture without its uppermost lines.
fn without_top(picture: &DisplayImage, lines: u32) -> DisplayImage {
    let first = lines as usize * picture.width as usize;
    let pixels = picture.pixels.get(first..).unwrap_or_default().to_vec();
    DisplayImage { width: picture.width, height: picture.height.saturating_sub(lines), pixels }
}

/// Writes a picture in as few bytes as the format allows; with 6 bits a channel if that are too many for a document.
pub(crate) fn write(picture: &DisplayImage, path: &Path) -> anyhow::Result<()> {
    let exact = encoded(picture).with_context(|| format!("cannot make {}", path.display()))?;
    if exact.len() <= MOST_BYTES {
        return write_whole(path, &exact);
    }
    let six_bits = |channel: u8| channel & !3 | channel >> 6;
    let pixels = picture.pixels.iter().map(|pixel| pixel.map(six_bits)).collect();
    write_whole(path, &encoded(&DisplayImage { pixels, ..*picture })?)
}

fn encoded(picture: &DisplayImage) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive).write_image(
        picture.pixels.as_flattened(),
        picture.width,
        picture.height,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::glam::Vec3;

    #[test]
    fn a_cut_has_the_pixels_of_its_place() {
        let pixels = (0..12).map(|i| Vec3::splat(i as f32)).collect();
        let image = Image { width: 4, height: 3, pixels };
        let part = cut(&image, [1, 1, 2, 2]);
        assert_eq!((part.width, part.height), (2, 2));
        assert_eq!(part.pixels.iter().map(|pixel| pixel.x).collect::<Vec<_>>(), [5.0, 6.0, 9.0, 10.0]);
    }

    #[test]
    fn pictures_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let picture = sheet(&["a"], vec![("b".into(), vec![DisplayImage::filled(30, 20, [1, 2, 3])])]);
        write(&picture, &path).unwrap();
        assert_eq!(displayed(&path).unwrap(), picture);
        assert!(format!("{:#}", displayed(&folder.path().join("b.png")).unwrap_err()).contains("b.png"));
    }

    #[test]
    fn similar_pictures_are_told_from_others() {
        let image = |step: u32| Image {
            width: 16,
            height: 16,
            pixels: (0..256).map(|i| Vec3::splat((i / step % 2) as f32)).collect(),
        };
        let similarity = |a, b| similarity(&image(a), &image(b), ToneMap::of_ev(0.0)).unwrap();
        assert!((similarity(3, 3) - 1.0).abs() < 1e-9 && similarity(3, 5) < 0.9);
    }
}
