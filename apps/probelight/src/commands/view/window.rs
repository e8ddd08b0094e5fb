//! The window: events in, pictures out. A frame is one more bounce of light, and one picture.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use probelight_math::glam::DVec2;
use probelight_render::ToneMap;
use probelight_render::gpu::{GpuRenderer, LitScene};
use probelight_runtime::gpu::{GpuDevice, GpuRuntime};
use probelight_runtime::{FrameInput, ObjectId};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::PhysicalKey;
use winit::window::{Window, WindowId};

use super::clock::FrameClock;
use super::controls::{self, Action, Motion};
use super::screen::Screen;
use super::viewer::Viewer;
use crate::interrupt;
use crate::movers::Movers;

/// Pause while nothing can be seen of the window.
const HIDDEN_PAUSE: Duration = Duration::from_millis(50);

/// A baked scene on a GPU, lit and drawn frame by frame.
pub(super) struct LiveScene {
    pub(super) gpu: GpuDevice,
    pub(super) runtime: GpuRuntime,
    pub(super) movers: Movers,
    pub(super) objects: Vec<ObjectId>,
    pub(super) renderer: GpuRenderer,
}

/// A scene in a window.
pub(super) struct SceneWindow {
    name: String,
    scene: LiveScene,
    viewer: Viewer,
    /// Made when the system is ready for it.
    screen: Option<Screen>,
    held: HashSet<Motion>,
    is_looking: bool,
    clock: FrameClock,
    failure: Option<anyhow::Error>,
}

impl SceneWindow {
    /// `name` is what the title begins with.
    pub(super) fn new(name: String, scene: LiveScene, viewer: Viewer) -> Self {
        Self {
            name,
            scene,
            viewer,
            screen: None,
            held: HashSet::new(),
            is_looking: false,
            clock: FrameClock::new(Instant::now()),
            failure: None,
        }
    }

    /// Why the window closed, if nobody closed it.
    pub(super) fn failure(self) -> Option<anyhow::Error> {
        self.failure
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let camera = &self.viewer.state.camera;
        let attributes = Window::default_attributes()
            .with_title(&self.name)
            .with_inner_size(PhysicalSize::new(camera.width, camera.height));
        let window = event_loop.create_window(attributes).context("cannot open a window")?;
        let screen = Screen::new(&self.scene.gpu, Arc::new(window))?;
        let (width, height) = screen.size();
        self.viewer.resize(width, height);
        screen.window.request_redraw();
        self.screen = Some(screen);
        self.clock = FrameClock::new(Instant::now());
        Ok(())
    }

    fn resize(&mut self, size: PhysicalSize<u32>) -> anyhow::Result<()> {
        let Some(screen) = &mut self.screen else { return Ok(()) };
        screen.resize(&self.scene.gpu, size)?;
        let (width, height) = screen.size();
        self.viewer.resize(width, height);
        Ok(())
    }

    fn key(&mut self, event: &KeyEvent, event_loop: &ActiveEventLoop) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        if let Some(motion) = controls::motion(code) {
            match event.state {
                ElementState::Pressed => self.held.insert(motion),
                ElementState::Released => self.held.remove(&motion),
            };
        }
        if event.state == ElementState::Pressed && !event.repeat {
            match controls::action(code) {
                Some(Action::Quit) => event_loop.exit(),
                Some(action) => self.viewer.act(action),
                None => {}
            }
        }
    }

    /// Lights the scene as it is now, draws it and shows it.
    fn frame(&mut self) -> anyhow::Result<()> {
        let Some(screen) = &mut self.screen else { return Ok(()) };
        screen.window.request_redraw();
        let LiveScene { gpu, runtime, renderer, movers, objects } = &mut self.scene;
        let Some(texture) = screen.next_texture(gpu)? else {
            std::thread::sleep(HIDDEN_PAUSE);
            return Ok(());
        };
        self.viewer.advance(&self.held, self.clock.tick(Instant::now()));
        let state = &self.viewer.state;
        runtime.set_lighting(state.lighting.clone())?;
        movers.pose(objects, runtime.objects_mut(), self.viewer.time())?;
        for (id, placement) in objects.iter().zip(self.viewer.placements()) {
            runtime.objects_mut().place(*id, placement)?;
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = Some((&state.camera).into());
        let whole_grid = renderer.shows_whole_grid(state.options);
        let input = FrameInput { view, whole_grid, ..FrameInput::default() };
        match self.clock.mean_frame(Instant::now()) {
            // Two frames a second are measured, which takes a moment.
            Some(frame) => {
                runtime.plan_frame(&input);
                let light = runtime.measure_frames(1, |_, _| Ok(()))?.first().map(|times| times.frame);
                screen.window.set_title(&title(&self.name, &self.viewer, frame, light.unwrap_or_default()));
            }
            None => runtime.encode(&input, &mut encoder),
        }
        renderer.draw(&mut encoder, &screen.picture, &LitScene::of(runtime), &state.camera, state.options);
        let tone_map = ToneMap { scale: state.ev.exp2() };
        let target = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        screen.presenter.present(&mut encoder, &screen.picture, state.options.view, tone_map, &target);
        gpu.queue.submit([encoder.finish()]);
        screen.window.pre_present_notify();
        texture.present();
        Ok(gpu.check()?)
    }

    /// Closes the window if something failed.
    fn keep(&mut self, result: anyhow::Result<()>, event_loop: &ActiveEventLoop) {
        if let Err(failure) = result {
            self.failure = Some(failure);
            event_loop.exit();
        }
    }
}

/// What the title says.
fn title(name: &str, viewer: &Viewer, frame: Duration, light: Duration) -> String {
    let [frame, light] = [frame, light].map(|time| time.as_secs_f64() * 1e3);
    let state = &viewer.state;
    format!(
        "{name} – {:?} – frame {frame:.1} ms – indirect light {light:.2} ms – {:+.1} EV",
        state.options.view, state.ev
    )
}

impl ApplicationHandler for SceneWindow {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.screen.is_none() {
            let opened = self.open(event_loop);
            self.keep(opened, event_loop);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => {
                let resized = self.resize(size);
                self.keep(resized, event_loop);
            }
            WindowEvent::KeyboardInput { event, .. } => self.key(&event, event_loop),
            WindowEvent::MouseInput { state, button: MouseButton::Left | MouseButton::Right, .. } => {
                self.is_looking = state == ElementState::Pressed;
            }
            // Keys that are let go elsewhere are never heard of.
            WindowEvent::Focused(false) => {
                self.held.clear();
                self.is_looking = false;
            }
            WindowEvent::RedrawRequested => {
                let drawn = self.frame();
                self.keep(drawn, event_loop);
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta } = event
            && self.is_looking
        {
            self.viewer.look(DVec2::from(delta).as_vec2());
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if interrupt::is_requested() {
            event_loop.exit();
        }
    }
}
