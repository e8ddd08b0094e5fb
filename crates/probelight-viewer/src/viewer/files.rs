//! What is opened and saved.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use probelight_scene::{AnimatedModel, Placement, Setup, parse_animated_gltf};

use super::{PickAnswers, Viewer};
use crate::picture::meter::Meter;
use crate::platform::{self, File};
use crate::scene::frame_work::FrameWork;
use crate::scene::live_scene::LiveScene;
use crate::scene::loader::{Loaded, Purpose};
use crate::state::document::standing;
use crate::state::{Action, Document, Edit, State};

impl Viewer {
    /// Opens a file. What is open stays until it is there.
    pub fn open(&mut self, file: File) {
        // A glTF file that is dropped into a baked scene is a scene, too; objects have a button of their own.
        self.loader.read(file, Purpose::Open, &self.gpu);
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
            bake.cancel();
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
        let is_baked = live.is_baked;
        self.replace(live);
        self.meter = Meter::new();
        (self.scene_file, self.setup_file) = (Some(path), None);
        if let Some(setup) = self.options.setup.take() {
            self.loader.read(setup.into(), Purpose::Open, &self.gpu);
        }
        for object in std::mem::take(&mut self.options.objects) {
            self.act(Action::Edit(Edit::AddObject(object)));
        }
        self.act(Action::Deselect);
        self.look_from_named_camera();
        self.bake_once_shown = platform::FIRST_QUALITY.filter(|_| !is_baked);
    }

    /// Begins to bake what was opened without a bake. A bake takes all cores, so the first picture comes before it.
    pub(super) fn bake_what_is_shown(&mut self) {
        if self.drawn.is_some()
            && !self.meter.is_measuring()
            && let Some(quality) = self.bake_once_shown.take()
        {
            self.bake(quality);
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
        let had_light = self.live.as_ref().is_some_and(|live| live.is_baked);
        self.replace(live);
        self.fade = if had_light { 0.0 } else { 1.0 };
    }

    /// Shows another scene, or the same one baked. Models that were read stay.
    fn replace(&mut self, mut live: LiveScene) {
        live.models = self.live.take().map(|live| live.models).unwrap_or_default();
        self.work = FrameWork::new(&live);
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
        // Another light: its first picture, too, has the right exposure.
        self.meter = Meter::new();
        self.forget_drawn();
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
                None => self.loader.read(file.into(), Purpose::Object, &self.gpu),
            }
        }
    }

    fn read_ball(&mut self, file: PathBuf, glb: &[u8]) {
        match parse_animated_gltf(glb, &file) {
            Ok(model) => self.take_model(file, Arc::new(model)),
            Err(error) => self.messages.error(error.to_string()),
        }
    }

    pub(crate) fn save_setup(&mut self, path: &Path) {
        let Some(live) = &self.live else { return };
        let folder = path.parent().unwrap_or("".as_ref());
        let text = self.state.document.setup(folder, live.scene()).to_json();
        let ball = self
            .options
            .ball
            .as_ref()
            .filter(|(file, _)| self.state.document.objects.iter().any(|entry| entry.path.file == *file));
        let written = platform::save(path, text.as_bytes()).and_then(|()| match ball {
            Some((file, glb)) => platform::save(&folder.join(file), glb),
            None => Ok(()),
        });
        match written {
            Ok(()) => {
                self.state.is_changed = false;
                self.setup_file = Some(path.into());
                self.messages.note(format!("saved {}", path.display()));
            }
            Err(error) => self.messages.error(error),
        }
    }
}
