//! From a document as it was written to one that the `gltf` crate accepts.
//!
//! The crate refuses valid files for parts that light has no use for (animations, attributes and extensions that it
//! does not know), and for parts that may be missing. Here the former go, and the latter are filled in.

use serde_json::{Map, Value, json};

use super::Warnings;

type Members = Map<String, Value>;

/// Arrays and objects of a document that are read.
const READ_MEMBERS: [&str; 14] = [
    "accessors",
    "asset",
    "bufferViews",
    "buffers",
    "cameras",
    "extensions",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scene",
    "scenes",
    "textures",
];

/// Vertex attributes that are read. Colours are only counted.
const READ_ATTRIBUTES: [&str; 8] =
    ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "JOINTS_0", "WEIGHTS_0"];

/// OpenGL's numbers for clamping, mirroring and repeating.
const WRAPPING_MODES: [u64; 3] = [33071, 33648, 10497];

/// Drops what is not read and fills in what may be missing, counting what changes the picture.
pub(super) fn tidy(document: &mut Value, warnings: &mut Warnings) {
    if let Some(members) = document.as_object_mut() {
        members.retain(|name, _| READ_MEMBERS.contains(&name.as_str()));
    }
    for scene in elements(document, "scenes") {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
    for node in elements(document, "nodes") {
        tidy_node(node, warnings);
    }
    for mesh in elements(document, "meshes") {
        let primitives = mesh.get_mut("primitives").and_then(Value::as_array_mut);
        for primitive in primitives.into_iter().flatten().filter_map(Value::as_object_mut) {
            tidy_primitive(primitive, warnings);
        }
    }
    tidy_accessors(document);
    for view in elements(document, "bufferViews") {
        view.remove("target");
        // Some exporters write 0 for elements without a gap.
        if view.get("byteStride") == Some(&json!(0)) {
            view.remove("byteStride");
        }
    }
    for sampler in elements(document, "samplers") {
        sampler.retain(|name, mode| {
            name.starts_with("wrap") && mode.as_u64().is_some_and(|mode| WRAPPING_MODES.contains(&mode))
        });
    }
    for image in elements(document, "images") {
        // Images are told by their content.
        image.insert("mimeType".into(), json!(""));
    }
    tidy_textures(document);
    for material in elements(document, "materials") {
        diffuse_from_other_models(material);
    }
}

/// The objects in a top-level array.
fn elements<'a>(document: &'a mut Value, array: &str) -> impl Iterator<Item = &'a mut Members> {
    let elements = document.get_mut(array).and_then(Value::as_array_mut);
    elements.into_iter().flatten().filter_map(Value::as_object_mut)
}

/// What is said of skins where nothing moves.
pub(super) const LEFT_IN_BIND_POSE: &str =
    "skinned meshes, left in their bind pose; apply the pose before the export";

fn tidy_node(node: &mut Members, warnings: &mut Warnings) {
    node.remove("weights");
    if node.remove("skin").is_some() && node.contains_key("mesh") {
        warnings.add(LEFT_IN_BIND_POSE, 1);
    }
}

fn tidy_primitive(primitive: &mut Members, warnings: &mut Warnings) {
    if primitive.remove("targets").is_some() {
        warnings.add("primitives with morph targets, left at rest; apply the shape before the export", 1);
    }
    if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
        attributes.retain(|name, _| READ_ATTRIBUTES.contains(&name.as_str()));
    }
}

/// Bounds, which are not read, are made up. Accessors without data are zeros, which the crate only allows with sparse
/// values: they get none of them.
fn tidy_accessors(document: &mut Value) {
    let has_data =
        |accessor: &Members| accessor.contains_key("bufferView") || accessor.contains_key("sparse");
    if elements(document, "accessors").any(|accessor| !has_data(accessor)) {
        add_view_of_zeros(document);
    }
    let view = elements(document, "bufferViews").count().saturating_sub(1);
    for accessor in elements(document, "accessors") {
        accessor.insert("min".into(), json!([0, 0, 0]));
        accessor.insert("max".into(), json!([0, 0, 0]));
        if !has_data(accessor) {
            let no_values = json!({
                "count": 0,
                "indices": {"bufferView": view, "componentType": 5121},
                "values": {"bufferView": view}
            });
            accessor.insert("sparse".into(), no_values);
        }
    }
}

/// Appends a buffer view of one byte.
fn add_view_of_zeros(document: &mut Value) {
    let buffer = push(document, "buffers", json!({"byteLength": 1, "uri": "data:;base64,AA=="}));
    push(document, "bufferViews", json!({"buffer": buffer, "byteLength": 1}));
}

/// Appends to a top-level array, and returns the new element's index.
fn push(document: &mut Value, array: &str, element: Value) -> Option<usize> {
    let array = document.as_object_mut()?.entry(array).or_insert_with(|| json!([])).as_array_mut()?;
    array.push(element);
    Some(array.len() - 1)
}

/// The `uri` of the image that textures without any get.
pub(super) const NO_IMAGE: &str = "data:,";

/// Textures without an image that is read get a stand-in: the crate only allows them with a feature that changes what its
/// functions return, which Bevy's glTF loader does not expect in an app that has both.
fn tidy_textures(document: &mut Value) {
    elements(document, "textures").for_each(choose_image);
    let has_image = |texture: &Members| texture.contains_key("source");
    if elements(document, "textures").all(|texture| has_image(texture)) {
        return;
    }
    let Some(stand_in) = push(document, "images", json!({"uri": NO_IMAGE, "mimeType": ""})) else { return };
    for texture in elements(document, "textures").filter(|texture| !has_image(texture)) {
        texture.insert("source".into(), json!(stand_in));
    }
}

/// Takes a texture's WebP image, which is said to be the better one, where it has one.
fn choose_image(texture: &mut Members) {
    let image = texture.get("extensions").and_then(|extensions| extensions.get("EXT_texture_webp"));
    if let Some(source) = image.and_then(|image| image.get("source")).cloned() {
        texture.insert("source".into(), source);
    }
}

/// The diffuse part of a material of another model, as metallic-roughness.
fn diffuse_from_other_models(material: &mut Members) {
    let Some(extensions) = material.get("extensions") else { return };
    if let Some(model) = extensions.get("KHR_materials_pbrSpecularGlossiness") {
        let mut diffuse = json!({"metallicFactor": 0, "roughnessFactor": 1});
        for (from, to) in [("diffuseFactor", "baseColorFactor"), ("diffuseTexture", "baseColorTexture")] {
            if let Some(value) = model.get(from) {
                diffuse[to] = value.clone();
            }
        }
        if let Some(glossiness) = model.get("glossinessFactor").and_then(Value::as_f64) {
            diffuse["roughnessFactor"] = json!(1.0 - glossiness);
        }
        material.insert("pbrMetallicRoughness".into(), diffuse);
    } else if extensions.get("KHR_materials_unlit").is_some() {
        let model = material.entry("pbrMetallicRoughness").or_insert_with(|| json!({}));
        if let Some(model) = model.as_object_mut() {
            model.insert("metallicFactor".into(), json!(0));
            model.insert("roughnessFactor".into(), json!(1));
        }
    }
}
