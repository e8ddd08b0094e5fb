//! Reading glTF 2.0 (`.glb`, `.gltf`).
//!
//! The `gltf` crate parses the JSON and checks its indices; its accessor readers, URI reader and camera and
//! image views panic on some broken files, so this module has its own. In the order of use:
//!
//! | file | from | to |
//! | --- | --- | --- |
//! | `container`, `extensions`, `tidy` | file bytes | checked document and binary chunk |
//! | `resources` | URIs, buffer views | bytes |
//! | `accessors` | bytes | typed elements |
//! | `images`, `materials` | documents' materials | [`Material`](crate::Material)s with [`Texture`](crate::Texture)s |
//! | `primitives`, `topology`, `tangents` | accessors | triangles in mesh space |
//! | `nodes`, `instancing`, `lights` | node tree | instances, lights and cameras in world space |
//! | `motion` | skins, animations | what moves the vertices of an [`AnimatedModel`](crate::AnimatedModel) |

mod accessors;
mod container;
mod extensions;
mod images;
mod instancing;
mod lights;
mod materials;
mod motion;
mod nodes;
mod primitives;
mod resources;
mod tangents;
mod tidy;
mod topology;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use self::motion::{Motion, MotionInput};
use crate::{AnimatedModel, Scene, SceneError, Warning};

/// What is wrong with the file, where, and what to do; [`load_gltf`] adds the path.
type Reason = String;

/// Counts of what was repaired or left out, by message.
#[derive(Default)]
struct Warnings(BTreeMap<String, usize>);

impl Warnings {
    fn add(&mut self, message: impl Into<String>, count: usize) {
        if count > 0 {
            *self.0.entry(message.into()).or_default() += count;
        }
    }

    fn into_vec(self) -> Vec<Warning> {
        self.0.into_iter().map(|(message, count)| Warning { message, count }).collect()
    }
}

/// Reads a glTF 2.0 file and everything it refers to, flattened to world space.
///
/// Lights of `KHR_lights_punctual` are taken as radiometric: intensity times colour is W/sr for point and
/// spot lights (the file says candela) and W/m² for directional ones (the file says lux). Emission is
/// `emissiveFactor` times `KHR_materials_emissive_strength` in W·m⁻²·sr⁻¹. Cameras, which have no resolution
/// in glTF, get a height of 512 pixels.
///
/// Required extensions that only change how surfaces shine are left out; of specular-glossiness materials the diffuse
/// part is read. Alpha blending becomes a mask at 0.5; vertex colours are ignored; morph targets stay at rest and skins in
/// their bind pose. What is repaired or left out is counted in [`Scene::warnings`].
///
/// # Errors
/// [`SceneError::Read`] if the file cannot be read, [`SceneError::Gltf`] if it or a file it refers to is
/// broken, claims more than it holds, lies outside the scene's folder, or requires an extension that packs or
/// changes geometry or images and is not supported.
pub fn load_gltf(path: &Path) -> Result<Scene, SceneError> {
    let bytes =
        resources::read_document(path).map_err(|source| SceneError::Read { path: path.into(), source })?;
    parse_gltf(&bytes, path)
}

/// Like [`load_gltf`], for a file already in memory. `path` is the name in errors; relative URIs start from
/// its folder.
///
/// # Errors
/// [`SceneError::Gltf`], as [`load_gltf`].
pub fn parse_gltf(bytes: &[u8], path: &Path) -> Result<Scene, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let read = scene_and_motion(bytes, folder, false);
    read.map(|(scene, _)| scene).map_err(|reason| SceneError::Gltf { path: path.into(), reason })
}

/// Like [`load_gltf`], with the skins and animations that move it.
///
/// # Errors
/// As [`load_gltf`], and [`SceneError::Gltf`] if a skin or an animation is broken.
pub fn load_animated_gltf(path: &Path) -> Result<AnimatedModel, SceneError> {
    let bytes =
        resources::read_document(path).map_err(|source| SceneError::Read { path: path.into(), source })?;
    parse_animated_gltf(&bytes, path)
}

/// Like [`load_animated_gltf`], for a file already in memory, as [`parse_gltf`].
///
/// # Errors
/// [`SceneError::Gltf`], as [`load_animated_gltf`].
pub fn parse_animated_gltf(bytes: &[u8], path: &Path) -> Result<AnimatedModel, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let read = scene_and_motion(bytes, folder, true);
    let (mut scene, motion) = read.map_err(|reason| SceneError::Gltf { path: path.into(), reason })?;
    if motion.parts.iter().any(|part| part.skin.is_some()) {
        scene.warnings.retain(|warning| warning.message != tidy::LEFT_IN_BIND_POSE);
    }
    let Motion { nodes, parts, skins, clips } = motion;
    Ok(AnimatedModel { rest: Arc::new(scene), nodes, parts, skins, clips })
}

/// Reads a file, and how it moves if that is asked for.
fn scene_and_motion(bytes: &[u8], folder: &Path, moves: bool) -> Result<(Scene, Motion), Reason> {
    let mut warnings = Warnings::default();
    let (document, source, binary) = container::parse(bytes, &mut warnings)?;
    let resources = resources::Resources::load(&document, binary, folder)?;
    let materials = materials::import_materials(&document, &resources, &mut warnings)?;
    let nodes = nodes::placed_nodes(&document, &mut warnings)?;
    let mut parts = moves.then(Vec::new);
    let mut scene = nodes::flatten(&document, &resources, &materials, &nodes, &mut warnings, parts.as_mut())?;
    scene.materials = materials.materials;
    scene.textures = materials.textures;
    if scene.triangles.is_empty() {
        return Err(nothing_left(&warnings.into_vec()));
    }
    scene.validate().map_err(|error| error.to_string())?;
    let motion = parts.map(|parts| {
        let (source, document, resources, nodes) = (&source, &document, &resources, &nodes[..]);
        Motion::new(MotionInput { source, document, resources, nodes, parts }, &mut warnings)
    });
    let motion = motion.transpose()?.unwrap_or_default();
    warnings.add(
        "materials that reflect more than 95 % of the light, as nothing real does: between such walls light hardly \
         ends, and is wrong; lower their base colour to 0.8 or less",
        scene.materials_too_white(),
    );
    scene.warnings = warnings.into_vec();
    Ok((scene, motion))
}

/// Why there is no triangle.
fn nothing_left(warnings: &[Warning]) -> Reason {
    let found: String = warnings.iter().map(|warning| format!("; {warning}")).collect();
    format!("its scene has no triangles with area, so there is nothing to bake{found}")
}
