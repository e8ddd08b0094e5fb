//! `probelight bake SCENE -o OUT.plight`

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use probelight_asset::{BakedInfo, BakedScene};
use probelight_bake::BakeOptions;
use serde::Serialize;

use crate::bake_settings::SettingFlags;
use crate::commands::info;
use crate::console::{self, Console};
use crate::matrix_figures::MatrixFigures;
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight bake room.glb -o room.plight
  probelight bake room.glb -o room.plight --quality preview       a quick try
  probelight bake hall.glb -o hall.plight --quality high          slow and fine
  probelight bake hall.glb -o hall.plight --error 0.01            closer to the uncompressed light
  probelight bake hall.glb -o hall.plight --surfel-size 0.2       for small patches of sun
  probelight bake hall.glb -o hall.plight --method paper          the published method
  probelight bake hall.glb -o hall.plight --resume                go on after Ctrl-C

`probelight info --json OUT.plight` prints all settings that a file was baked with, defaults
included.

While it runs, finished parts are kept in OUT.plight.partial; the file disappears at the end. The
result depends on the scene and the settings only, not on threads or interruptions.";

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
        let checkpoint = checkpoint_path(&self.out);
        let Self { scene, out, resume, json, settings } = self;
        Ok(Settings { scene, output: out, checkpoint, resume, json, options: settings.into() })
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
    matrices: MatrixFigures,
}

/// Bakes a scene.
pub(crate) fn run(flags: Flags, console: &Console) -> anyhow::Result<()> {
    let settings = flags.resolve()?;
    let scene = input::load_scene(&settings.scene, console)?;
    if !settings.resume {
        probelight_bake::discard_checkpoint(&settings.checkpoint)?;
    } else if !settings.checkpoint.exists() {
        console.note("there is no interrupted bake to resume; starting from the beginning");
    }
    let start = Instant::now();
    let baked = probelight_bake::bake(scene, &settings.options, Some(&settings.checkpoint), console);
    console.clear_progress();
    let baked = baked.inspect_err(|_| note_checkpoint(&settings, console))?;
    baked.write(&settings.output)?;
    let info = BakedScene::read_info(&settings.output)?;
    let matrices = MatrixFigures::of(&baked);
    let seconds = start.elapsed().as_secs_f64();
    if settings.json {
        return console::print_json(&Report { output: &settings.output, seconds, info, matrices });
    }
    console.note(format!("wrote {} in {seconds:.1} s", settings.output.display()));
    console.note(info::describe(&info, &matrices)?.trim_end());
    Ok(())
}

fn note_checkpoint(settings: &Settings, console: &Console) {
    if interrupt::is_requested() && settings.checkpoint.exists() {
        console.note(format!(
            "what is finished is kept in {}; the same command with --resume goes on from there",
            settings.checkpoint.display()
        ));
    }
}
