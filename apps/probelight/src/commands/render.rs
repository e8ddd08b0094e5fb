//! `probelight render FILE|SCENE -o OUT.png`

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use probelight_render::gpu::GpuView;
use probelight_render::{Exposure, PixelFilter};
use serde::Serialize;

use crate::animation::{self, Frames};
use crate::backend::BackendFlags;
use crate::console::{self, Console};
use crate::movers::{InfluenceFlags, Movers, ObjectFlags};
use crate::output::PictureFormat;
use crate::studio::{PictureOptions, ShadingFlag, Studio, view_parser};
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight render room.plight -o room.png
  probelight render room.plight --setup night.json --camera door -o night.png --samples 64
  probelight render room.plight --setup night.json --view indirect -o indirect.exr
  probelight render room.glb -o try.png            bakes in memory with quick settings first
  probelight render room.plight --backend gpu --shading physical -o glossy.png
  probelight render room.plight --view probes -o probes.png
  probelight render room.plight --setup rolling.json --animate 4 --fps 25 -o frames
  probelight render room.plight --object chair.glb@1,0,2.5 --object ball.glb@0,1,0 -o moved.png

A .png is exposed and tone mapped for the screen; an .exr holds linear radiance (W/m²/sr), or
irradiance (W/m²) with `--view irradiance`. Without a GPU the CPU makes the same pictures but for
those marked with (GPU) below.";

/// Flags of `render`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight), or a scene (.glb, .gltf) to bake quickly in memory
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The picture to write (.png or .exr), or the folder for those of --animate
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Lights, sky and cameras [default: those of the glTF file]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    #[command(flatten)]
    objects: ObjectFlags,
    #[command(flatten)]
    influence: InfluenceFlags,
    /// Write a picture for each frame of so many seconds into the folder OUT, with the setup's objects and
    /// lights in motion, and a video if ffmpeg is there
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    animate: Option<f32>,
    /// Frames per second of --animate
    #[arg(long, value_name = "N", default_value_t = 25, requires = "animate",
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    fps: u32,
    /// Name of the camera [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// What to show
    #[arg(long, alias = "output", value_parser = view_parser(), default_value = "full")]
    view: GpuView,
    /// How surfaces reflect light
    #[arg(long, value_enum, default_value_t)]
    shading: ShadingFlag,
    /// Exposure as a power of two, for .png [default: from the picture's brightness]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = finite)]
    exposure: Option<f32>,
    /// Samples per pixel; on a GPU 4, 16, 36 and so on, at least these
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,
    /// How a pixel weighs its samples
    #[arg(long, value_enum, default_value_t)]
    filter: FilterFlag,
    /// Size of the picture, instead of the camera's
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = input::parse_size)]
    size: Option<(u32, u32)>,
    #[command(flatten)]
    backend: BackendFlags,
    /// Print what was done as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum FilterFlag {
    /// Evenly over the pixel's square, as references do
    #[default]
    Box,
    /// Gaussian, for smoother edges
    Gaussian,
}

/// Parses a finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a number".into()),
    }
}

/// Parses a finite number above zero.
fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "expected a number above zero".into())
}

/// What a picture needs to know, checked.
struct Settings {
    flags: Flags,
    format: PictureFormat,
    /// `None` for pictures of colours.
    exposure: Option<Exposure>,
    options: PictureOptions,
}

impl Flags {
    fn resolve(self) -> anyhow::Result<Settings> {
        if self.animate.is_some() {
            output::create_folder(&self.out)?;
        }
        let first = self.animate.map_or_else(|| self.out.clone(), |_| animation::frame_file(&self.out, 0));
        let format = PictureFormat::of(&first)?;
        let inputs: Vec<&Path> = [&self.file].into_iter().chain(&self.setup).map(PathBuf::as_path).collect();
        output::check(&first, &inputs)?;
        let filter = match self.filter {
            FilterFlag::Box => PixelFilter::Box,
            FilterFlag::Gaussian => PixelFilter::Gaussian,
        };
        let exposure = self.exposure.map_or(Exposure::Automatic, Exposure::Ev);
        let exposure = self.view.is_light().then_some(exposure);
        let Self { view, shading, samples, .. } = self;
        let options = PictureOptions { view, shading, samples, filter };
        Ok(Settings { flags: self, format, exposure, options })
    }
}

/// What `render --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    output: &'a Path,
    backend: &'a str,
    camera: &'a str,
    width: u32,
    height: u32,
    samples: u32,
    bounces: usize,
    exposure_ev: Option<f32>,
    light_seconds: f64,
    render_seconds: f64,
}

/// Makes a picture.
pub(crate) fn run(flags: Flags, console: &Console) -> anyhow::Result<()> {
    let Settings { flags, format, exposure, options } = flags.resolve()?;
    // A wrong setup or camera is reported before a scene is baked for nothing.
    if let Some(path) = &flags.setup {
        input::choose_camera(&probelight_scene::Setup::load(path)?, flags.camera.as_deref(), flags.size)?;
    }
    let backend = flags.backend.open_for(options.needs_gpu(), console)?;
    options.check(&backend)?;
    let computed_on = backend.describe();
    let baked = input::load_or_bake(&flags.file, console)?;
    let setup = input::load_setup(flags.setup.as_deref(), &baked.scene)?;
    let camera = input::choose_camera(&setup, flags.camera.as_deref(), flags.size)?;
    let movers = Movers::load(&setup, flags.setup.as_deref(), &flags.objects.paths(), console)?;
    let start = Instant::now();
    let mut studio = Studio::new(backend, baked)?;
    studio.objects_mut().set_influence(!flags.influence.no_soft_shadows);
    let objects = studio.enter(&movers, console)?;
    let bounces = studio.light(&setup, console)?;
    let light_seconds = start.elapsed().as_secs_f64();
    interrupt::check()?;
    if let Some(seconds) = flags.animate {
        let frames = Frames { seconds, fps: flags.fps, folder: &flags.out, setup: &setup, exposure };
        return frames.write(&mut studio, &movers, &objects, &camera, &options, console);
    }
    let start = Instant::now();
    let image = studio.picture(&camera, &options, console)?;
    let render_seconds = start.elapsed().as_secs_f64();
    console.clear_progress();
    if image.pixels.iter().all(|pixel| pixel.max_element() <= 0.0) {
        console
            .note("the picture is black: does the camera see lit surfaces? --setup gives lights and cameras");
    }
    let exposure_ev = output::write_picture(&image, &flags.out, format, exposure)?;
    if flags.json {
        return console::print_json(&Report {
            output: &flags.out,
            backend: &computed_on,
            camera: &camera.name,
            width: camera.width,
            height: camera.height,
            samples: options.samples,
            bounces,
            exposure_ev,
            light_seconds,
            render_seconds,
        });
    }
    let exposed = exposure_ev.map_or(String::new(), |ev| format!(", exposure {ev:+.2} EV"));
    console.note(format!(
        "wrote {} ({computed_on}: {bounces} bounces in {light_seconds:.2} s, picture in {render_seconds:.2} s{exposed})",
        flags.out.display()
    ));
    Ok(())
}
