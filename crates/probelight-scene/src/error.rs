//! What can be wrong with an input, in words that say what to do.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Why a scene or setup file was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read at all.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not what its name says, or breaks its format's rules.
    #[error("{path} is not a usable glTF file: {reason}")]
    Gltf {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        reason: String,
    },
    /// The setup file breaks its format's rules.
    #[error("{path} is not a usable setup file: {reason}")]
    Setup {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        reason: String,
    },
    /// A setup has no such camera.
    #[error("setup \"{setup}\" has no {}; {}", wanted_camera(name.as_deref()), list_of_cameras(available))]
    Camera {
        /// The setup's name.
        setup: String,
        /// The camera that was asked for; `None` for any.
        name: Option<String>,
        /// The cameras there are.
        available: Vec<String>,
    },
    /// Triangles that cannot be used, whatever file they came from.
    #[error("the scene cannot be used: {reason}")]
    Invalid {
        /// What is wrong, where, and what to do.
        reason: String,
    },
}

fn wanted_camera(name: Option<&str>) -> String {
    name.map_or("camera".into(), |name| format!("camera \"{name}\""))
}

fn list_of_cameras(available: &[String]) -> String {
    if available.is_empty() {
        "add one to its cameras".into()
    } else {
        format!("it has: {}", available.join(", "))
    }
}

/// Something harmless that was repaired or left out while reading a scene, with how often it occurred.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// What was found, what was done about it, and what the user may do ("textures that clamp, repeated instead; …").
    pub message: String,
    /// How often.
    pub count: usize,
}

impl Display for Warning {
    /// The message, with the count if it is not one.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { message, count } = self;
        if *count == 1 { f.write_str(message) } else { write!(f, "{message} ({count} times)") }
    }
}
