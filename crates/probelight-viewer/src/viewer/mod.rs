//! [`Viewer`]: the window's content. Takes what happens, asks the state what follows, has it lit, drawn and shown.
//!
//! | module | job |
//! | --- | --- |
//! | `layout` | panels, windows and the picture |
//! | `frame` | lights and draws the scene if anything changed; whether there is another frame |
//! | `requests` | what the window does when it is asked |
//! | `files` | what is opened and saved |
//! | `picking` | what is at a place |
//! | `similarity` | levels of detail that hold the similarity of pictures |

mod files;
mod frame;
mod layout;
mod picking;
mod requests;
mod similarity;

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;
#[cfg(not(target_arch = "wasm32"))]
use std::sync::OnceLock;

use eframe::egui::{self, CentralPanel, Rect, Ui};
use eframe::egui_wgpu::RenderState;
use probelight_math::glam::Vec3;
use probelight_render::DisplayImage;
use probelight_runtime::LodGovernor;
use probelight_runtime::gpu::{GpuDevice, GpuError};
use probelight_scene::{Camera, ObjectPath, Setup};
use web_time::Instant;

use self::frame::Drawn;
use self::similarity::HeldSimilarity;
use crate::handles;
use crate::messages::Messages;
use crate::mouse::{self, Grip};
use crate::overlays::GridOfLight;
use crate::panels;
use crate::panels::lightmap::LightmapPage;
use crate::panels::picked::PickedLight;
use crate::picture::meter::Meter;
use crate::picture::screen::Screen;
use crate::platform::{self, Dialogs, File};
use crate::scene::frame_times::FrameTimes;
use crate::scene::frame_work::FrameWork;
use crate::scene::live_scene::LiveScene;
use crate::scene::loader::Loader;
use crate::scene::pending::Pending;
use crate::scene::progress::BackgroundProgress;
use crate::scene::reference_picture::ReferencePicture;
use crate::settings::Settings;
use crate::state::view_state::ExposureMode;
use crate::state::{Action, Document, State};

/// What the window begins with.
#[derive(Clone, Debug, Default)]
pub struct ViewerOptions {
    /// A scene or baked file.
    pub file: Option<PathBuf>,
    /// Lights, cameras, objects.
    pub setup: Option<PathBuf>,
    /// Name of the camera to begin at.
    pub camera: Option<String>,
    /// Exposure to begin with, as a power of two.
    pub exposure: Option<f32>,
    /// Share of the window's pixels, along each side, that are drawn; half of them on a driver in software if this is absent.
    pub resolution: Option<f32>,
    /// When the program began, to tell how long the first picture took.
    pub started: Option<Instant>,
    /// Whether frames wait for the display; `None`: as the window was left.
    pub vsync: Option<bool>,
    /// Objects besides those of the setup.
    pub objects: Vec<ObjectPath>,
    /// What "+ ball" adds: the name of its file, and its bytes.
    pub ball: Option<(PathBuf, Arc<[u8]>)>,
}

/// The window's content.
pub struct Viewer {
    pub(crate) context: egui::Context,
    pub(crate) window: RenderState,
    pub(crate) gpu: GpuDevice,
    pub(crate) options: ViewerOptions,
    /// What one sees.
    pub state: State,
    /// The scene, once one is open.
    pub live: Option<LiveScene>,
    /// What the window tells.
    pub messages: Messages,
    pub(crate) loader: Loader,
    pub(crate) bake: Option<Arc<BackgroundProgress>>,
    /// How the scene is baked as soon as its first picture is there.
    bake_once_shown: Option<platform::Quality>,
    pub(crate) scene_file: Option<PathBuf>,
    pub(crate) setup_file: Option<PathBuf>,
    pub(crate) asked_models: HashSet<PathBuf>,
    pub(crate) settings: Settings,
    pub(crate) dialogs: Dialogs,
    pub(crate) picked: Option<PickedLight>,
    pub(crate) pick_answers: PickAnswers,
    pub(crate) lightmap: Option<LightmapPage>,
    pub(crate) lightmap_answer: Option<Pending<Result<Vec<u8>, GpuError>>>,
    /// How many pictures were drawn when it was read.
    lightmap_draws: u64,
    pub(crate) screen: Screen,
    pub(crate) settling: u32,
    pub(crate) fade: f32,
    pub(crate) work: FrameWork,
    meter: Meter,
    reference: Option<ReferencePicture>,
    times: FrameTimes,
    pub(crate) recording: Option<platform::Recording>,
    governor: Option<(f32, LodGovernor)>,
    held: HeldSimilarity,
    grid: Option<GridOfLight>,
    grid_answer: Option<Pending<Result<Vec<f32>, GpuError>>>,
    grip: Grip,
    drawn: Option<Drawn>,
    tab: Tab,
    zoom: f32,
    memory: (Instant, u64),
    /// Where changes were saved when the window ended by accident.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) rescued: Arc<OnceLock<PathBuf>>,
    rect: Rect,
    draws: u64,
}

/// What a chosen file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DialogPurpose {
    Open,
    Object,
    SaveSetup,
    SaveBake,
}

/// What is still to be said about the picked place.
#[derive(Default)]
pub(crate) struct PickAnswers {
    pub(crate) texel: Option<Pending<Result<Vec<u8>, GpuError>>>,
    pub(crate) reference: Option<std::sync::mpsc::Receiver<Option<probelight_trace::PointIrradiance>>>,
}

/// What the panel on the right is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    #[default]
    Look,
    Detail,
    Bake,
    Picked,
}

impl Viewer {
    /// Opens what the options name. `gpu` is the window's.
    ///
    /// # Errors
    /// If the GPU cannot hold the smallest picture.
    pub fn new(
        context: &egui::Context,
        storage: Option<&dyn eframe::Storage>,
        window: &RenderState,
        gpu: &GpuDevice,
        options: ViewerOptions,
    ) -> Result<Self, GpuError> {
        let scene = probelight_scene::Scene::default();
        let document = Document::new(&probelight_scene::Setup::default(), "".as_ref(), &scene);
        let settings = Settings::load(storage);
        let mut state = State::new(document, first_camera(), 1.0);
        state.view.caps_frames = !settings.runs_free;
        state.view.vsync = options.vsync.unwrap_or(!settings.tears);
        // A driver in software needs a second for a large picture, and would never rest.
        state.view.resolution = options.resolution.unwrap_or(if gpu.is_software() { 0.5 } else { 1.0 });
        state.view.is_playing = !gpu.is_software();
        if let Some(ev) = options.exposure {
            state.view.exposure = ExposureMode::Fixed(ev);
        }
        let mut viewer = Self {
            context: context.clone(),
            window: window.clone(),
            gpu: gpu.clone(),
            state,
            live: None,
            messages: Messages::default(),
            loader: Loader::new(context),
            bake: None,
            bake_once_shown: None,
            scene_file: None,
            setup_file: None,
            asked_models: HashSet::new(),
            settings,
            dialogs: Dialogs::new(),
            picked: None,
            pick_answers: PickAnswers::default(),
            lightmap: None,
            lightmap_answer: None,
            lightmap_draws: 0,
            screen: Screen::new(gpu)?,
            settling: 0,
            fade: 0.0,
            work: FrameWork::default(),
            meter: Meter::new(),
            reference: None,
            times: FrameTimes::new(gpu, options.started),
            recording: None,
            governor: None,
            held: HeldSimilarity::default(),
            grid: None,
            grid_answer: None,
            grip: Grip::Nothing,
            drawn: None,
            tab: Tab::default(),
            zoom: 1.0,
            memory: (Instant::now(), 0),
            #[cfg(not(target_arch = "wasm32"))]
            rescued: Arc::default(),
            rect: Rect::ZERO,
            draws: 0,
            options,
        };
        if let Some(file) = viewer.options.file.clone() {
            viewer.open(file.into());
        }
        Ok(viewer)
    }

    /// Does what is asked for.
    pub fn act(&mut self, action: Action) {
        if let Some(request) = self.state.act(action) {
            self.answer(request);
        }
    }

    /// Where the picture is in the window, points.
    pub fn picture_rect(&self) -> Rect {
        self.rect
    }

    /// The picture as it is shown. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_picture(&self) -> Result<DisplayImage, GpuError> {
        self.screen.read()
    }

    /// The picture as it is shown, once the GPU has drawn it.
    pub fn read_picture_async(&self) -> impl Future<Output = Result<DisplayImage, GpuError>> + use<> {
        self.screen.read_async()
    }

    /// The setup as it would be saved; `None` as long as no scene is open.
    pub fn setup(&self) -> Option<Setup> {
        Some(self.state.document.setup("".as_ref(), self.live.as_ref()?.scene()))
    }

    /// Where lights are in the window, points: those that are somewhere before the camera.
    pub fn places_of_lights(&self) -> impl Iterator<Item = egui::Pos2> {
        let frame = handles::Frame { rect: self.rect, camera: &self.state.view.camera };
        let lights = self.state.document.lights.iter();
        let places =
            lights.filter_map(|entry| entry.motion.at(&entry.light, self.state.view.time).position());
        places.filter_map(move |place| frame.project(place)).map(|(at, _)| at)
    }

    /// Where objects are in the window, points: those before the camera.
    pub fn places_of_objects(&self) -> impl Iterator<Item = egui::Pos2> {
        let frame = handles::Frame { rect: self.rect, camera: &self.state.view.camera };
        let objects = self.state.document.objects.iter();
        let places = objects.map(|entry| entry.placement(self.state.view.time).translation);
        places.filter_map(move |place| frame.project(place)).map(|(at, _)| at)
    }

    /// How long frames take, as the panel of times copies it.
    pub fn figures(&self) -> serde_json::Value {
        panels::timing::figures(&self.times, &self.work, self.memory.1)
    }

    /// The colours of the lightmap's page, if it is open and was read.
    pub fn lightmap_colors(&self) -> Option<&[egui::Color32]> {
        Some(self.lightmap.as_ref()?.colors())
    }

    /// Factor on the distances of levels that holds the wanted similarity, once it was found.
    pub fn held_scale(&self) -> Option<f32> {
        self.held.scale
    }

    /// How many pictures were drawn so far.
    pub fn draws(&self) -> u64 {
        self.draws
    }

    /// Whether files are being read.
    pub fn is_reading(&self) -> bool {
        self.loader.pending > 0
    }

    /// Irradiance at the picked place without that of the lights, by the lightmap and by the path tracer, W/m² summed over
    /// the channels; once both are known.
    pub fn picked_reference(&self) -> Option<(f32, f32)> {
        let picked = self.picked.as_ref()?;
        let reference = picked.reference.as_ref()?;
        let soft = reference.area + reference.sky + reference.indirect;
        Some((picked.lightmap?.element_sum(), soft.element_sum()))
    }

    /// Whether files are read, a scene is baked, light still settles, or answers are waited for.
    pub fn is_busy(&self) -> bool {
        let is_baking = self.bake.is_some() || self.bake_once_shown.is_some();
        let is_waiting = self.loader.pending > 0 || self.lightmap_answer.is_some() || self.work.is_asking();
        is_waiting || is_baking || self.settling > 0 || self.fade > 0.0 || self.held.is_searching()
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let start = Instant::now();
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        // Nothing waits here: answers that are there are handed out.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        if self.gpu.check().is_err() {
            return self.end_without_gpu();
        }
        self.take_loaded();
        self.take_answers();
        let mut actions = mouse::pressed(&self.context);
        actions.extend(mouse::held(&self.context, &self.state, seconds));
        let dropped: Vec<File> =
            ui.input(|input| input.raw.dropped_files.iter().filter_map(File::dropped).collect());
        dropped.into_iter().for_each(|file| self.open(file));
        if self.drawn.is_some() {
            self.times.note_picture();
        }
        self.panels(ui, &mut actions);
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, &mut actions));
        self.windows(&mut actions);
        let is_free = ui.input(|input| !input.pointer.any_down() && !mouse::is_moving(input));
        actions.into_iter().for_each(|action| self.act(action));
        if is_free {
            self.act(Action::EndStep);
        }
        self.grow_reference();
        self.read_grid();
        self.read_lightmap();
        self.meter.update();
        self.work.update();
        if let Err(error) = self.light_and_draw(seconds).and_then(|()| self.hold_similarity()) {
            self.messages.error(error.to_string());
        }
        self.bake_what_is_shown();
        self.note_memory();
        self.wait_for_display(frame);
        if let Some(light) = self.times.note(start.elapsed())
            && let Some((_, governor)) = &mut self.governor
        {
            governor.note(light);
        }
        self.next_frame(start);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings.runs_free = !self.state.view.caps_frames;
        self.settings.tears = !self.state.view.vsync;
        self.settings.save(storage);
    }
}

/// Where one looks from as long as there is nothing.
fn first_camera() -> Camera {
    Camera {
        name: "first".into(),
        position: Vec3::Z,
        target: Vec3::ZERO,
        up: Vec3::Y,
        vertical_fov: 0.8,
        width: 1,
        height: 1,
    }
}
