//! The program's window.

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

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
    /// The GPU does not answer any more.
    #[error("{reason}{}", told(rescued.as_deref()))]
    Lost {
        /// What the driver said.
        reason: String,
        /// Where changes of the setup were saved, if there were any.
        rescued: Option<PathBuf>,
    },
    /// A mistake of the program, which was reported as a panic.
    #[error("the window ended by a mistake of the program{}", told(rescued.as_deref()))]
    Broken {
        /// Where changes of the setup were saved, if there were any.
        rescued: Option<PathBuf>,
    },
    /// The system refused.
    #[error("the window failed: {0}")]
    Failed(String),
}

/// Where changes are, for people.
fn told(rescued: Option<&Path>) -> String {
    rescued.map_or(String::new(), |path| {
        format!("; your changes are in {0}: open it by --setup {0}", path.display())
    })
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
    let rescued = Arc::new(OnceLock::new());
    let (window_gpu, told) = (gpu.clone(), Arc::clone(&rescued));
    let make = move |creation: &eframe::CreationContext<'_>| {
        let state = creation.wgpu_render_state.as_ref().ok_or("the window has no GPU")?;
        let mut viewer = Viewer::new(&creation.egui_ctx, creation.storage, state, &window_gpu, options)?;
        viewer.rescued = told;
        Ok(Box::new(viewer) as Box<dyn eframe::App>)
    };
    be_quiet_once_lost(gpu);
    let run = || eframe::run_native("probelight", native, Box::new(make));
    // Libraries may panic when the GPU goes away under them.
    let ended = catch_unwind(AssertUnwindSafe(run));
    let rescued = rescued.get().cloned();
    match (gpu.check(), ended) {
        (Err(error), _) => Err(WindowError::Lost { reason: error.to_string(), rescued }),
        (Ok(()), Err(_)) => Err(WindowError::Broken { rescued }),
        // Its text speaks of source files.
        (Ok(()), Ok(Err(eframe::Error::WinitEventLoop(_) | eframe::Error::Winit(_)))) => {
            Err(WindowError::NoDisplay)
        }
        (Ok(()), Ok(Err(other))) => Err(WindowError::Failed(other.to_string())),
        (Ok(()), Ok(Ok(()))) => Ok(()),
    }
}

/// Panics that follow from a lost GPU are not reported: the error of [`run`] says all.
fn be_quiet_once_lost(gpu: &GpuDevice) {
    let (report, gpu) = (take_hook(), gpu.clone());
    set_hook(Box::new(move |panic| {
        if gpu.check().is_ok() {
            report(panic);
        }
    }));
}

/// Whether there is a display: asked before anything is opened.
pub fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || is_set("WAYLAND_DISPLAY") || is_set("DISPLAY")
}
