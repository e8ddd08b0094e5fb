//! `probelight bench [FILE]`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::ensure;
use clap::{Args, ValueEnum};
use probelight_asset::BakedScene;
use probelight_runtime::View;
use probelight_runtime::synthetic::{SyntheticSize, synthetic_lighting, synthetic_room};
use probelight_scene::Lighting;

use crate::backend::BackendFlags;
use crate::bench_report::{BenchReport, SceneFigures};
use crate::console::{self, Console};
use crate::lod_flag::{LodChoice, parse_lod};
use crate::planning_clock::{bounds_of_clusters, planning_times};
use crate::stage_clock::{LightShow, StageClock, lamp_and_sun};
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight bench room.plight --backend gpu
  probelight bench --synthetic 512000 --backend cpu
  probelight bench --synthetic 512000 --method paper --adapter h100 --json
  probelight bench room.plight --moving-lights               lights that stand still and that move
  probelight bench room.plight --active-grid 0 1 100         what objects in the grid cost
  probelight bench room.plight --lod medium --camera hall    with levels of detail
  probelight bench --synthetic 512000 --objects 1000         planning with so many moving objects
  probelight bench --scaling --backend gpu -o bench.json     50,000 to 8 million receivers

Each stage moves at least its inputs and its outputs once. `of copy` is the speed at which it
would then have moved them, as a share of the speed at which the same device copies memory in the
same run. Times are medians; on a GPU they come from its own clock.";

/// Sizes of `--scaling`, receivers.
const SCALING: [usize; 9] =
    [50_000, 100_000, 200_000, 512_000, 1_000_000, 2_000_000, 4_000_000, 6_000_000, 8_000_000];

/// Flags of `bench`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE", required_unless_present_any = ["synthetic", "scaling"])]
    file: Option<PathBuf>,
    /// Lights and sky [default: those of the glTF file]
    #[arg(long, value_name = "S.json", requires = "file")]
    setup: Option<PathBuf>,
    /// Scenes made of random numbers with about so many receivers, instead of a file
    #[arg(
        long,
        value_name = "RECEIVERS",
        num_args = 1..,
        conflicts_with_all = ["file", "scaling"],
        value_parser = clap::value_parser!(u32).range(1000..=16_000_000)
    )]
    synthetic: Vec<u32>,
    /// Synthetic scenes of 50,000 to 8 million receivers
    #[arg(long, conflicts_with = "file")]
    scaling: bool,
    /// What synthetic scenes are like
    #[arg(long, value_enum, default_value_t)]
    method: MethodFlag,
    /// Also measure frames in which all lights move, so that direct light counts too (drawing shadow maps does not); a
    /// scene without lights gets a lamp and a sun
    #[arg(long)]
    moving_lights: bool,
    /// Shares of the grid in free space around which something moves, per cent: one measurement each
    #[arg(long, value_name = "PERCENT", num_args = 1.., default_values_t = [0.0], value_parser = percent)]
    active_grid: Vec<f64>,
    /// Also measure how long the CPU plans a frame in which so many objects move (half a metre wide, anywhere)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    objects: Option<u32>,
    /// Levels of detail: a preset (low, medium, high, exact, published) or a JSON file, @SCALE behind it for the distances
    #[arg(long, value_name = "SETTINGS", value_parser = parse_lod)]
    lod: Option<LodChoice>,
    /// The camera that levels of detail are seen from [default: the middle of the scene, all around]
    #[arg(long, value_name = "NAME", requires = "lod", requires = "file")]
    camera: Option<String>,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    #[command(flatten)]
    backend: BackendFlags,
    /// Also write the figures to a file
    #[arg(short, long, value_name = "OUT.json")]
    out: Option<PathBuf>,
    /// Print the figures as JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Parses a share in per cent.
fn percent(text: &str) -> Result<f64, String> {
    let percent = text.parse::<f64>().ok().filter(|percent| (0.0..=100.0).contains(percent));
    percent.ok_or_else(|| "expected a number from 0 to 100".into())
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum MethodFlag {
    /// Surfels, emitters, sky and probes; packed matrices
    #[default]
    Hybrid,
    /// Probes alone, half floats, as published
    Paper,
}

/// Measures the stages of a frame.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    if let Some(out) = &flags.out {
        let inputs: Vec<_> = flags.file.iter().chain(&flags.setup).map(PathBuf::as_path).collect();
        output::check(out, &inputs)?;
    }
    let backend = flags.backend.open(console)?;
    let clock = StageClock::new(&backend)?;
    let mut report = BenchReport::new(&backend, &clock, flags.moving_lights);
    for scene in flags.scenes() {
        let LoadedScene { baked, mut lighting, name, view } = scene.load(flags.camera.as_deref())?;
        if flags.moving_lights && lighting.lights.is_empty() {
            console.note(format!("{name} has no lights that could move: a lamp and a sun were added"));
            lighting.lights = lamp_and_sun(&baked);
        }
        console.note(format!("measuring {name}, {} receivers", baked.receiver_texels.len()));
        let planning = flags.objects.map(|objects| planning_times(&baked, objects, flags.frames));
        for percent in &flags.active_grid {
            let still = LightShow {
                lighting: lighting.clone(),
                lod: flags.lod.as_ref().map(|lod| lod.settings.clone()).unwrap_or_default(),
                view,
                lights_move: false,
                frames: flags.frames as usize,
                active_share: percent / 100.0,
            };
            let measured = clock.measure(Arc::clone(&baked), &still)?;
            let moving = LightShow { lights_move: true, ..still };
            let moving =
                flags.moving_lights.then(|| clock.measure(Arc::clone(&baked), &moving)).transpose()?;
            let figures = SceneFigures::of(name.clone(), &baked);
            report.add(figures, &measured, moving.as_ref(), planning.as_deref());
            interrupt::check()?;
        }
    }
    ensure!(!report.is_empty(), "there is nothing to measure: name a file, --synthetic or --scaling");
    if let Some(out) = &flags.out {
        output::write_text(out, &serde_json::to_string_pretty(&report)?)?;
    }
    if flags.json { console::print_json(&report) } else { console::print(report.table()?.trim_end()) }
}

/// What to measure.
enum BenchScene<'a> {
    File { file: &'a Path, setup: Option<&'a Path> },
    Synthetic { size: SyntheticSize, method: MethodFlag },
}

/// A scene that is measured, with its light and who looks at it.
struct LoadedScene {
    baked: Arc<BakedScene>,
    lighting: Lighting,
    name: String,
    view: View,
}

/// A view from the middle of all clusters, all around.
fn middle(baked: &BakedScene) -> View {
    let bounds = bounds_of_clusters(baked);
    View { position: bounds.min.midpoint(bounds.max), ..View::default() }
}

impl Flags {
    fn scenes(&self) -> Vec<BenchScene<'_>> {
        let size = |receivers| match self.method {
            MethodFlag::Hybrid => SyntheticSize::hybrid(receivers),
            MethodFlag::Paper => SyntheticSize::paper(receivers),
        };
        let synthetic = |receivers| BenchScene::Synthetic { size: size(receivers), method: self.method };
        match &self.file {
            Some(file) => vec![BenchScene::File { file, setup: self.setup.as_deref() }],
            None if self.scaling => SCALING.into_iter().map(synthetic).collect(),
            None => self.synthetic.iter().map(|receivers| synthetic(*receivers as usize)).collect(),
        }
    }
}

impl BenchScene<'_> {
    /// Reads or makes it; `camera` is who looks at levels of detail.
    fn load(&self, camera: Option<&str>) -> anyhow::Result<LoadedScene> {
        match self {
            Self::File { file, setup } => {
                let baked = Arc::new(BakedScene::read(file)?);
                let setup = input::load_setup(*setup, &baked.scene)?;
                let view = match camera {
                    Some(name) => View::from(setup.camera(Some(name))?),
                    None => middle(&baked),
                };
                Ok(LoadedScene { baked, lighting: setup.lighting, name: file.display().to_string(), view })
            }
            Self::Synthetic { size, method } => {
                let name = format!("synthetic {method:?}").to_lowercase();
                let baked = Arc::new(BakedScene::new(synthetic_room(*size))?);
                let view = middle(&baked);
                Ok(LoadedScene { baked, lighting: synthetic_lighting(), name, view })
            }
        }
    }
}
