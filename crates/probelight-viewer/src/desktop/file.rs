//! Files on the disk.

use std::io::Write;
use std::path::{Path, PathBuf};

use eframe::egui::DroppedFile;
use probelight_asset::{BakedScene, write_atomically};
use probelight_scene::{AnimatedModel, Scene, Setup, load_animated_gltf, load_gltf};

/// A file to be read. What reads it returns errors that name it.
#[derive(Clone, Debug)]
pub struct File(PathBuf);

impl From<PathBuf> for File {
    fn from(path: PathBuf) -> Self {
        Self(path)
    }
}

impl File {
    /// One that was dropped into the window.
    pub fn dropped(file: &DroppedFile) -> Option<Self> {
        file.path.clone().map(Self)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Reads a setup.
    pub(crate) async fn setup(&self) -> Result<Setup, String> {
        Setup::load(&self.0).map_err(|error| error.to_string())
    }

    /// Reads a baked file.
    pub(crate) async fn bake(&self) -> Result<BakedScene, String> {
        BakedScene::read(&self.0).map_err(|error| error.to_string())
    }

    /// Reads a scene.
    pub(crate) async fn scene(&self) -> Result<Scene, String> {
        load_gltf(&self.0).map_err(|error| error.to_string())
    }

    /// Reads a model for objects.
    pub(crate) async fn model(&self) -> Result<AnimatedModel, String> {
        load_animated_gltf(&self.0).map_err(|error| error.to_string())
    }
}

/// The first name that nothing has yet: of the numbers from 001 on, in the working folder.
pub(crate) fn free_name(name_of: impl Fn(&str) -> String) -> PathBuf {
    let mut names = (1..).map(|number: u32| PathBuf::from(name_of(&format!("{number:03}"))));
    names.find(|path| !path.exists()).unwrap_or_default()
}

/// Writes a file, whole or not at all.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), String> {
    write_atomically(path, |out| out.write_all(bytes))
        .map_err(|error| format!("{} cannot be written: {error}", path.display()))
}
