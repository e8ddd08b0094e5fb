//! `probelight bake SCENE -o OUT.plight`

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use probelight_asset::{BakedInfo, BakedScene};
use probelight_bake::BakeOptions;
use serde::Serialize;

use crate::commands::info;
use crate::console::{self, Console};
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight bake room.glb -o room.plight
  probelight bake room.glb -o room.plight --receivers 40000 --rays 256     a quick try
  probelight bake hall.glb -o hall.plight --texel-density 8 --rays 4096    slow and fine
  probelight bake hall.glb -o hall.plight --resume                         go on after Ctrl-C

`probelight info --json OUT.plight` prints all settings that a file was baked with, defaults included.

While it runs, finished parts are kept in OUT.plight.partial; the file disappears at the end. The result
depends on the scene and the settings only, not on threads or interruptions.";

/// Flags of `bake`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// Scene to bake (.glb or .gltf)
    scene: PathBuf,
    /// The baked file to write (.plight)
    #[arg(short, long, value_name = "OUT.plight")]
    out: PathBuf,
    /// Go on with an interrupted bake of the same scene with the same settings
    #[arg(long)]
    resume: bool,
    /// Print the report as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    settings: SettingFlags,
}

/// What is baked, and how finely.
#[derive(Args)]
#[command(next_help_heading = "Settings")]
struct SettingFlags {
    /// Wanted number of receivers: lightmap texels with light of their own
    /// [default: from the scene's scale, with an upper limit]
    #[arg(long, value_name = "N", conflicts_with = "texel_density")]
    receivers: Option<u32>,
    /// Lightmap texels per metre, instead of --receivers
    #[arg(long, value_name = "T")]
    texel_density: Option<f32>,
    /// Probes per cubic metre of open space [default: adapted to the scene, at least 0.02]
    #[arg(long, value_name = "D")]
    probe_density: Option<f32>,
    /// Gather rays per receiver: less noise in the light, longer bake
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// Relight rays per probe: finer light at each frame's cost [default: 512]
    #[arg(long, value_name = "N")]
    relight_rays: Option<u32>,
    /// Highest spherical-harmonics band of the probes, 0 to 11 [default: 7]
    #[arg(long, value_name = "L")]
    sh_degree: Option<u32>,
    /// Most singular values kept per cluster: larger file, less error [default: 32]
    #[arg(long, value_name = "K")]
    max_rank: Option<u32>,
    /// Relative truncation error allowed per cluster; singular values are kept, and large clusters split,
    /// until it is reached
    #[arg(long, value_name = "E")]
    max_cluster_error: Option<f32>,
    /// Most probes a cluster draws on; up to twice as many where rays end unseen by them [default: 10]
    #[arg(long, value_name = "P")]
    probes_per_cluster: Option<u32>,
    /// Most receivers of a cluster [default: 256]
    #[arg(long, value_name = "R")]
    receivers_per_cluster: Option<u32>,
    /// Lay the lightmap out by the scene's second texture coordinates where they are valid
    #[arg(long)]
    use_uv1: bool,
    /// Seed of all random numbers [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

/// What a bake needs to know, checked.
struct Settings {
    scene: PathBuf,
    output: PathBuf,
    checkpoint: PathBuf,
    resume: bool,
    json: bool,
    options: BakeOptions,
}

impl Flags {
    fn resolve(self) -> anyhow::Result<Settings> {
        output::check(&self.out, &[&self.scene])?;
        let flags = self.settings;
        let options = BakeOptions {
            receivers: flags.receivers,
            texels_per_meter: flags.texel_density,
            probe_density: flags.probe_density,
            gather_rays: flags.rays,
            relight_rays: flags.relight_rays,
            sh_degree: flags.sh_degree,
            max_rank: flags.max_rank,
            max_cluster_error: flags.max_cluster_error,
            probes_per_cluster: flags.probes_per_cluster,
            receivers_per_cluster: flags.receivers_per_cluster,
            use_uv1: flags.use_uv1,
            seed: flags.seed,
        };
        let checkpoint = checkpoint_path(&self.out);
        let Self { scene, out, resume, json, .. } = self;
        Ok(Settings { scene, output: out, checkpoint, resume, json, options })
    }
}

/// Where an unfinished bake of `output` is kept.
fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

/// What `bake --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    output: &'a Path,
    seconds: f64,
    #[serde(flatten)]
    info: BakedInfo,
}

/// Bakes a scene.
pub(crate) fn run(flags: Flags, console: &Console) -> anyhow::Result<()> {
    let settings = flags.resolve()?;
    let scene = input::load_scene(&settings.scene, console)?;
    if !settings.resume {
        forget(&settings.checkpoint)?;
    } else if !settings.checkpoint.exists() {
        console.note("there is no interrupted bake to resume; starting from the beginning");
    }
    let start = Instant::now();
    let baked = probelight_bake::bake(scene, &settings.options, Some(&settings.checkpoint), console);
    console.clear_progress();
    let baked = baked.inspect_err(|_| note_checkpoint(&settings, console))?;
    baked.write(&settings.output)?;
    let info = BakedScene::read_info(&settings.output)?;
    let seconds = start.elapsed().as_secs_f64();
    if settings.json {
        return console::print_json(&Report { output: &settings.output, seconds, info });
    }
    console.note(format!("wrote {} in {seconds:.1} s", settings.output.display()));
    console.note(info::describe(&info)?.trim_end());
    Ok(())
}

/// Removes what an earlier, interrupted bake has left.
fn forget(checkpoint: &Path) -> anyhow::Result<()> {
    match std::fs::remove_file(checkpoint) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", checkpoint.display()))
        }
        _ => Ok(()),
    }
}

fn note_checkpoint(settings: &Settings, console: &Console) {
    if interrupt::is_requested() && settings.checkpoint.exists() {
        console.note(format!(
            "what is finished is kept in {}; the same command with --resume goes on from there",
            settings.checkpoint.display()
        ));
    }
}
