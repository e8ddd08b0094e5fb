//! Textures as PNG files inside the baked file: lossless, compact, the same bytes every time.

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, Limits};
use probelight_scene::Texture;
use serde::{Deserialize, Serialize};

use crate::error::DecodeError;

/// No deflate stream expands by more than this factor, so an image that claims more is lying.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// One texture in the list of textures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TextureEntry {
    /// [`Texture::name`].
    pub(crate) name: String,
    /// Width in texels.
    pub(crate) width: u32,
    /// Height in texels.
    pub(crate) height: u32,
    /// Bytes of the PNG file.
    pub(crate) png_length: u64,
}

/// Encodes `textures`; returns their list and their PNG files one after the other.
pub(crate) fn encode_textures(textures: &[Texture]) -> Result<(Vec<TextureEntry>, Vec<u8>), ImageError> {
    let mut entries = Vec::with_capacity(textures.len());
    let mut bytes = Vec::new();
    for texture in textures {
        let start = bytes.len();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(&texture.rgba8, texture.width, texture.height, ExtendedColorType::Rgba8)?;
        entries.push(TextureEntry {
            name: texture.name.clone(),
            width: texture.width,
            height: texture.height,
            png_length: (bytes.len() - start) as u64,
        });
    }
    Ok((entries, bytes))
}

/// Decodes what [`encode_textures`] made.
pub(crate) fn decode_textures(entries: &[TextureEntry], bytes: &[u8]) -> Result<Vec<Texture>, DecodeError> {
    let mut rest = bytes;
    let textures = entries
        .iter()
        .enumerate()
        .map(|(t, entry)| {
            let damaged = |what: &dyn std::fmt::Display| {
                DecodeError::Format(format!("its texture {t} ('{}') is damaged: {what}", entry.name))
            };
            let length = usize::try_from(entry.png_length).unwrap_or(usize::MAX);
            let (png, behind) = rest.split_at_checked(length).ok_or_else(|| damaged(&"it is cut off"))?;
            rest = behind;
            decode_png(entry, png).map_err(|error| damaged(&error))
        })
        .collect::<Result<_, _>>()?;
    if !rest.is_empty() {
        return Err(DecodeError::format("it holds image data that belongs to no texture"));
    }
    Ok(textures)
}

fn decode_png(entry: &TextureEntry, png: &[u8]) -> Result<Texture, String> {
    let claimed = (u64::from(entry.width) * u64::from(entry.height)).saturating_mul(4);
    if claimed > MAX_DEFLATE_RATIO * png.len() as u64 {
        return Err(format!("{} bytes cannot hold {} × {} texels", png.len(), entry.width, entry.height));
    }
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(entry.width);
    limits.max_image_height = Some(entry.height);
    // The decoder's own buffers (a few rows, chunks of metadata) come on top of the image.
    limits.max_alloc = Some(claimed + (1 << 20));
    let decoder = PngDecoder::with_limits(Cursor::new(png), limits).map_err(|error| error.to_string())?;
    if decoder.dimensions() != (entry.width, entry.height) || decoder.color_type() != ColorType::Rgba8 {
        return Err("the image is not what the list of textures says".into());
    }
    let mut rgba8 = vec![0; claimed as usize];
    decoder.read_image(&mut rgba8).map_err(|error| error.to_string())?;
    Ok(Texture { name: entry.name.clone(), width: entry.width, height: entry.height, rgba8 })
}
