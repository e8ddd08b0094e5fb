//! Setup files: the lights, sky and cameras of one picture of a scene, as JSON.

use std::path::Path;

use crate::{Bounds, Camera, Lighting, SceneError};

/// Lights and cameras for one scene.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// What the setup is called.
    pub name: String,
    /// File name of the scene it was written for.
    pub scene: String,
    /// Lights, sky and emissive switch.
    pub lighting: Lighting,
    /// Cameras, in file order.
    pub cameras: Vec<Camera>,
    /// The region in which reference points were sampled, if not the whole scene.
    pub eval_bounds: Option<Bounds>,
}

impl Setup {
    /// Reads a setup file.
    ///
    /// # Errors
    /// See [`SceneError`].
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Err(SceneError::Setup { path: path.into(), reason: "not implemented yet".into() })
    }
}
