//! From file bytes to a checked document.

use gltf::Document;
use gltf::json;
use gltf::json::validation::Checked;

use super::{Reason, Warnings};

/// Extensions that may stand in `extensionsRequired`.
const SUPPORTED_EXTENSIONS: [&str; 4] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Parses `.glb` (told by its magic number) or `.gltf` and checks every index. Returns the document and the
/// binary chunk, if there is one.
pub(super) fn parse<'a>(
    bytes: &'a [u8],
    warnings: &mut Warnings,
) -> Result<(Document, Option<&'a [u8]>), Reason> {
    let (text, binary) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let mut root = json::Root::from_slice(text)
        .map_err(|error| format!("its JSON cannot be read ({error}); export it again as glTF 2.0"))?;
    check_version(&root)?;
    check_required_extensions(&mut root)?;
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
        warnings.add(format!("extension {name}, which is not supported and not required, ignored"), 1);
    }
    prepare_for_validation(&mut root)?;
    let document = Document::from_json(root).map_err(|error| reason_from_validation(&error))?;
    Ok((document, binary))
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

/// Refuses the file if it cannot be shown without an extension that is not supported.
fn check_required_extensions(root: &mut json::Root) -> Result<(), Reason> {
    let unsupported: Vec<&str> = root
        .extensions_required
        .iter()
        .map(String::as_str)
        .filter(|name| !SUPPORTED_EXTENSIONS.contains(name))
        .collect();
    if !unsupported.is_empty() {
        return Err(format!(
            "it requires {}, which is not supported; export it without (supported: {})",
            unsupported.join(", "),
            SUPPORTED_EXTENSIONS.join(", ")
        ));
    }
    // The crate's own list is another one than ours.
    root.extensions_required.clear();
    Ok(())
}

/// Refuses or repairs what the `gltf` crate takes for granted, and would panic on.
fn prepare_for_validation(root: &mut json::Root) -> Result<(), Reason> {
    let accessors = root.accessors.len();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(index) = primitive.attributes.values().find(|index| index.value() >= accessors) {
                return Err(format!("meshes[{m}].primitives[{p}] uses accessor {index}, of {accessors}"));
            }
        }
    }
    for (i, image) in root.images.iter_mut().enumerate() {
        if image.uri.is_none() && image.buffer_view.is_none() {
            return Err(format!("images[{i}] has neither a uri nor a bufferView"));
        }
        // Images are told by their content.
        image.mime_type.get_or_insert_with(|| json::image::MimeType(String::new()));
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
