//! Asks for files, in a window of its own within the window.

use std::path::PathBuf;

use egui_file_dialog::{FileDialog, FileDialogConfig};

use super::file::free_name;
use crate::scene::loader::Purpose;
use crate::viewer::{DialogPurpose, Viewer};

/// The one dialog there can be.
pub struct Dialogs {
    dialog: FileDialog,
    purpose: Option<DialogPurpose>,
}

impl Dialogs {
    /// Nothing is asked.
    pub fn new() -> Self {
        Self { dialog: FileDialog::new(), purpose: None }
    }
}

impl Default for Dialogs {
    fn default() -> Self {
        Self::new()
    }
}

impl Viewer {
    /// Asks for a file.
    pub(crate) fn choose(&mut self, purpose: DialogPurpose) {
        let folder = self.setup_file.as_ref().or(self.scene_file.as_ref()).and_then(|file| file.parent());
        let mut dialog = FileDialog::with_config(FileDialogConfig::default());
        if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
            dialog = dialog.initial_directory(folder.into());
        }
        dialog = match purpose {
            DialogPurpose::Open => dialog
                .add_file_filter_extensions("scenes, bakes and setups", vec!["glb", "gltf", "plight", "json"])
                .default_file_filter("scenes, bakes and setups"),
            DialogPurpose::Object => {
                dialog.add_file_filter_extensions("glTF", vec!["glb", "gltf"]).default_file_filter("glTF")
            }
            DialogPurpose::SaveSetup => {
                dialog.add_save_extension("setup", "json").default_file_name(&self.name_with("json"))
            }
            DialogPurpose::SaveBake => {
                dialog.add_save_extension("bake", "plight").default_file_name(&self.name_with("plight"))
            }
        };
        match purpose {
            DialogPurpose::Open | DialogPurpose::Object => dialog.pick_file(),
            DialogPurpose::SaveSetup | DialogPurpose::SaveBake => dialog.save_file(),
        }
        self.dialogs = Dialogs { dialog, purpose: Some(purpose) };
    }

    /// Shows the dialog, and takes what was chosen.
    pub(crate) fn show_dialogs(&mut self) {
        self.dialogs.dialog.update(&self.context);
        if let Some(path) = self.dialogs.dialog.take_picked() {
            self.chosen(path);
        }
    }

    /// A file was chosen.
    fn chosen(&mut self, path: PathBuf) {
        match self.dialogs.purpose.take() {
            Some(DialogPurpose::Open) => self.open(path.into()),
            Some(DialogPurpose::Object) => self.loader.read(path.into(), Purpose::Object, &self.gpu),
            Some(DialogPurpose::SaveSetup) => self.save_setup(&path),
            Some(DialogPurpose::SaveBake) => self.save_bake(&path),
            None => {}
        }
    }

    /// Saves the baked file.
    fn save_bake(&mut self, path: &std::path::Path) {
        let Some(live) = self.live.as_ref().filter(|live| live.is_baked) else {
            return self.messages.error("there is no bake to save yet");
        };
        match live.baked.write(path) {
            Ok(()) => self.messages.note(format!("saved {}", path.display())),
            Err(error) => self.messages.error(error.to_string()),
        }
    }

    /// Saves the picture under the next free name.
    pub(crate) fn screenshot(&mut self) {
        let path = free_name(|number| format!("probelight-{number}.png"));
        let written = self.read_picture().map_err(|error| error.to_string());
        match written.and_then(|image| image.write_png(&path).map_err(|error| error.to_string())) {
            Ok(()) => self.messages.note(format!("saved {}", path.display())),
            Err(error) => self.messages.error(error),
        }
    }
}
