//! The window's content: takes what happens, asks the state what follows, has it lit, drawn and shown.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Align2, CentralPanel, Color32, Panel, Pos2, Rect, Sense, Ui, ViewportCommand};
use eframe::egui_wgpu::RenderState;
use egui_file_dialog::FileDialog;
use probelight_math::glam::Vec3;
use probelight_render::DisplayImage;
use probelight_runtime::gpu::{GpuDevice, GpuError};
use probelight_runtime::{FramePlan, LodGovernor};
use probelight_scene::{Camera, ObjectPath};

use crate::handles::{self, Frame};
use crate::messages::Messages;
use crate::mouse::{self, Grip};
use crate::overlays::{self, GridOfLight};
use crate::panels::detail::Work;
use crate::panels::lightmap::LightmapPage;
use crate::panels::picked::PickedLight;
use crate::panels::{self, Actions};
use crate::picture::meter::Meter;
use crate::picture::screen::Screen;
use crate::picture::texel_colors;
use crate::scene::baker::RunningBake;
use crate::scene::frame_times::FrameTimes;
use crate::scene::live_scene::{LiveScene, audible};
use crate::scene::loader::Loader;
use crate::scene::pending::Pending;
use crate::scene::pick::Picked;
use crate::scene::reference_picture::{ReferencePicture, Subject};
use crate::settings::Settings;
use crate::state::view_state::{Compare, ExposureMode, ViewState};
use crate::state::{Action, Document, Request, State};

/// Frames in which light settles after a change: bounces, until nothing changes that one sees.
const SETTLING_FRAMES: u32 = 96;

/// How long indirect light takes to appear after a bake, seconds.
const FADE_SECONDS: f32 = 1.5;

/// Share of the way to the metered exposure that is gone in a second: the rest of it.
const ADAPTATION: f32 = 0.03;

/// Exposures nearer than this look the same.
const SAME_EXPOSURE: f32 = 0.01;

/// Time of a frame at sixty a second.
const CAPPED_FRAME: Duration = Duration::from_micros(16_667);

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
    /// Objects besides those of the setup.
    pub objects: Vec<ObjectPath>,
    /// What "+ ball" adds: the name of its file, and its bytes.
    pub ball: Option<(PathBuf, Arc<[u8]>)>,
}

/// What was lit and drawn last: what equals it is not done again.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    document: Document,
    view: ViewState,
    ev: f32,
    fade: f32,
    passes: u32,
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
    pub(crate) bake: Option<RunningBake>,
    pub(crate) scene_file: Option<PathBuf>,
    pub(crate) setup_file: Option<PathBuf>,
    pub(crate) asked_models: HashSet<PathBuf>,
    pub(crate) settings: Settings,
    pub(crate) dialog: FileDialog,
    pub(crate) dialog_purpose: Option<DialogPurpose>,
    pub(crate) picked: Option<PickedLight>,
    pub(crate) pick_answers: PickAnswers,
    pub(crate) lightmap: Option<LightmapPage>,
    pub(crate) lightmap_answer: Option<Pending<Result<Vec<u8>, GpuError>>>,
    pub(crate) screen: Screen,
    pub(crate) settling: u32,
    pub(crate) fade: f32,
    pub(crate) full_plan: Work,
    meter: Meter,
    reference: Option<ReferencePicture>,
    times: FrameTimes,
    governor: Option<(f32, LodGovernor)>,
    grid: Option<GridOfLight>,
    grid_answer: Option<Pending<Result<Vec<f32>, GpuError>>>,
    grip: Grip,
    drawn: Option<Drawn>,
    tab: Tab,
    zoom: f32,
    memory: (Instant, u64),
    is_lost: bool,
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
        // A driver in software needs a second for a large picture.
        state.view.resolution = if gpu.is_software() { 0.5 } else { 1.0 };
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
            scene_file: None,
            setup_file: None,
            asked_models: HashSet::new(),
            settings,
            dialog: FileDialog::new(),
            dialog_purpose: None,
            picked: None,
            pick_answers: PickAnswers::default(),
            lightmap: None,
            lightmap_answer: None,
            screen: Screen::new(gpu)?,
            settling: 0,
            fade: 0.0,
            full_plan: Work::default(),
            meter: Meter::new(),
            reference: None,
            times: FrameTimes::new(gpu),
            governor: None,
            grid: None,
            grid_answer: None,
            grip: Grip::Nothing,
            drawn: None,
            tab: Tab::default(),
            zoom: 1.0,
            memory: (Instant::now(), 0),
            is_lost: false,
            rect: Rect::ZERO,
            draws: 0,
            options,
        };
        if let Some(file) = viewer.options.file.clone() {
            viewer.open(file);
        }
        Ok(viewer)
    }

    /// Does what is asked for.
    pub fn act(&mut self, action: Action) {
        if let Some(request) = self.state.act(action) {
            self.answer(request);
        }
    }

    /// The next frame lights and draws everything anew.
    pub(crate) fn forget_drawn(&mut self) {
        self.drawn = None;
    }

    /// The panel that says what is at the picked place.
    pub(crate) fn show_picked(&mut self) {
        self.tab = Tab::Picked;
    }

    /// Where the picture is in the window, points.
    pub fn picture_rect(&self) -> Rect {
        self.rect
    }

    /// The picture as it is shown. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn read_picture(&self) -> Result<DisplayImage, GpuError> {
        self.screen.read()
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

    /// Whether files are read, a scene is baked, or light still settles.
    pub fn is_busy(&self) -> bool {
        self.loader.pending > 0 || self.bake.is_some() || self.settling > 0 || self.fade > 0.0
    }

    fn panels(&mut self, ui: &mut Ui, actions: &mut Actions) {
        let work = self.work();
        let panels = self.state.view.panels;
        let Self { state, live, times, picked, bake, meter, .. } = self;
        let status = panels::menu::Status {
            title: &title(&self.scene_file),
            recent: &self.settings.recent,
            work: match bake {
                Some(bake) => Some(bake.progress.standing().to_string()),
                None => (self.loader.pending > 0).then(|| "reading…".into()),
            },
        };
        Panel::top("menu").show(ui, |ui| panels::menu::show(ui, state, &status, actions));
        if panels.timing {
            let memory = self.memory.1;
            Panel::bottom("times").exact_size(170.0).show(ui, |ui| {
                panels::timing::show(ui, state, times, work, memory, actions);
            });
        }
        let Some(live) = live else { return };
        if panels.scene {
            let panel = Panel::left("scene").resizable(true).default_size(270.0).min_size(220.0);
            panel.show(ui, |ui| panels::scene::show(ui, state, live.scene(), &live.models, actions));
        }
        if panels.settings {
            let panel = Panel::right("settings").resizable(true).default_size(290.0).min_size(260.0);
            let scale = self.governor.as_ref().map(|(_, governor)| governor.scale());
            let passes = self.reference.as_ref().map(ReferencePicture::passes);
            let standing = bake.as_ref().map(|bake| bake.progress.standing());
            panel.show(ui, |ui| {
                ui.horizontal(|ui| {
                    for (tab, name) in [
                        (Tab::Look, "View"),
                        (Tab::Detail, "Detail"),
                        (Tab::Bake, "Bake"),
                        (Tab::Picked, "Picked"),
                    ] {
                        ui.selectable_value(&mut self.tab, tab, name);
                    }
                });
                ui.separator();
                match self.tab {
                    Tab::Look => panels::look::show(ui, state, meter.reading.as_ref(), passes, actions),
                    Tab::Detail => panels::detail::show(ui, state, work, scale, actions),
                    Tab::Bake => {
                        panels::bake::show(ui, &live.baked, live.is_baked, standing.as_ref(), actions);
                    }
                    Tab::Picked => panels::picked::show(ui, state, picked.as_ref(), actions),
                }
            });
        }
    }

    fn windows(&mut self, actions: &mut Actions) {
        let mut panels = self.state.view.panels;
        let before = panels;
        let context = self.context.clone();
        egui::Window::new("Keys")
            .open(&mut panels.help)
            .default_height(500.0)
            .show(&context, panels::help::show);
        egui::Window::new("Lightmap")
            .open(&mut panels.lightmap)
            .default_size([520.0, 480.0])
            .show(&context, |ui| panels::lightmap::show(ui, self.lightmap.as_ref(), &mut self.zoom, actions));
        if panels != before {
            let mut view = self.state.view.clone();
            view.panels = panels;
            actions.push(Action::View(Box::new(view)));
        }
        self.messages.show(&context);
        self.dialog.update(&context);
        if let Some(path) = self.dialog.take_picked() {
            self.chosen(path);
        }
    }

    /// The picture, and what the mouse does in it.
    fn picture(&mut self, ui: &mut Ui, actions: &mut Actions) {
        let rect = ui.available_rect_before_wrap();
        self.rect = rect;
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        let scale = scale * self.state.view.resolution;
        let [width, height] =
            [rect.width(), rect.height()].map(|side| (side * scale).round().max(1.0) as u32);
        let was_resized = match self.screen.resize(width, height) {
            Ok(was_resized) => was_resized,
            Err(error) => {
                self.messages.error(error.to_string());
                false
            }
        };
        let camera = &mut self.state.view.camera;
        (camera.width, camera.height) = self.screen.size();
        let painter = ui.painter_at(rect);
        let texture = self.screen.texture(&self.window, was_resized);
        if self.live.is_none() {
            let text = if self.loader.pending > 0 {
                "reading…"
            } else {
                "drop a .glb or .plight here, or File › Open"
            };
            overlays::caption(&painter, rect.center(), Align2::CENTER_CENTER, text);
            return;
        }
        painter.image(texture, rect, Rect::from_min_max(Pos2::ZERO, egui::pos2(1.0, 1.0)), Color32::WHITE);
        let is_divided = self.is_divided();
        self.paint_overlays(&painter, rect, is_divided);
        let camera = self.state.view.camera.clone();
        let frame = Frame { rect, camera: &camera };
        actions.extend(mouse::mouse(
            &mut self.grip,
            &response,
            &frame,
            &self.state,
            self.live.as_ref(),
            is_divided,
        ));
    }

    fn is_divided(&self) -> bool {
        let is_there = match self.state.view.compare {
            Compare::Nothing => false,
            Compare::WithoutIndirect => true,
            Compare::Reference => self.reference.as_ref().is_some_and(|reference| reference.passes() > 0),
        };
        is_there && self.state.view.coloring != probelight_render::gpu::Coloring::Difference
    }

    fn paint_overlays(&self, painter: &egui::Painter, rect: Rect, is_divided: bool) {
        let view = &self.state.view;
        let frame = Frame { rect, camera: &view.camera };
        if view.overlays.lights {
            handles::paint(painter, &frame, &self.state.document, view, self.state.selection);
        }
        if is_divided {
            let x = rect.min.x + view.divider * rect.width();
            painter.vline(x, rect.y_range(), egui::Stroke::new(2.0, Color32::WHITE));
            let left =
                if view.compare == Compare::Reference { "path traced" } else { "without indirect light" };
            overlays::caption(painter, egui::pos2(x - 8.0, rect.min.y + 12.0), Align2::RIGHT_TOP, left);
            overlays::caption(
                painter,
                egui::pos2(x + 8.0, rect.min.y + 12.0),
                Align2::LEFT_TOP,
                "Probelight",
            );
        }
        if let Some(live) = self.live.as_ref().filter(|live| !live.is_baked) {
            let has_headlight = live.has_headlight(&self.state.document);
            let text = if has_headlight {
                "not baked yet: a lamp at the camera"
            } else {
                "not baked yet: direct light only"
            };
            overlays::caption(
                painter,
                rect.left_bottom() + egui::vec2(10.0, -10.0),
                Align2::LEFT_BOTTOM,
                text,
            );
        }
        let (Some(picked), Some(live)) = (&self.picked, &self.live) else { return };
        overlays::paint_place(painter, &frame, &picked.picked);
        let Picked::Surface(surface) = &picked.picked else { return };
        let receiver = surface.light.as_ref().and_then(|light| light.receiver.as_ref());
        if let Some(receiver) = receiver.filter(|_| view.overlays.probes) {
            overlays::paint_probes(painter, &frame, &live.baked, live.runtime.plan(), receiver);
        }
        if let Some(grid) = self.grid.as_ref().filter(|_| view.overlays.grid) {
            overlays::paint_grid(painter, &frame, grid, surface, self.state.shown_ev);
        }
    }

    /// Lights and draws the scene if anything changed.
    fn light_and_draw(&mut self, seconds: f32) -> Result<(), GpuError> {
        self.gpu.check()?;
        let Some(live) = &mut self.live else { return Ok(()) };
        let view = &mut self.state.view;
        if view.is_playing && self.state.document.moves() {
            view.time += seconds;
        }
        self.fade = (self.fade - seconds / FADE_SECONDS).max(0.0);
        adapt(&mut self.state.shown_ev, view.exposure, self.meter.reading.as_ref().map(|r| r.ev), seconds);
        let passes = self.reference.as_ref().map_or(0, ReferencePicture::passes);
        let now = Drawn {
            document: self.state.document.clone(),
            view: view.clone(),
            ev: self.state.shown_ev,
            fade: self.fade,
            passes,
        };
        let last = self.drawn.as_ref();
        let is_new = last.is_none_or(|last| *last != now);
        let has_headlight = live.has_headlight(&self.state.document);
        let has_moved = |last: &Drawn| has_headlight && last.view.camera != now.view.camera;
        if last.is_none_or(|last| needs_light(last, &now) || has_moved(last)) {
            // Without a bake nothing bounces.
            self.settling = if live.is_baked { SETTLING_FRAMES } else { 1 };
        }
        if !is_new && self.settling == 0 {
            return Ok(());
        }
        if let Err(error) = live.sync(&self.state.document, view) {
            self.messages.error(error.to_string());
        }
        govern(&mut self.governor, view, live)?;
        if self.settling > 0 {
            self.settling -= 1;
            let queries = self.times.queries();
            live.light(&view.camera, view.options, view.overlays.grid, queries.as_deref());
            if let Some(queries) = queries {
                self.times.submitted(&self.gpu, queries);
            }
        }
        if view.options.view == probelight_render::gpu::GpuView::Clusters {
            texel_colors::apply(live, &view.camera, view.texel_colors);
        }
        self.screen.draw(live, view, self.state.shown_ev, self.fade, self.reference.as_ref())?;
        if self.settling.is_multiple_of(8) || last.is_none() {
            self.meter.measure(live, &view.camera, view.options)?;
        }
        self.draws += 1;
        self.drawn = Some(now);
        Ok(())
    }

    /// The reference grows while it is wanted and nothing changes.
    fn grow_reference(&mut self) {
        let Some(live) = self.live.as_ref().filter(|_| self.state.view.compare == Compare::Reference) else {
            return self.reference = None;
        };
        let view = &self.state.view;
        let subject = Subject {
            camera: view.camera.clone(),
            lighting: audible(&self.state.document, &view.muted, view.time),
            materials: self.state.document.materials.clone(),
            objects: live.placed_objects().map(|(_, object)| object.clone()).collect(),
        };
        if self.reference.as_ref().is_some_and(|reference| reference.shows(live.scene(), &subject)) {
            return;
        }
        // While something moves, each frame would begin anew.
        let is_still = matches!(self.grip, Grip::Nothing) && !self.context.input(mouse::is_moving);
        self.reference = is_still.then(|| ReferencePicture::start(live.scene(), subject, &self.context));
    }

    fn read_grid(&mut self) {
        let Some(live) = self.live.as_ref().filter(|_| self.state.view.overlays.grid) else {
            return self.grid = None;
        };
        if let Some(answer) = crate::scene::pending::take_ready(&mut self.grid_answer)
            && let Ok(values) = answer
        {
            let receivers = values.chunks_exact(3).map(Vec3::from_slice).collect();
            let spacing = live.baked.settings.grid_spacing.unwrap_or(0.02 * self.state.diagonal);
            self.grid = Some(GridOfLight { baked: Arc::clone(&live.baked), receivers, spacing });
        }
        if self.grid_answer.is_none() && live.baked.has_grid() && (self.settling > 0 || self.grid.is_none()) {
            let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
            let buffer = live.runtime.buffers().irradiance.clone();
            let read = async move {
                probelight_runtime::gpu::readback::read_buffer_async(&device, &queue, &buffer).await
            };
            self.grid_answer = Some(Pending::new(read));
        }
    }

    /// What the last frame computed of what there is.
    fn work(&self) -> Work {
        let Some(live) = &self.live else { return Work::default() };
        let plan = live.runtime.plan();
        Work {
            receivers: [plan.receivers(), self.full_plan.receivers[1]],
            matrix_bytes: [plan.matrix_bytes(&live.baked), self.full_plan.matrix_bytes[1]],
        }
    }

    /// Whether there is another frame without anything happening, and when.
    fn next_frame(&mut self, since: Instant) {
        let view = &self.state.view;
        let moves = view.is_playing && self.state.document.moves() && self.live.is_some();
        let is_waiting = self.meter.is_measuring()
            || self.grid_answer.is_some()
            || self.lightmap_answer.is_some()
            || self.pick_answers.texel.is_some();
        let adapts = view.exposure == ExposureMode::Automatic
            && self
                .meter
                .reading
                .as_ref()
                .is_some_and(|r| (r.ev - self.state.shown_ev).abs() > SAME_EXPOSURE);
        let is_active = self.settling > 0
            || self.fade > 0.0
            || moves
            || is_waiting
            || adapts
            || !matches!(self.grip, Grip::Nothing)
            || self.context.input(mouse::is_moving);
        let caps_frames = view.caps_frames;
        if !is_active || self.is_lost {
            return self.times.rest();
        }
        if caps_frames {
            self.context.request_repaint_after(CAPPED_FRAME.saturating_sub(since.elapsed()));
        } else {
            self.context.request_repaint();
        }
    }

    fn note_memory(&mut self) {
        if self.memory.1 == 0 || self.memory.0.elapsed() > Duration::from_millis(500) {
            let bytes = self.gpu.device.generate_allocator_report().map_or(0, |r| r.total_allocated_bytes);
            self.memory = (Instant::now(), bytes);
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let start = Instant::now();
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        // Nothing waits here: answers that are there are handed out.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.take_loaded();
        self.take_answers();
        let mut actions = mouse::pressed(&self.context);
        actions.extend(mouse::held(&self.context, &self.state, seconds));
        let dropped: Vec<PathBuf> =
            ui.input(|input| input.raw.dropped_files.iter().filter_map(|file| file.path.clone()).collect());
        actions.extend(dropped.into_iter().map(|path| Action::Request(Request::Open(path))));
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
        self.meter.update();
        if !self.is_lost
            && let Err(error) = self.light_and_draw(seconds)
        {
            self.is_lost = self.gpu.check().is_err();
            self.messages.error(error.to_string());
        }
        self.note_memory();
        if let Some(light) = self.times.note(start.elapsed())
            && let Some((_, governor)) = &mut self.governor
        {
            governor.note(light);
        }
        self.next_frame(start);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings.runs_free = !self.state.view.caps_frames;
        self.settings.save(storage);
    }
}

/// The exposure that is shown, some seconds later.
fn adapt(shown: &mut f32, mode: ExposureMode, metered: Option<f32>, seconds: f32) {
    match (mode, metered) {
        (ExposureMode::Fixed(ev), _) => *shown = ev,
        (ExposureMode::Automatic, Some(ev)) => {
            let left = (ev - *shown) * ADAPTATION.powf(seconds);
            *shown = if left.abs() < SAME_EXPOSURE { ev } else { ev - left };
        }
        (ExposureMode::Automatic, None) => {}
    }
}

/// Whether what changed changes light, not only the picture.
fn needs_light(last: &Drawn, now: &Drawn) -> bool {
    let of = |view: &ViewState| {
        let whole_grid = (view.overlays.grid, view.options.shading);
        (view.muted.clone(), view.lod.clone(), view.hold_milliseconds, whole_grid)
    };
    let looks_from_elsewhere = now.view.lod.levels.len() > 1 && last.view.camera != now.view.camera;
    let moves = last.view.time != now.view.time && now.document.moves();
    last.document != now.document || of(&last.view) != of(&now.view) || looks_from_elsewhere || moves
}

/// Gives the runtime the levels of detail: those of the view, or nearer ones that hold the time.
fn govern(
    governor: &mut Option<(f32, LodGovernor)>,
    view: &ViewState,
    live: &mut LiveScene,
) -> Result<(), GpuError> {
    let lod = match view.hold_milliseconds {
        None => {
            *governor = None;
            view.lod.clone()
        }
        Some(milliseconds) => {
            let is_same = governor.as_ref().is_some_and(|(held, _)| *held == milliseconds);
            if !is_same {
                let target = Duration::from_secs_f32(milliseconds.max(0.01) * 1e-3);
                *governor = Some((milliseconds, LodGovernor::new(target)));
            }
            governor.as_ref().map_or_else(|| view.lod.clone(), |(_, governor)| governor.govern(&view.lod))
        }
    };
    if *live.runtime.lod() != lod {
        live.runtime.set_lod(lod)?;
    }
    Ok(())
}

fn title(file: &Option<PathBuf>) -> String {
    let name = file.as_ref().and_then(|file| file.file_name());
    name.map_or_else(|| "nothing is open".into(), |name| name.to_string_lossy().into_owned())
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

/// All of a scene's frame: what there is to compute.
pub(crate) fn all_work(live: &LiveScene) -> Work {
    let full = FramePlan::full(&live.baked);
    Work { receivers: [0, full.receivers()], matrix_bytes: [0, full.matrix_bytes(&live.baked)] }
}

/// Closes the window.
pub(crate) fn close(context: &egui::Context) {
    context.send_viewport_cmd(ViewportCommand::Close);
}
