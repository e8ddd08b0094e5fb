//! `probelight view FILE`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, ensure};
use clap::Args;
use probelight_runtime::gpu::GpuDevice;
use probelight_viewer::state::keys;
use probelight_viewer::{ViewerOptions, WindowError, WindowOptions};

use crate::bundled::BundledScene;
use crate::console::Console;
use crate::input;
use crate::interrupt;
use crate::movers::ObjectFlags;

/// Flags of `view`.
#[derive(Args)]
#[command(after_help = keys_help())]
pub(crate) struct Flags {
    /// A baked file (.plight), or a scene (.glb, .gltf), which is shown at once and baked meanwhile
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Lights, sky and cameras [default: those of the glTF file]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    #[command(flatten)]
    objects: ObjectFlags,
    /// Name of the camera to begin at [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Size of the window at the beginning
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = input::parse_size)]
    size: Option<(u32, u32)>,
    /// Exposure, as a power of two [default: from the brightness of the picture, all the time]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = super::render::finite)]
    exposure: Option<f32>,
    /// Share of the window's pixels, along each side, that are drawn [default: 1, with a driver in software 0.5]
    #[arg(long, value_name = "SHARE", value_parser = resolution)]
    resolution: Option<f32>,
    /// Frames do not wait for the display
    #[arg(long)]
    no_vsync: bool,
    /// Part of the name of the GPU to use [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Parses a share of the window's pixels.
fn resolution(text: &str) -> anyhow::Result<f32> {
    let share = text.parse().ok().filter(|share| (0.1..=1.0).contains(share));
    share.context("expected a number from 0.1 to 1")
}

/// The keys and what they do, for the command's help.
fn keys_help() -> String {
    let mut help = String::from("Mouse and keys (F1 in the window shows all):\n");
    for (held, what) in keys::HELD {
        help.push_str(&format!("  {held:<28}{what}\n"));
    }
    help
}

/// Shows a scene in a window until it is closed.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    let started = Instant::now();
    // Without a display nothing needs to be opened.
    ensure!(probelight_viewer::has_display(), WindowError::NoDisplay);
    for file in flags.file.iter().chain(&flags.setup) {
        // The window would say so, too; whoever typed a wrong name reads it here.
        ensure!(file.exists(), "{} does not exist", file.display());
    }
    let gpu = GpuDevice::open(flags.adapter.as_deref())
        .context("a window needs a GPU; `probelight render --backend cpu` does not")?;
    if gpu.is_software() {
        console.note(format!("the GPU {:?} is a driver in software: frames will be slow", gpu.info.name));
    }
    let options = ViewerOptions {
        file: flags.file.clone(),
        setup: flags.setup.clone(),
        camera: flags.camera.clone(),
        exposure: flags.exposure,
        resolution: flags.resolution,
        vsync: flags.no_vsync.then_some(false),
        objects: flags.objects.paths(),
        started: Some(started),
        ..options()
    };
    let window = flags.size.map_or_else(WindowOptions::default, |size| WindowOptions { size });
    show(&gpu, options, window)
}

/// Shows a baked file under a setup.
pub(crate) fn show_file(file: &Path, setup: &Path) -> anyhow::Result<()> {
    let gpu = GpuDevice::open(None).context("a window needs a GPU")?;
    let begin = ViewerOptions { file: Some(file.into()), setup: Some(setup.into()), ..options() };
    show(&gpu, begin, WindowOptions::default())
}

/// What every window begins with.
fn options() -> ViewerOptions {
    ViewerOptions {
        ball: Some(("ball.glb".into(), Arc::from(BundledScene::ball_glb()))),
        ..ViewerOptions::default()
    }
}

fn show(gpu: &GpuDevice, options: ViewerOptions, window: WindowOptions) -> anyhow::Result<()> {
    interrupt::end_at_once();
    Ok(probelight_viewer::run(gpu, options, window)?)
}
