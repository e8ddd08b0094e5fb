//! Pictures in files: OpenEXR and PNG.

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{self as openexr, ReadChannels as _, ReadLayers as _, WritableImage as _};
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use probelight_asset::write_atomically;
use probelight_math::glam::Vec3;

use crate::{DisplayImage, Image};

/// Why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// "read" or "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The bytes are not a picture that can be used.
    #[error("{path} is not a usable picture: {reason}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The picture itself cannot be stored.
    #[error("cannot store this picture in {path}: {reason}")]
    Encode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// Most pixels that [`Image::read_exr`] accepts: a header can claim any size, whatever the file holds.
const MAX_PIXELS: usize = 1 << 27;

impl Image {
    /// Writes a 32-bit float RGB OpenEXR file (ZIP compressed), whole or not at all.
    ///
    /// # Errors
    /// [`ImageError::Io`] or, for a picture without pixels, [`ImageError::Encode`].
    pub fn write_exr(&self, path: &Path) -> Result<(), ImageError> {
        let pixel = |position: openexr::Vec2<usize>| {
            let rgb = self.pixels[position.y() * self.width as usize + position.x()];
            (rgb.x, rgb.y, rgb.z)
        };
        let size = (self.width as usize, self.height as usize);
        let channels = openexr::SpecificChannels::rgb(pixel);
        let mut bytes = Cursor::new(Vec::new());
        openexr::Image::from_channels(size, channels)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .map_err(|error| ImageError::Encode { path: path.into(), reason: error.to_string() })?;
        write(path, bytes.get_ref())
    }

    /// Reads the RGB channels of an OpenEXR file (16- or 32-bit), of its first layer that has them.
    ///
    /// # Errors
    /// [`ImageError::Io`] if it cannot be opened, [`ImageError::Format`] if it is not an OpenEXR file with
    /// RGB channels, is cut off, or claims an absurd size.
    pub fn read_exr(path: &Path) -> Result<Self, ImageError> {
        let bytes = std::fs::read(path).map_err(|source| ImageError::Io {
            action: "read",
            path: path.into(),
            source,
        })?;
        let format = |reason: String| ImageError::Format { path: path.into(), reason };
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(&bytes), false)
            .map_err(|error| format(error.to_string()))?;
        if meta.headers.iter().any(|header| header.layer_size.area() > MAX_PIXELS) {
            return Err(format(format!("it claims more than {MAX_PIXELS} pixels")));
        }
        let read = openexr::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, _| Self::filled(size.width() as u32, size.height() as u32, Vec3::ZERO),
                |image, position, (r, g, b, _): (f32, f32, f32, f32)| {
                    image.pixels[position.y() * image.width as usize + position.x()] = Vec3::new(r, g, b);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(&bytes))
            .map_err(|error| format(error.to_string()))?;
        Ok(read.layer_data.channel_data.pixels)
    }
}

impl DisplayImage {
    /// Writes an 8-bit RGB PNG file, whole or not at all.
    ///
    /// # Errors
    /// [`ImageError::Io`] or, for a picture without pixels, [`ImageError::Encode`].
    pub fn write_png(&self, path: &Path) -> Result<(), ImageError> {
        let mut bytes = Cursor::new(Vec::new());
        PngEncoder::new(&mut bytes)
            .write_image(self.pixels.as_flattened(), self.width, self.height, image::ExtendedColorType::Rgb8)
            .map_err(|error| ImageError::Encode { path: path.into(), reason: error.to_string() })?;
        write(path, bytes.get_ref())
    }
}

/// Writes a file, whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    write_atomically(path, |file| file.write_all(bytes)).map_err(|source| ImageError::Io {
        action: "write",
        path: path.into(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::tests::gradient;

    #[test]
    fn exr_keeps_every_bit_and_the_row_order() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let image = gradient();
        image.write_exr(&path).unwrap();
        let back = Image::read_exr(&path).unwrap();
        assert_eq!(back, image);
        let mut flipped = image.clone();
        flipped.pixels.reverse();
        assert_ne!(back, flipped, "the comparison must see a picture upside down");
    }

    #[test]
    fn damaged_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        gradient().write_exr(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in [0, 3, 50, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(matches!(Image::read_exr(&path), Err(ImageError::Format { .. })), "{length} bytes");
        }
        assert!(matches!(Image::read_exr(&folder.path().join("none.exr")), Err(ImageError::Io { .. })));
    }

    #[test]
    fn absurd_sizes_are_refused_before_memory_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        gradient().write_exr(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        // The data window's largest x and y follow the attribute's name, type and size.
        let name = b"dataWindow\0box2i\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        for offset in [8, 12] {
            bytes[at + offset..at + offset + 4].copy_from_slice(&1_000_000i32.to_le_bytes());
        }
        std::fs::write(&path, &bytes).unwrap();
        assert!(matches!(Image::read_exr(&path), Err(ImageError::Format { .. })));
    }

    #[test]
    fn png_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut picture = DisplayImage::filled(3, 2, [10, 20, 30]);
        picture.pixels[4] = [255, 0, 128];
        picture.write_png(&path).unwrap();
        let back = image::open(&path).unwrap().into_rgb8();
        assert_eq!(back.dimensions(), (3, 2));
        assert_eq!(back.into_raw(), picture.pixels.as_flattened());
    }
}
