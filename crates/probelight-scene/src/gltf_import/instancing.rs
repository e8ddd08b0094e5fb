//! Nodes that show their mesh many times (`EXT_mesh_gpu_instancing`).

use gltf::Document;
use gltf::accessor::Dimensions;
use probelight_math::glam::{Mat4, Quat, Vec3, Vec4};
use serde_json::Value;

use super::Reason;
use super::accessors::Elements;
use super::resources::Resources;

/// The extension's attributes of a node, if it has any.
fn attributes<'a>(node: &'a gltf::Node<'_>) -> Option<&'a Value> {
    node.extension_value("EXT_mesh_gpu_instancing")?.get("attributes")
}

fn accessor<'a>(document: &'a Document, attributes: &Value, name: &str) -> Option<gltf::Accessor<'a>> {
    let index = attributes.get(name)?.as_u64()?;
    document.accessors().nth(usize::try_from(index).ok()?)
}

/// How many copies of its mesh a node claims to show.
pub(super) fn claimed_copies(document: &Document, node: &gltf::Node<'_>) -> usize {
    let Some(attributes) = attributes(node) else { return 1 };
    let counts = ["TRANSLATION", "ROTATION", "SCALE"].map(|name| accessor(document, attributes, name));
    counts.into_iter().flatten().map(|accessor| accessor.count()).min().unwrap_or(1)
}

/// The place of each copy in the node's space; one without the extension.
pub(super) fn node_from_copies(
    document: &Document,
    node: &gltf::Node<'_>,
    resources: &Resources<'_>,
) -> Result<Vec<Mat4>, Reason> {
    let Some(attributes) = attributes(node) else { return Ok(vec![Mat4::IDENTITY]) };
    let read = |name: &str, dimensions: Dimensions| {
        let Some(accessor) = accessor(document, attributes, name) else { return Ok(None) };
        Elements::new(&accessor, dimensions, resources)?.backed(&accessor).map(Some)
    };
    let translations = read("TRANSLATION", Dimensions::Vec3)?;
    let rotations = read("ROTATION", Dimensions::Vec4)?;
    let scales = read("SCALE", Dimensions::Vec3)?;
    let place = |copy: usize| {
        let scale = scales.as_ref().map_or(Vec3::ONE, |scales| Vec3::from(scales.vector(copy)));
        let rotation = rotations.as_ref().map_or(Vec4::W, |rotations| Vec4::from(rotations.vector(copy)));
        let rotation = Quat::from_vec4(rotation.normalize_or(Vec4::W));
        let translation = translations.as_ref().map_or(Vec3::ZERO, |moves| Vec3::from(moves.vector(copy)));
        Mat4::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok((0..claimed_copies(document, node)).map(place).collect())
}
