//! What is saved when the window ends by accident.

use std::path::PathBuf;

use eframe::egui::ViewportCommand;

use crate::viewer::Viewer;

impl Viewer {
    /// The GPU is lost, and with it all that can be shown: the window ends.
    pub(crate) fn end_without_gpu(&mut self) {
        self.rescue();
        self.context.send_viewport_cmd(ViewportCommand::Close);
    }

    /// Saves changes of the setup under a name of its own, beside the setup or the scene, or where temporary files are.
    fn rescue(&mut self) {
        let file = self.setup_file.as_ref().or(self.scene_file.as_ref());
        let name = self.name_with("rescued.json");
        let beside = file.map_or_else(|| PathBuf::from(&name), |file| file.with_file_name(&name));
        for path in [beside, std::env::temp_dir().join(name)] {
            if self.state.is_changed {
                self.save_setup(&path);
                if !self.state.is_changed {
                    // Nobody set it before: what was saved once has not changed.
                    _ = self.rescued.set(path);
                }
            }
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.rescue();
        }
    }
}
