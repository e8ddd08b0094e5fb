//! From file bytes to a checked document.

use gltf::Document;
use gltf::json;
use gltf::json::validation::Checked;
use serde_json::Value;

use super::motion::MotionSource;
use super::tidy::tidy;
use super::{Reason, Warnings, extensions};

/// Parses `.glb` (told by its magic number) or `.gltf` and checks every index. Returns the document, what tells how it
/// moves, and the binary chunk, if there is one.
pub(super) fn parse<'a>(
    bytes: &'a [u8],
    warnings: &mut Warnings,
) -> Result<(Document, MotionSource, Option<&'a [u8]>), Reason> {
    let (text, binary) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let unreadable =
        |error: serde_json::Error| format!("its JSON cannot be read ({error}); export it again as glTF 2.0");
    let mut document: Value = serde_json::from_slice(without_padding(text)).map_err(unreadable)?;
    extensions::check(&document, warnings)?;
    let motion = MotionSource::take(&mut document);
    tidy(&mut document, warnings);
    let root: json::Root = serde_json::from_value(document).map_err(unreadable)?;
    check_version(&root)?;
    check_before_validation(&root)?;
    let document = Document::from_json(root).map_err(|error| reason_from_validation(&error))?;
    Ok((document, motion, binary))
}

/// JSON without the mark of its byte order at its start, which editors leave, and the zeros at its end, with which some
/// exporters fill up the chunk.
fn without_padding(text: &[u8]) -> &[u8] {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let end = text.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    &text[..end]
}

/// Splits a binary glTF into its JSON and its binary chunk.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Reason> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let truncated =
        || format!("it ends after {} bytes, before its header says; it is truncated", bytes.len());
    let version = word(4).ok_or_else(truncated)?;
    if version != 2 {
        return Err(format!("it is a version {version} container; only version 2 can be read"));
    }
    let length = word(8).ok_or_else(truncated)? as usize;
    if length > bytes.len() {
        return Err(format!("it has {} of {length} bytes; it is truncated", bytes.len()));
    }
    let chunk = |at: usize| {
        let size = word(at)? as usize;
        let kind = bytes.get(at + 4..at + 8)?;
        Some((kind, bytes.get(at + 8..)?.get(..size)?))
    };
    let (kind, text) = chunk(12).ok_or_else(truncated)?;
    if kind != b"JSON" {
        return Err("its first chunk is not JSON".into());
    }
    let next = 20 + text.len();
    if next >= length {
        return Ok((text, None));
    }
    let (kind, binary) = chunk(next).ok_or_else(truncated)?;
    Ok((text, (kind == b"BIN\0").then_some(binary)))
}

fn check_version(root: &json::Root) -> Result<(), Reason> {
    let version = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    if version.starts_with("2.") {
        return Ok(());
    }
    Err(format!("it is glTF {version}; only glTF 2.x can be read"))
}

/// Refuses what the `gltf` crate takes for granted, and would panic on.
fn check_before_validation(root: &json::Root) -> Result<(), Reason> {
    let accessors = root.accessors.len();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(index) = primitive.attributes.values().find(|index| index.value() >= accessors) {
                return Err(format!("meshes[{m}].primitives[{p}] uses accessor {index}, of {accessors}"));
            }
        }
    }
    for (i, image) in root.images.iter().enumerate() {
        if image.uri.is_none() && image.buffer_view.is_none() {
            return Err(format!("images[{i}] has neither a uri nor a bufferView"));
        }
    }
    for (c, camera) in root.cameras.iter().enumerate() {
        let complete = match camera.type_ {
            Checked::Valid(json::camera::Type::Perspective) => camera.perspective.is_some(),
            Checked::Valid(json::camera::Type::Orthographic) => camera.orthographic.is_some(),
            Checked::Invalid => true,
        };
        if !complete {
            return Err(format!("cameras[{c}] lacks the numbers for its type"));
        }
    }
    Ok(())
}

fn reason_from_validation(error: &gltf::Error) -> Reason {
    let gltf::Error::Validation(problems) = error else { return error.to_string() };
    let listed: Vec<String> =
        problems.iter().take(3).map(|(path, problem)| format!("{path}: {problem}")).collect();
    let more = problems.len().saturating_sub(listed.len());
    let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("it breaks the glTF rules at {}{tail}", listed.join("; "))
}
