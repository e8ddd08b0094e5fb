//! `probelight eval-lod FILE --setup S.json --lod SETTINGS`
//!
//! ```text
//! mod.rs       flags
//! motion.rs    where the camera and the lights are in each frame
//! lod_duel.rs  two runtimes, with levels of detail and without, in turns
//! steps.rs     how much the light changes from frame to frame
//! report.rs    what is printed
//! ```

mod lod_duel;
mod motion;
mod report;
mod steps;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use probelight_asset::BakedScene;
use probelight_eval::ReferencePoints;
use probelight_scene::Setup;

use self::lod_duel::{LodDuel, Measurement};
use self::motion::{CameraMotion, LightMotion};
use self::report::Report;
use crate::console::{self, Console};
use crate::lod_flag::{LodChoice, parse_lod};
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight eval-lod room.plight --setup night.json
  probelight eval-lod room.plight --lod published published@0.5 published@0.25 --camera hall
  probelight eval-lod room.plight --lod medium mine.json --light still --json
  probelight eval-lod room.plight --lod low --hold-ssim 0.98
  probelight eval-lod room.plight --dolly 3 --turn 40 --pictures out/
  probelight eval-lod room.plight --setup night.json day.json --camera-path walk.json
  probelight eval-lod room.plight --setup night.json --points night.csv --lod medium low

SETTINGS is low, medium, high, exact, published, or a JSON file; @SCALE behind it multiplies all
distances. Two runtimes on the CPU get the same lights frame by frame, one with levels of detail
and one without, in turns; then both are looked at. Times are medians of the stages that compute
irradiance (all but light_surfels, which finds direct light when lamps move), and of whole frames.

\"step\" is how much more a receiver's light changes from one frame to the next with levels of
detail than without: the largest such excess of all receivers and frames, as a share of the mean
irradiance. It is what would be seen as a pop.";

/// Parses a similarity.
fn similarity(text: &str) -> Result<f64, String> {
    let similarity = text.parse::<f64>().ok().filter(|similarity| (0.0..=1.0).contains(similarity));
    similarity.ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Flags of `eval-lod`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Lights, sky and cameras, one after the other [default: those of the glTF file]
    #[arg(long, value_name = "S.json", num_args = 1..)]
    setup: Vec<PathBuf>,
    /// Reference irradiance at points for each setup: its error with and without levels of detail, after still light has
    /// bounced
    #[arg(long, value_name = "REF.csv", num_args = 1.., requires = "setup")]
    points: Vec<PathBuf>,
    /// Levels of detail to compare with none
    #[arg(long, value_name = "SETTINGS", num_args = 1.., value_parser = parse_lod,
          default_values = ["high", "medium", "low", "published"])]
    lod: Vec<LodChoice>,
    /// Move the levels to where they just keep this similarity (SSIM) to none
    #[arg(long, value_name = "SSIM", value_parser = similarity)]
    hold_ssim: Option<f64>,
    /// Cameras by name [default: all]
    #[arg(long, value_name = "NAME", num_args = 1.., conflicts_with = "camera_path")]
    camera: Vec<String>,
    /// One camera on a smooth way past the cameras of this setup file, in their order, over all frames
    #[arg(long, value_name = "PATH.json")]
    camera_path: Option<PathBuf>,
    /// How far the camera goes ahead over all frames, metres
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        conflicts_with = "camera_path"
    )]
    dolly: f32,
    /// How far it turns over all frames, degrees
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        conflicts_with = "camera_path"
    )]
    turn: f32,
    /// What the light does
    #[arg(long, value_enum, default_value_t)]
    light: LightMotion,
    /// Frames
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// Size of the pictures
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "320x240", value_parser = input::parse_size)]
    size: (u32, u32),
    /// Write the pictures with and without levels of detail, and their difference, into this folder
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

impl Flags {
    /// The cameras that look, each on its way.
    fn cameras(&self, setup: &Setup) -> anyhow::Result<Vec<CameraMotion>> {
        if let Some(file) = &self.camera_path {
            let path = input::load_camera_path(file, self.size)?;
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Ok(vec![CameraMotion::Past { name, path }]);
        }
        let names: Vec<Option<&str>> = match &self.camera[..] {
            [] => setup.cameras.iter().map(|camera| Some(camera.name.as_str())).collect(),
            names => names.iter().map(|name| Some(name.as_str())).collect(),
        };
        ensure!(!names.is_empty(), "there is no camera to look with: --setup gives some");
        let moved = |name| {
            let camera = input::choose_camera(setup, name, Some(self.size))?;
            Ok(CameraMotion::Ahead { camera, dolly: self.dolly, turn: self.turn })
        };
        names.into_iter().map(moved).collect()
    }

    /// All setups, each with its reference if there is one.
    fn setups(&self, baked: &BakedScene) -> anyhow::Result<Vec<(Setup, Option<ReferencePoints>)>> {
        let setups: Vec<Option<&Path>> = match &self.setup[..] {
            [] => vec![None],
            paths => paths.iter().map(|path| Some(path.as_path())).collect(),
        };
        ensure!(
            self.points.is_empty() || self.points.len() == self.setup.len(),
            "--points needs one table for each --setup: there are {} for {}",
            self.points.len(),
            self.setup.len()
        );
        let read = |(i, path): (usize, Option<&Path>)| -> anyhow::Result<_> {
            let reference = self.points.get(i).map(|points| ReferencePoints::read(points)).transpose()?;
            Ok((input::load_setup(path, &baked.scene)?, reference))
        };
        setups.into_iter().enumerate().map(read).collect()
    }
}

/// Compares levels of detail with none.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    if let Some(folder) = &flags.pictures {
        output::create_folder(folder)?;
    }
    let baked = Arc::new(BakedScene::read(&flags.file)?);
    let mut duel = LodDuel::new(Arc::clone(&baked));
    let mut rows = Vec::new();
    for (setup, reference) in &flags.setups(&baked)? {
        for camera in &flags.cameras(setup)? {
            let measurement = Measurement {
                setup,
                reference: reference.as_ref(),
                camera,
                light: flags.light,
                frames: flags.frames as usize,
                pictures: flags.pictures.as_deref(),
            };
            for lod in &flags.lod {
                console.note(format!("measuring {} from {} under {}", lod.name, camera.name(), setup.name));
                rows.push(
                    match flags.hold_ssim {
                        Some(least) => duel.held_row(lod, least, &measurement, console),
                        None => duel.row(lod, &measurement, console),
                    }
                    .with_context(|| format!("levels of detail {:?}", lod.name))?,
                );
                interrupt::check()?;
            }
        }
    }
    let report = Report { file: flags.file.clone(), frames: flags.frames, light: flags.light.name(), rows };
    if flags.json { console::print_json(&report) } else { console::print(report.tables()?.trim_end()) }
}
