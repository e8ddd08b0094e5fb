//! Which extensions of glTF are read, which may be left out, and which make a file unreadable.

use serde_json::Value;

use super::{Reason, Warnings};

/// Extensions that are read as they are meant.
const READ: [&str; 7] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions that pack meshes or images, and how to unpack a scene.
const COMPRESSION: [(&str, &str); 6] = [
    ("EXT_meshopt_compression", UNPACK_MESHES),
    ("EXT_texture_avif", "gltf-transform png scene.glb unpacked.glb"),
    ("KHR_draco_mesh_compression", UNPACK_MESHES),
    ("KHR_meshopt_compression", UNPACK_MESHES),
    ("KHR_texture_basisu", "gltf-transform ktxdecompress scene.glb unpacked.glb"),
    ("MSFT_texture_dds", "gltf-transform png scene.glb unpacked.glb"),
];

/// glTF Transform unpacks what it reads, and packs nothing that it is not told to.
const UNPACK_MESHES: &str = "gltf-transform copy scene.glb unpacked.glb";

/// Beginnings of the names of extensions that add something to meshes or nodes and change neither.
const ADDITIONS: [&str; 16] = [
    "AGI_",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "KHR_audio",
    "KHR_materials_",
    "KHR_node_",
    "KHR_physics_",
    "KHR_xmp",
    "MSFT_lod",
    "OMI_",
    "VRM",
];

/// Arrays whose elements say what is where and what is painted on it.
const GEOMETRY_AND_IMAGES: [&str; 9] =
    ["accessors", "bufferViews", "buffers", "images", "meshes", "nodes", "samplers", "scenes", "textures"];

/// Refuses a document that cannot be read without an extension that is not supported. Counts the extensions that are
/// left out: those that the file can do without, and required ones that change nothing but how materials shine.
pub(super) fn check(document: &Value, warnings: &mut Warnings) -> Result<(), Reason> {
    let required = names(document, "extensionsRequired");
    let mut used = names(document, "extensionsUsed");
    used.extend(&required);
    used.sort_unstable();
    used.dedup();
    for name in used.into_iter().filter(|name| !READ.contains(name)) {
        let is_required = required.contains(&name);
        let compression = COMPRESSION.iter().find(|(other, _)| *other == name);
        match compression {
            Some((_, command)) if is_required => {
                return Err(format!(
                    "it is packed with {name}, which cannot be read; unpack it with `{command}`"
                ));
            }
            // Whoever does not require it has written the plain data too.
            Some(_) => {}
            None if is_required && changes_geometry(document, name) => {
                return Err(format!(
                    "it requires {name}, which is not supported and changes meshes, nodes or images; export it without"
                ));
            }
            None => warnings.add(left_out(name), 1),
        }
    }
    Ok(())
}

fn left_out(name: &str) -> String {
    let instead = match name {
        "KHR_materials_pbrSpecularGlossiness" => "of its materials the diffuse part is read",
        "KHR_materials_unlit" => {
            "its materials are taken as diffuse; give them emission if they should shine"
        }
        _ if name.contains("_materials_") => "light takes surfaces as opaque and diffuse",
        _ => "check that the scene is complete without it",
    };
    format!("extension {name} is left out: {instead}")
}

fn names<'a>(document: &'a Value, list: &str) -> Vec<&'a str> {
    let names = document.get(list).and_then(Value::as_array);
    names.into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Whether an extension stands where geometry or images are described, and is not known to leave them alone.
fn changes_geometry(document: &Value, name: &str) -> bool {
    let is_addition = ADDITIONS.iter().any(|beginning| name.starts_with(beginning));
    let carries = |element: &Value| element.get("extensions").is_some_and(|all| all.get(name).is_some());
    !is_addition
        && GEOMETRY_AND_IMAGES.iter().any(|array| {
            let elements = document.get(*array).and_then(Value::as_array);
            elements.into_iter().flatten().any(|element| {
                let primitives = element.get("primitives").and_then(Value::as_array);
                carries(element) || primitives.into_iter().flatten().any(carries)
            })
        })
}
