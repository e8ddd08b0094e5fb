//! Textures as PNG files inside the baked file: lossless, compact, the same bytes every time.

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, Limits};
use probelight_scene::Texture;

use crate::error::DecodeError;

/// No deflate stream expands by more than this factor, so an image that claims more is lying.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// All textures together may take this many bytes unpacked however small their files are: 1 GiB, four plain images of
/// 8192 × 8192 texels.
const FREE_TEXTURE_BYTES: u64 = 1 << 30;

/// More than that must come from files that hold something: at least one byte for each of these.
const MAX_TEXTURE_RATIO: u64 = 64;

/// The PNG files of the textures, each behind its length.
pub(crate) fn encode_textures(textures: &[Texture]) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    for texture in textures {
        let start = bytes.len();
        bytes.extend(0u64.to_le_bytes());
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(&texture.rgba8, texture.width, texture.height, ExtendedColorType::Rgba8)?;
        let length = (bytes.len() - start - size_of::<u64>()) as u64;
        bytes[start..start + size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    }
    Ok(bytes)
}

/// Decodes what [`encode_textures`] made of textures with these names.
pub(crate) fn decode_textures(names: Vec<String>, bytes: &[u8]) -> Result<Vec<Texture>, DecodeError> {
    let mut rest = bytes;
    let mut allowance = FREE_TEXTURE_BYTES.max(MAX_TEXTURE_RATIO * bytes.len() as u64);
    let mut textures = Vec::new();
    for (t, name) in names.into_iter().enumerate() {
        let texture = split_file(&mut rest).and_then(|png| decode_png(png, &mut allowance));
        let (width, height, rgba8) = texture
            .map_err(|what| DecodeError::Format(format!("its texture {t} ('{name}') is damaged: {what}")))?;
        textures.push(Texture { name, width, height, rgba8: rgba8.into() });
    }
    if !rest.is_empty() {
        return Err(DecodeError::format("it holds image data that belongs to no texture"));
    }
    Ok(textures)
}

/// Takes the first file off `rest`.
fn split_file<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], String> {
    let cut_off = || "it is cut off".to_string();
    let (length, behind) = rest.split_first_chunk().ok_or_else(cut_off)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
    let (png, behind) = behind.split_at_checked(length).ok_or_else(cut_off)?;
    *rest = behind;
    Ok(png)
}

/// Width, height and texels. `allowance` is what all textures together may still take, bytes.
fn decode_png(png: &[u8], allowance: &mut u64) -> Result<(u32, u32, Vec<u8>), String> {
    let [width, height] = claimed_size(png).ok_or("it has no size")?;
    let claimed = (u64::from(width) * u64::from(height)).saturating_mul(4);
    if claimed > MAX_DEFLATE_RATIO * png.len() as u64 {
        return Err(format!("{} bytes cannot hold {width} × {height} texels", png.len()));
    }
    *allowance =
        allowance.checked_sub(claimed).ok_or("all textures together would be far larger than the file")?;
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(width);
    limits.max_image_height = Some(height);
    // The decoder's own buffers (a few rows, chunks of metadata) come on top of the image.
    limits.max_alloc = Some(claimed + (1 << 20));
    let decoder = PngDecoder::with_limits(Cursor::new(png), limits).map_err(|error| error.to_string())?;
    if decoder.dimensions() != (width, height) || decoder.color_type() != ColorType::Rgba8 {
        return Err("it is not an RGBA image of eight bits".into());
    }
    let mut rgba8 = vec![0; usize::try_from(claimed).map_err(|_| "it is too large")?];
    decoder.read_image(&mut rgba8).map_err(|error| error.to_string())?;
    Ok((width, height, rgba8))
}

/// Width and height as a PNG file claims them in its first chunk, whose content starts at byte 16.
fn claimed_size(png: &[u8]) -> Option<[u32; 2]> {
    let number = |at: usize| Some(u32::from_be_bytes(*png.get(at..)?.first_chunk()?));
    Some([number(16)?, number(20)?])
}
