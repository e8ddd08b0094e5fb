//! What the window does when it is asked.

use std::path::PathBuf;

use eframe::egui::ViewportCommand;
use egui_file_dialog::{FileDialog, FileDialogConfig};
use probelight_bake::{BakeOptions, Quality};
use probelight_runtime::gpu::readback::read_texture_async;
use probelight_scene::{ObjectPath, Placement};

use super::{DialogPurpose, Viewer};
use crate::scene::baker::RunningBake;
use crate::scene::loader::Purpose;
use crate::scene::pending::Pending;
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
            Request::Open(path) => self.open(path),
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
                    bake.progress.cancel();
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
            Request::CopyText(text) => {
                self.context.copy_text(text);
                self.messages.note("copied");
            }
            Request::ReadLightmap => self.read_lightmap(),
            Request::Quit => self.context.send_viewport_cmd(ViewportCommand::Close),
        }
    }

    fn choose(&mut self, purpose: DialogPurpose) {
        let folder = self.setup_file.as_ref().or(self.scene_file.as_ref()).and_then(|file| file.parent());
        let config = FileDialogConfig::default();
        let mut dialog = FileDialog::with_config(config);
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
        self.dialog = dialog;
        self.dialog_purpose = Some(purpose);
    }

    fn name_with(&self, extension: &str) -> String {
        let stem = self.scene_file.as_ref().and_then(|file| file.file_stem());
        format!("{}.{extension}", stem.unwrap_or("scene".as_ref()).to_string_lossy())
    }

    /// A file was chosen.
    pub(crate) fn chosen(&mut self, path: PathBuf) {
        match self.dialog_purpose.take() {
            Some(DialogPurpose::Open) => self.open(path),
            Some(DialogPurpose::Object) => self.loader.read(path, Purpose::Object, &self.gpu),
            Some(DialogPurpose::SaveSetup) => self.save_setup(&path),
            Some(DialogPurpose::SaveBake) => self.save_bake(&path),
            None => {}
        }
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

    pub(super) fn bake(&mut self, quality: Quality) {
        let Some(live) = self.live.as_ref().filter(|_| self.bake.is_none()) else { return };
        let options = BakeOptions { quality: Some(quality), ..BakeOptions::default() };
        let bake = RunningBake::start(live.scene(), options, &self.gpu, &mut self.loader, &self.context);
        self.bake = Some(bake);
    }

    fn screenshot(&mut self) {
        let names = (1..).map(|number| PathBuf::from(format!("probelight-{number:03}.png")));
        let Some(path) = names.into_iter().find(|path| !path.exists()) else { return };
        let written = self.screen.read().map_err(|error| error.to_string());
        match written.and_then(|image| image.write_png(&path).map_err(|error| error.to_string())) {
            Ok(()) => self.messages.note(format!("saved {}", path.display())),
            Err(error) => self.messages.error(error),
        }
    }

    fn read_lightmap(&mut self) {
        let Some(live) = self.live.as_ref().filter(|_| self.lightmap_answer.is_none()) else { return };
        let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
        let texture = live.runtime.buffers().lightmap.clone();
        let read = async move { read_texture_async(&device, &queue, &texture).await };
        self.lightmap_answer = Some(Pending::new(read));
    }
}
