//! Decoding PNG, JPEG and WebP images to 8-bit RGBA.

use std::io::Cursor;

use image::{ImageError, ImageFormat, ImageReader, Limits};

use super::Reason;
use super::resources::Resources;
use super::tidy::NO_IMAGE;
use crate::Texture;

/// Largest width and height, texels.
const MAX_SIDE: u32 = 8192;
/// More texels per encoded byte than any PNG (1 bit a texel, deflated at most 1032 : 1) or JPEG can have: such
/// a claim is a lie, refused before memory is spent on it. A WebP of one colour needs no bytes for its texels.
const MAX_TEXELS_PER_BYTE: u64 = 8 * 1032;
/// Memory the decoder may use besides its result, bytes.
const DECODER_MEMORY: u64 = 1 << 30;

/// Whether an image of the document is more than a stand-in.
pub(super) fn is_there(image: &gltf::Image<'_>) -> bool {
    !matches!(image.source(), gltf::image::Source::Uri { uri: NO_IMAGE, .. })
}

/// Reads and decodes an image of the document to at most `budget` bytes.
pub(super) fn decode_image(
    image: &gltf::Image<'_>,
    resources: &Resources<'_>,
    budget: u64,
) -> Result<Texture, Reason> {
    let fail = |reason: Reason| format!("images[{}]: {reason}", image.index());
    let owned;
    let (bytes, uri) = match image.source() {
        gltf::image::Source::View { view, .. } => (resources.view(&view).map_err(fail)?, None),
        gltf::image::Source::Uri { uri, .. } => {
            owned = resources.read_image(uri).map_err(fail)?;
            (owned.as_slice(), Some(uri).filter(|uri| !uri.starts_with("data:")))
        }
    };
    let name = image.name().or(uri).unwrap_or_default().to_owned();
    decode(bytes, name, budget).map_err(fail)
}

/// Decodes a file of any bit depth and channel count.
fn decode(bytes: &[u8], name: String, budget: u64) -> Result<Texture, Reason> {
    let unusable = |error: ImageError| format!("cannot be decoded as PNG, JPEG or WebP ({error})");
    let reader = || {
        let reader = ImageReader::new(Cursor::new(bytes));
        reader.with_guessed_format().map_err(|error| unusable(error.into()))
    };
    let first = reader()?;
    let may_need_no_bytes = first.format() == Some(ImageFormat::WebP);
    let (width, height) = first.into_dimensions().map_err(unusable)?;
    let texels = u64::from(width) * u64::from(height);
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("is {width} × {height} texels; at most {MAX_SIDE} × {MAX_SIDE} can be used"));
    }
    let most_texels = if may_need_no_bytes { u64::MAX } else { bytes.len() as u64 * MAX_TEXELS_PER_BYTE };
    if texels == 0 || texels > most_texels {
        return Err(format!("claims {width} × {height} texels, but has only {} bytes", bytes.len()));
    }
    if texels * 4 > budget {
        return Err("is one too many: all textures together need more than 4 GiB; make them smaller".into());
    }
    let mut reader = reader()?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODER_MEMORY);
    reader.limits(limits);
    let rgba8 = reader.decode().map_err(unusable)?.into_rgba8().into_raw();
    Ok(Texture { name, width, height, rgba8: rgba8.into() })
}
