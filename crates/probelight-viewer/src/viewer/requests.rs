//! What the window does when it is asked.

use eframe::egui::ViewportCommand;
use probelight_scene::{ObjectPath, Placement};

use super::{DialogPurpose, Viewer};
use crate::state::document::standing;
use crate::state::{Action, Edit, Request};

/// A new ball has this share of the scene's diagonal as its radius, but is no larger than one of some metres.
const BALL_SIZE: f32 = 0.02;

impl Viewer {
    /// Does what is asked for.
    pub(crate) fn answer(&mut self, request: Request) {
        match request {
            Request::ChooseFile => self.choose(DialogPurpose::Open),
            Request::ChooseObject => self.choose(DialogPurpose::Object),
            Request::Open(path) => self.open(path.into()),
            Request::AddBall => self.add_ball(),
            Request::Save => match self.setup_file.clone() {
                Some(path) => self.save_setup(&path),
                None => self.choose(DialogPurpose::SaveSetup),
            },
            Request::SaveAs => self.choose(DialogPurpose::SaveSetup),
            Request::SaveTo(path) => self.save_setup(&path),
            Request::SaveBake => self.choose(DialogPurpose::SaveBake),
            Request::Bake(quality) => self.bake(quality),
            Request::CancelBake => {
                if let Some(bake) = &self.bake {
                    bake.cancel();
                }
            }
            Request::Pick(pixel) => self.pick(pixel.into()),
            Request::FocusOn(pixel) => {
                self.pick(pixel.into());
                if let Some(place) = self.picked_place() {
                    self.act(Action::Focus(place));
                }
            }
            Request::Screenshot => self.screenshot(),
            Request::ToggleRecording => self.toggle_recording(),
            Request::CopyText(text) => {
                self.context.copy_text(text);
                self.messages.note("copied");
            }
            Request::Quit => self.context.send_viewport_cmd(ViewportCommand::Close),
        }
    }

    /// A name for what belongs to the scene.
    pub(crate) fn name_with(&self, extension: &str) -> String {
        let stem = self.scene_file.as_ref().and_then(|file| file.file_stem());
        format!("{}.{extension}", stem.unwrap_or("scene".as_ref()).to_string_lossy())
    }

    fn add_ball(&mut self) {
        let Some((file, _)) = &self.options.ball else {
            return self.messages.error("there is no ball: add an object from a file");
        };
        let place = Placement::upright(self.state.place_ahead(), 0.0, self.ball_scale());
        let path: ObjectPath = standing(file.clone(), place);
        self.act(Action::Edit(Edit::AddObject(path)));
    }

    /// Size of a new ball: its model has a radius of about a third of a metre.
    fn ball_scale(&self) -> f32 {
        let wanted = BALL_SIZE * self.state.diagonal;
        wanted / 0.3
    }
}
