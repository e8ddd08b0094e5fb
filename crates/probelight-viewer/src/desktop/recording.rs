//! Saves all pictures that are drawn.

use std::path::PathBuf;

use probelight_render::DisplayImage;

use super::file::free_name;
use crate::viewer::Viewer;

/// Pictures in a folder of their own, numbered from one.
#[derive(Debug)]
pub struct Recording {
    folder: PathBuf,
    count: usize,
}

impl Recording {
    /// Makes the next free folder.
    fn start() -> Result<Self, String> {
        let folder = free_name(|number| format!("probelight-frames-{number}"));
        std::fs::create_dir(&folder)
            .map_err(|error| format!("{} cannot be made: {error}", folder.display()))?;
        Ok(Self { folder, count: 0 })
    }

    fn save(&mut self, picture: &DisplayImage) -> Result<(), String> {
        self.count += 1;
        let path = self.folder.join(format!("{:05}.png", self.count));
        picture.write_png(&path).map_err(|error| error.to_string())
    }
}

impl Viewer {
    /// Saves all pictures from now on, or no more.
    pub(crate) fn toggle_recording(&mut self) {
        if let Some(Recording { folder, count }) = self.recording.take() {
            return self.messages.note(format!("saved {count} frames in {}", folder.display()));
        }
        match Recording::start() {
            Ok(recording) => {
                self.messages.note(format!(
                    "each frame that is drawn is saved in {}, thirty for a second; F11 ends it",
                    recording.folder.display()
                ));
                self.recording = Some(recording);
            }
            Err(error) => self.messages.error(error),
        }
    }

    /// Saves the picture that was drawn, if all are.
    pub(crate) fn record(&mut self) {
        let Some(mut recording) = self.recording.take() else { return };
        let picture = self.read_picture().map_err(|error| error.to_string());
        match picture.and_then(|picture| recording.save(&picture)) {
            Ok(()) => self.recording = Some(recording),
            Err(error) => self.messages.error(format!("no more frames are saved: {error}")),
        }
    }
}
