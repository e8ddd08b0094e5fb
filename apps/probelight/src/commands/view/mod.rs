//! `probelight view FILE`
//!
//! | module | job |
//! | --- | --- |
//! | `controls` | which key does what |
//! | `viewer` | camera, lights and view, and how keys and mouse change them: no window needed |
//! | `window` | events in, pictures out |
//! | `screen` | the window's surface |
//! | `clock` | time between frames |

mod clock;
mod controls;
mod screen;
mod viewer;
mod window;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use clap::Args;
use probelight_render::gpu::{GpuRenderer, LitScene, ViewOptions};
use probelight_render::{Exposure, ToneMap};
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime};
use probelight_scene::Camera;
use winit::event_loop::EventLoop;

use self::viewer::Viewer;
use self::window::{LiveScene, SceneWindow};
use crate::console::Console;
use crate::movers::{Movers, ObjectFlags};
use crate::{input, interrupt};

/// Flags of `view`.
#[derive(Args)]
#[command(after_help = controls::HELP)]
pub(crate) struct Flags {
    /// A baked file (.plight), or a scene (.glb, .gltf) to bake quickly in memory
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Lights, sky and cameras [default: those of the glTF file]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    #[command(flatten)]
    objects: ObjectFlags,
    /// Name of the camera to begin at [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Size of the window at the beginning [default: that of the camera's picture]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = input::parse_size)]
    size: Option<(u32, u32)>,
    /// Exposure at the beginning, as a power of two [default: from the brightness of the first picture]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = super::render::finite)]
    exposure: Option<f32>,
    /// Part of the name of the GPU to use [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

const NO_DISPLAY: &str = "no display: use `probelight render`, which needs none \
    (on Linux windows need X11 or XWayland, and its libraries)";

/// Shows a scene in a window until it is closed.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    // Without a display nothing needs to be baked. The error's own text speaks of source files.
    let event_loop = EventLoop::new().map_err(|_| anyhow!(NO_DISPLAY))?;
    let gpu = GpuDevice::open(flags.adapter.as_deref())
        .context("a window needs a GPU; `probelight render --backend cpu` does not")?;
    if gpu.is_software() {
        console.note(format!("the GPU {:?} is a driver in software: frames will be slow", gpu.info.name));
    }
    let baked = input::load_or_bake(&flags.file, console)?;
    let setup = input::load_setup(flags.setup.as_deref(), &baked.scene)?;
    let camera = input::choose_camera(&setup, flags.camera.as_deref(), flags.size)?;
    let mut runtime = GpuRuntime::new(&gpu.device, &gpu.queue, Arc::clone(&baked), GpuOptions::default())?;
    let (geometry, shadow_maps, grid) = (runtime.geometry(), runtime.shadow_maps(), runtime.grid());
    let renderer =
        GpuRenderer::new(&gpu.device, &gpu.queue, Arc::clone(&baked), geometry, shadow_maps, grid)?;
    let movers = Movers::load(&setup, flags.setup.as_deref(), &flags.objects.objects, console)?;
    movers.note_missing_grid(&baked, console);
    let objects = movers.enter(runtime.objects_mut())?;
    runtime.upload_objects()?;
    input::light_on_gpu(&mut runtime, &setup, console)?;
    interrupt::check()?;

    let mut scene = LiveScene { gpu, runtime, renderer, movers, objects };
    let ev = flags.exposure.map_or_else(|| scene.automatic_exposure(&camera), Ok)?;
    let diagonal = baked.scene.bounds().diagonal();
    let viewer = Viewer::new(camera, setup.lighting, ev, diagonal, scene.movers.paths());
    let name = flags.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    console.clear_progress();
    let mut window = SceneWindow::new(name, scene, viewer);
    event_loop.run_app(&mut window).context("the window failed")?;
    window.failure().map_or_else(interrupt::check, Err)
}

impl LiveScene {
    /// What suits a small picture of what the camera sees, as a power of two.
    fn automatic_exposure(&mut self, camera: &Camera) -> anyhow::Result<f32> {
        let height = (160 * camera.height / camera.width).max(1);
        let small = Camera { width: 160, height, ..camera.clone() };
        let scene = LitScene::of(&self.runtime);
        let picture = self.renderer.still(&scene, &small, ViewOptions::default(), 4)?;
        Ok(ToneMap::new(Exposure::Automatic, &picture).ev())
    }
}
