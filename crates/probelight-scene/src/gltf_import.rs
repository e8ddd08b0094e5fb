//! Reading glTF 2.0 (.glb, .gltf).

use std::path::Path;

use crate::{Scene, SceneError};

/// Reads a glTF 2.0 file and everything it refers to.
///
/// # Errors
/// See [`SceneError`].
pub fn load_gltf(path: &Path) -> Result<Scene, SceneError> {
    Err(SceneError::Gltf { path: path.into(), reason: "not implemented yet".into() })
}
