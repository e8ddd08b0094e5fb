//! The program's window.

use eframe::egui::{ViewportBuilder, vec2};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupExisting};
use probelight_runtime::gpu::GpuDevice;

use crate::viewer::{Viewer, ViewerOptions};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display to open it on.
    #[error(
        "no display: use `probelight render`, which needs none \
         (on Linux windows need Wayland or X11, and its libraries)"
    )]
    NoDisplay,
    /// The system refused.
    #[error("the window failed: {0}")]
    Failed(String),
}

/// How the window begins.
#[derive(Clone, Copy, Debug)]
pub struct WindowOptions {
    /// Width and height, points.
    pub size: (u32, u32),
}

impl Default for WindowOptions {
    fn default() -> Self {
        Self { size: (1440, 900) }
    }
}

/// Shows a scene in a window until it is closed.
///
/// # Errors
/// See [`WindowError`].
pub fn run(gpu: &GpuDevice, options: ViewerOptions, window: WindowOptions) -> Result<(), WindowError> {
    if !has_display() {
        return Err(WindowError::NoDisplay);
    }
    let (width, height) = window.size;
    let setup = WgpuSetup::Existing(WgpuSetupExisting {
        instance: gpu.instance.clone(),
        adapter: gpu.adapter.clone(),
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    });
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Probelight")
            .with_app_id("probelight")
            .with_inner_size(vec2(width as f32, height as f32))
            .with_min_inner_size(vec2(640.0, 400.0))
            .with_drag_and_drop(true),
        wgpu_options: WgpuConfiguration { wgpu_setup: setup, ..WgpuConfiguration::default() },
        // The size is the one that is asked for.
        persist_window: false,
        ..eframe::NativeOptions::default()
    };
    let gpu = gpu.clone();
    let make = move |creation: &eframe::CreationContext<'_>| {
        let state = creation.wgpu_render_state.as_ref().ok_or("the window has no GPU")?;
        let viewer = Viewer::new(&creation.egui_ctx, creation.storage, state, &gpu, options)?;
        Ok(Box::new(viewer) as Box<dyn eframe::App>)
    };
    eframe::run_native("probelight", native, Box::new(make)).map_err(|error| match error {
        // Its text speaks of source files.
        eframe::Error::WinitEventLoop(_) | eframe::Error::Winit(_) => WindowError::NoDisplay,
        other => WindowError::Failed(other.to_string()),
    })
}

/// Whether there is a display: asked before anything is opened.
pub fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || is_set("WAYLAND_DISPLAY") || is_set("DISPLAY")
}
