//! Lights and draws the scene if anything changed.

use std::sync::Arc;
use std::time::Duration;

use eframe::SurfaceConfig;
use eframe::wgpu::PresentMode;
use probelight_math::glam::Vec3;
use probelight_runtime::gpu::GpuError;
use probelight_runtime::{GridPlaces, LodGovernor};
use web_time::Instant;

use super::Viewer;
use crate::mouse::{self, Grip};
use crate::overlays::GridOfLight;
use crate::picture::texel_colors;
use crate::scene::live_scene::{LiveScene, audible};
use crate::scene::pending::Pending;
use crate::scene::reference_picture::{ReferencePicture, Subject};
use crate::state::Document;
use crate::state::view_state::{Compare, ExposureMode, ViewState};

/// Frames in which light settles after a change: bounces, until nothing changes that one sees.
const SETTLING_FRAMES: u32 = 96;

/// How long indirect light takes to appear after a bake, seconds.
const FADE_SECONDS: f32 = 1.5;

/// Share of the way to the metered exposure that is gone in a second: the rest of it.
const ADAPTATION: f32 = 0.03;

/// Exposures nearer than this look the same.
const SAME_EXPOSURE: f32 = 0.01;

/// Time between two frames that are recorded, seconds, however long they take to be drawn and saved.
const RECORDED_FRAME: f32 = 1.0 / 30.0;

/// Time of a frame at sixty a second.
const CAPPED_FRAME: Duration = Duration::from_micros(16_667);

/// What was lit and drawn last: what equals it is not done again.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    document: Document,
    view: ViewState,
    ev: f32,
    fade: f32,
    passes: u32,
}

impl Drawn {
    fn shows(&self, document: &Document, view: &ViewState, ev: f32, fade: f32, passes: u32) -> bool {
        let is_same_light = self.document == *document && self.view == *view;
        is_same_light && (self.ev, self.fade, self.passes) == (ev, fade, passes)
    }
}

impl Viewer {
    /// Lights and draws the scene if anything changed.
    pub(super) fn light_and_draw(&mut self, seconds: f32) -> Result<(), GpuError> {
        self.gpu.check()?;
        let lacks_exposure = self.lacks_exposure();
        if lacks_exposure && self.meter.is_measuring() {
            return Ok(());
        }
        let Some(live) = &mut self.live else { return Ok(()) };
        let seconds = if self.recording.is_some() { RECORDED_FRAME } else { seconds };
        let view = &mut self.state.view;
        if view.is_playing && self.state.document.moves() {
            view.time += seconds;
        }
        self.fade = (self.fade - seconds / FADE_SECONDS).max(0.0);
        // The first picture of a scene has the right exposure.
        let adapting = if self.drawn.is_none() { f32::INFINITY } else { seconds };
        adapt(&mut self.state.shown_ev, view.exposure, self.meter.reading.as_ref().map(|r| r.ev), adapting);
        let passes = self.reference.as_ref().map_or(0, ReferencePicture::passes);
        let (document, ev, fade) = (&self.state.document, self.state.shown_ev, self.fade);
        let last = self.drawn.as_ref();
        let is_new = last.is_none_or(|last| !last.shows(document, view, ev, fade, passes));
        let has_headlight = live.has_headlight(document);
        let has_moved = |last: &Drawn| has_headlight && last.view.camera != view.camera;
        if last.is_none_or(|last| needs_light(last, document, view) || has_moved(last)) {
            // Without a bake nothing bounces.
            self.settling = if live.is_baked { SETTLING_FRAMES } else { 1 };
        }
        if !is_new && self.settling == 0 {
            return Ok(());
        }
        if let Err(error) = live.sync(document, view) {
            self.messages.error(error.to_string());
        }
        govern(&mut self.governor, self.held.scale, view, live)?;
        if self.settling > 0 {
            self.settling -= 1;
            let queries = self.times.queries();
            live.light(&view.camera, view.options, view.overlays.grid, queries.as_deref());
            if let Some(queries) = queries {
                self.times.submitted(&self.gpu, queries);
            }
            self.work.ask(live);
        }
        if view.options.view == probelight_render::gpu::GpuView::Clusters {
            texel_colors::apply(live, &view.camera, view.texel_colors);
        }
        live.fit_shadows(&view.camera);
        if lacks_exposure {
            return self.meter.measure(live, &view.camera, view.options);
        }
        self.screen.draw(live, view, ev, fade, self.reference.as_ref())?;
        if self.settling.is_multiple_of(8) || last.is_none() {
            self.meter.measure(live, &view.camera, view.options)?;
        }
        self.draws += 1;
        self.drawn = Some(Drawn { document: document.clone(), view: view.clone(), ev, fade, passes });
        self.record();
        Ok(())
    }

    /// Whether nobody knows yet how bright the scene is.
    fn lacks_exposure(&self) -> bool {
        self.live.is_some()
            && self.state.view.exposure == ExposureMode::Automatic
            && self.meter.reading.is_none()
    }

    /// The reference grows while it is wanted and nothing changes.
    pub(super) fn grow_reference(&mut self) {
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

    pub(super) fn read_grid(&mut self) {
        let Some(live) = self.live.as_ref().filter(|_| self.state.view.overlays.grid) else {
            return self.grid = None;
        };
        if let Some(answer) = crate::scene::pending::take_ready(&mut self.grid_answer)
            && let Ok(values) = answer
        {
            let receivers = values.chunks_exact(3).map(Vec3::from_slice).collect();
            let spacing = live.baked.settings.grid_spacing.unwrap_or(0.02 * self.state.diagonal);
            let places = GridPlaces::new(&live.baked);
            self.grid = Some(GridOfLight { baked: Arc::clone(&live.baked), places, receivers, spacing });
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

    /// Whether light or picture are another in the next frame.
    pub(super) fn is_changing(&self) -> bool {
        let view = &self.state.view;
        let moves = view.is_playing && self.state.document.moves() && self.live.is_some();
        self.settling > 0
            || self.fade > 0.0
            || moves
            || self.adapts()
            || !matches!(self.grip, Grip::Nothing)
            || self.context.input(mouse::is_moving)
    }

    /// Whether the shown exposure is still on its way.
    fn adapts(&self) -> bool {
        let is_apart = |ev: f32| (ev - self.state.shown_ev).abs() > SAME_EXPOSURE;
        let reading = self.meter.reading.as_ref();
        self.state.view.exposure == ExposureMode::Automatic && reading.is_some_and(|r| is_apart(r.ev))
    }

    /// Light settles anew.
    pub(super) fn settle_again(&mut self) {
        self.settling = SETTLING_FRAMES;
    }

    /// Whether there is another frame without anything happening, and when.
    pub(super) fn next_frame(&mut self, since: Instant) {
        let is_waiting = self.meter.is_measuring()
            || self.grid_answer.is_some()
            || self.lightmap_answer.is_some()
            || self.pick_answers.texel.is_some()
            || self.held.is_searching()
            || self.work.is_asking();
        let caps_frames = self.state.view.caps_frames;
        if !(is_waiting || self.is_changing()) {
            return self.times.rest();
        }
        if caps_frames {
            self.context.request_repaint_after(CAPPED_FRAME.saturating_sub(since.elapsed()));
        } else {
            self.context.request_repaint();
        }
    }

    pub(super) fn note_memory(&mut self) {
        if self.memory.1 == 0 || self.memory.0.elapsed() > Duration::from_millis(500) {
            let bytes = self.gpu.device.generate_allocator_report().map_or(0, |r| r.total_allocated_bytes);
            self.memory = (Instant::now(), bytes);
        }
    }

    /// Has frames wait for the display, or not, as the view says.
    pub(super) fn wait_for_display(&self, frame: &mut eframe::Frame) {
        let Some(surface) = frame.wgpu_surface_config() else { return };
        let vsync = self.state.view.vsync;
        let present_mode = if vsync { PresentMode::AutoVsync } else { PresentMode::AutoNoVsync };
        frame.set_wgpu_surface_config(SurfaceConfig { present_mode, ..surface });
    }

    /// The next frame lights and draws everything anew.
    pub(crate) fn forget_drawn(&mut self) {
        self.drawn = None;
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
fn needs_light(last: &Drawn, document: &Document, view: &ViewState) -> bool {
    let of = |view: &ViewState| {
        let whole_grid = (view.overlays.grid, view.options.shading);
        (view.muted.clone(), view.lod.clone(), view.hold_milliseconds, view.hold_similarity, whole_grid)
    };
    let looks_from_elsewhere = view.lod.levels.len() > 1 && last.view.camera != view.camera;
    let moves = last.view.time != view.time && document.moves();
    last.document != *document || of(&last.view) != of(view) || looks_from_elsewhere || moves
}

/// Gives the runtime the levels of detail: those of the view, moved so that they hold a similarity, or nearer ones that
/// hold the time.
fn govern(
    governor: &mut Option<(f32, LodGovernor)>,
    held_scale: Option<f32>,
    view: &ViewState,
    live: &mut LiveScene,
) -> Result<(), GpuError> {
    let wanted = view.lod.clone().with_distances_scaled(held_scale.unwrap_or(1.0));
    let lod = match view.hold_milliseconds {
        None => {
            *governor = None;
            wanted
        }
        Some(milliseconds) => {
            let is_same = governor.as_ref().is_some_and(|(held, _)| *held == milliseconds);
            if !is_same {
                let target = Duration::from_secs_f32(milliseconds.max(0.01) * 1e-3);
                *governor = Some((milliseconds, LodGovernor::new(target)));
            }
            match governor {
                Some((_, governor)) => governor.govern(&wanted),
                None => wanted,
            }
        }
    };
    if *live.runtime.lod() != lod {
        live.runtime.set_lod(lod)?;
    }
    Ok(())
}
