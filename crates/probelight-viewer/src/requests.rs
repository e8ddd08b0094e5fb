//! What the window does when it is asked: files, bakes, picks, pictures.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;

use egui_file_dialog::{FileDialog, FileDialogConfig};
use half::f16;
use probelight_asset::write_atomically;
use probelight_bake::{BakeOptions, Quality};
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::gpu::GpuError;
use probelight_runtime::gpu::readback::read_texture_async;
use probelight_scene::{AnimatedModel, ObjectPath, Placement, Setup, parse_animated_gltf};
use probelight_trace::{Ray, Tracer};

use crate::app::{DialogPurpose, PickAnswers, Viewer, all_work, close};
use crate::panels::lightmap::LightmapPage;
use crate::panels::picked::PickedLight;
use crate::scene::baker::RunningBake;
use crate::scene::live_scene::{LiveScene, audible};
use crate::scene::loader::{Loaded, Purpose};
use crate::scene::pending::{Pending, take_ready};
use crate::scene::pick::{Picked, pick, reference_at};
use crate::state::document::standing;
use crate::state::{Action, Document, Edit, Request, Selection, State};

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
            Request::Quit => close(&self.context),
        }
    }

    /// Opens a file. What is open stays until it is there.
    pub(crate) fn open(&mut self, path: PathBuf) {
        // A glTF file that is dropped into a baked scene is a scene, too; objects have a button of their own.
        self.loader.read(path, Purpose::Open, &self.gpu);
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

    /// Takes what was read or baked meanwhile.
    pub(crate) fn take_loaded(&mut self) {
        while let Some(loaded) = self.loader.take() {
            match loaded {
                Loaded::Scene(path, live, warnings) => self.show_scene(path, *live, warnings),
                Loaded::Baked(live) => self.show_bake(*live),
                Loaded::Setup(path, setup) => self.show_setup(&path, &setup),
                Loaded::Model(path, model) => self.take_model(path, model),
                Loaded::Failed(reason) => {
                    self.bake = None;
                    self.messages.error(reason);
                }
                Loaded::Cancelled => {
                    self.bake = None;
                    self.messages.note("the bake was cancelled");
                }
            }
        }
        self.ask_for_models();
    }

    fn show_scene(&mut self, path: PathBuf, live: LiveScene, warnings: Vec<String>) {
        if let Some(bake) = self.bake.take() {
            bake.progress.cancel();
        }
        self.settings.opened(&path);
        warnings.into_iter().for_each(|warning| self.messages.note(warning));
        let setup = Setup::from_scene(live.scene());
        let document = Document::new(&setup, "".as_ref(), live.scene());
        let first = setup.cameras.first().cloned();
        let mut state = State::new(
            document,
            first.unwrap_or(self.state.view.camera.clone()),
            live.scene().bounds().diagonal(),
        );
        // The window stays as it is: panels, pictures, levels.
        let camera = state.view.camera.clone();
        state.view = crate::state::ViewState { camera, time: 0.0, ..self.state.view.clone() };
        state.view.muted = Default::default();
        state.document.scene = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.state = state;
        self.full_plan = all_work(&live);
        let is_baked = live.is_baked;
        self.replace(live);
        (self.scene_file, self.setup_file) = (Some(path), None);
        if let Some(setup) = self.options.setup.take() {
            self.loader.read(setup, Purpose::Open, &self.gpu);
        }
        for object in std::mem::take(&mut self.options.objects) {
            self.act(Action::Edit(Edit::AddObject(object)));
        }
        self.act(Action::Deselect);
        self.look_from_named_camera();
        if !is_baked {
            self.bake(Quality::Preview);
        }
    }

    fn look_from_named_camera(&mut self) {
        let Some(name) = &self.options.camera else { return };
        match self.state.document.cameras.iter().position(|camera| camera.name == *name) {
            Some(camera) => self.act(Action::LookFrom(camera)),
            None if self.options.setup.is_none() && self.loader.pending == 0 => {
                self.messages.error(format!("there is no camera called {name:?}"));
            }
            None => {}
        }
    }

    fn show_bake(&mut self, live: LiveScene) {
        self.bake = None;
        self.messages.note("baked: indirect light is on");
        self.full_plan = all_work(&live);
        let had_light = self.live.as_ref().is_some_and(|live| live.is_baked);
        self.replace(live);
        self.fade = if had_light { 0.0 } else { 1.0 };
    }

    /// Shows another scene, or the same one baked. Models that were read stay.
    fn replace(&mut self, mut live: LiveScene) {
        live.models = self.live.take().map(|live| live.models).unwrap_or_default();
        self.live = Some(live);
        self.picked = None;
        self.pick_answers = PickAnswers::default();
        self.lightmap = None;
        self.forget_drawn();
    }

    fn show_setup(&mut self, path: &Path, setup: &Setup) {
        let Some(live) = &self.live else {
            return self.messages.error("open a scene first, then its setup");
        };
        let folder = path.parent().unwrap_or("".as_ref());
        let document = Document::new(setup, folder, live.scene());
        self.state.replace_document(document);
        self.setup_file = Some(path.into());
        self.state.is_changed = false;
        match &self.options.camera {
            Some(_) => self.look_from_named_camera(),
            None => self.act(Action::Home),
        }
    }

    fn take_model(&mut self, path: PathBuf, model: Arc<AnimatedModel>) {
        let is_new = !self.state.document.objects.iter().any(|entry| entry.path.file == path);
        if let Some(live) = &mut self.live {
            live.models.insert(path.clone(), model);
        }
        if is_new {
            let place = Placement::at(self.state.place_ahead());
            self.act(Action::Edit(Edit::AddObject(standing(path, place))));
        }
        self.forget_drawn();
    }

    /// Reads the models of objects that have none yet.
    fn ask_for_models(&mut self) {
        let Some(live) = &self.live else { return };
        let is_missing =
            |file: &PathBuf| !live.models.contains_key(file) && !self.asked_models.contains(file);
        let missing: Vec<PathBuf> = self
            .state
            .document
            .objects
            .iter()
            .map(|entry| entry.path.file.clone())
            .filter(|file| is_missing(file))
            .collect();
        for file in missing {
            self.asked_models.insert(file.clone());
            match self.options.ball.as_ref().filter(|(ball, _)| *ball == file).map(|(_, glb)| Arc::clone(glb))
            {
                Some(glb) => self.read_ball(file, &glb),
                None => self.loader.read(file, Purpose::Object, &self.gpu),
            }
        }
    }

    fn read_ball(&mut self, file: PathBuf, glb: &[u8]) {
        match parse_animated_gltf(glb, &file) {
            Ok(model) => self.take_model(file, Arc::new(model)),
            Err(error) => self.messages.error(error.to_string()),
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

    fn bake(&mut self, quality: Quality) {
        let Some(live) = self.live.as_ref().filter(|_| self.bake.is_none()) else { return };
        let options = BakeOptions { quality: Some(quality), ..BakeOptions::default() };
        let bake = RunningBake::start(live.scene(), options, &self.gpu, &mut self.loader, &self.context);
        self.bake = Some(bake);
    }

    fn save_setup(&mut self, path: &Path) {
        let Some(live) = &self.live else { return };
        let folder = path.parent().unwrap_or("".as_ref());
        let text = self.state.document.setup(folder, live.scene()).to_json();
        let ball = self
            .options
            .ball
            .as_ref()
            .filter(|(file, _)| self.state.document.objects.iter().any(|entry| entry.path.file == *file));
        let written =
            write_atomically(path, |out| out.write_all(text.as_bytes())).and_then(|()| match ball {
                Some((file, glb)) => write_atomically(&folder.join(file), |out| out.write_all(glb)),
                None => Ok(()),
            });
        match written {
            Ok(()) => {
                self.state.is_changed = false;
                self.setup_file = Some(path.into());
                self.messages.note(format!("saved {}", path.display()));
            }
            Err(error) => self.messages.error(format!("{} cannot be written: {error}", path.display())),
        }
    }

    fn save_bake(&mut self, path: &Path) {
        let Some(live) = self.live.as_ref().filter(|live| live.is_baked) else {
            return self.messages.error("there is no bake to save yet");
        };
        match live.baked.write(path) {
            Ok(()) => self.messages.note(format!("saved {}", path.display())),
            Err(error) => self.messages.error(error.to_string()),
        }
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

    fn picked_place(&self) -> Option<Vec3> {
        match &self.picked.as_ref()?.picked {
            Picked::Nothing => None,
            Picked::Object(_, place) => Some(*place),
            Picked::Surface(surface) => Some(surface.position),
        }
    }

    /// Finds out what is at a pixel, and asks for its light.
    fn pick(&mut self, pixel: Vec2) {
        let Some(live) = &self.live else { return };
        let picked = pick(live, &self.state.view.camera, pixel);
        let view = &self.state.view;
        let lighting = audible(&self.state.document, &view.muted, view.time);
        let mut direct = Vec::new();
        self.pick_answers = PickAnswers::default();
        if let Picked::Surface(surface) = &picked {
            let place = (surface.position, surface.normal);
            direct = lighting.lights.iter().map(|light| direct_at(&live.tracer, light, place)).collect();
            let (sender, receiver) = channel();
            let (tracer, colors) = (Arc::clone(&live.tracer), self.state.document.materials.clone());
            let context = self.context.clone();
            std::thread::spawn(move || {
                // Nobody listens if another place was picked.
                let _ = sender.send(reference_at(&tracer, &colors, lighting, place));
                context.request_repaint();
            });
            self.pick_answers.reference = Some(receiver);
            if surface.light.is_some() {
                let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
                let texture = live.runtime.buffers().lightmap.clone();
                self.pick_answers.texel =
                    Some(Pending::new(async move { read_texture_async(&device, &queue, &texture).await }));
            }
        }
        if let Picked::Object(item, _) = picked {
            self.state.act(Action::Select(Selection::Object(item)));
        }
        let is_tracing = self.pick_answers.reference.is_some();
        self.picked = Some(PickedLight { picked, direct, lightmap: None, reference: None, is_tracing });
        self.show_picked();
    }

    /// Takes what the GPU and the path tracer have said meanwhile.
    pub(crate) fn take_answers(&mut self) {
        if let Some(Ok(bytes)) = take_ready(&mut self.lightmap_answer)
            && let Some(live) = &self.live
        {
            let irradiance = bytes.chunks_exact(8).map(texel).collect();
            let width = live.baked.lightmap.width as usize;
            self.lightmap = Some(LightmapPage::new(&self.context, width, irradiance, self.state.shown_ev));
        }
        let Some(light) = &mut self.picked else { return };
        if let Some(answer) = take_ready(&mut self.pick_answers.texel) {
            light.lightmap = lightmap_at(light, self.live.as_ref(), answer);
        }
        if let Some(Ok(reference)) = self.pick_answers.reference.as_ref().map(|receiver| receiver.try_recv())
        {
            light.reference = reference;
            light.is_tracing = false;
            self.pick_answers.reference = None;
        }
    }
}

/// Irradiance of one light at a place, with shadows, W/m².
fn direct_at(tracer: &Tracer, light: &probelight_scene::Light, (position, normal): (Vec3, Vec3)) -> Vec3 {
    let Some(arriving) = light.illuminate(position) else { return Vec3::ZERO };
    let cosine = normal.dot(arriving.to_light);
    let origin = tracer.off_surface(position, normal);
    let mut ray = Ray::new(origin, arriving.to_light);
    ray.max_distance = arriving.distance;
    if cosine <= 0.0 || tracer.is_occluded(&ray) { Vec3::ZERO } else { arriving.irradiance * cosine }
}

/// Irradiance of the lightmap at the picked texel.
fn lightmap_at(
    light: &PickedLight,
    live: Option<&LiveScene>,
    answer: Result<Vec<u8>, GpuError>,
) -> Option<Vec3> {
    let Picked::Surface(surface) = &light.picked else { return None };
    let [x, y] = surface.light.as_ref()?.texel;
    let index = y as usize * live?.baked.lightmap.width as usize + x as usize;
    answer.ok()?.chunks_exact(8).nth(index).map(texel)
}

/// Red, green and blue of a texel of half floats.
fn texel(bytes: &[u8]) -> Vec3 {
    Vec3::from([0, 1, 2].map(|c| f16::from_le_bytes([bytes[2 * c], bytes[2 * c + 1]]).to_f32()))
}
