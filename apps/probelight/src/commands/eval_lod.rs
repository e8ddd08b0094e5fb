//! `probelight eval-lod FILE --setup S.json --lod SETTINGS`

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, ensure};
use clap::Args;
use probelight_asset::BakedScene;
use probelight_eval::{flip, ssim};
use probelight_math::glam::Quat;
use probelight_render::comparison::difference;
use probelight_render::{Exposure, PixelFilter, RenderOptions, RenderOutput, ToneMap, View, render};
use probelight_runtime::{FrameInput, Runtime, SimilaritySearch, Stage, StageTimings};
use probelight_scene::{Camera, Light, Lighting};
use serde::Serialize;

use crate::console::{self, Console};
use crate::lod_flag::{LodChoice, parse_lod};
use crate::output::image_view;
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight eval-lod room.plight --setup night.json
  probelight eval-lod room.plight --lod published published@0.5 published@0.25 --camera hall
  probelight eval-lod room.plight --lod medium mine.json --light still --json
  probelight eval-lod room.plight --lod low --hold-ssim 0.98
  probelight eval-lod room.plight --dolly 3 --turn 40 --pictures out/

SETTINGS is low, medium, high, exact, published, or a JSON file; @SCALE behind it multiplies all
distances. Two runtimes on the CPU get the same lights frame by frame, one with levels of detail
and one without, in turns; then both are looked at. Times are medians of the stages that compute
irradiance (all but light_surfels, which traces shadow rays when lamps move).";

/// How far lamps go from one frame to the next, metres.
const LAMP_STEP: f32 = 0.02;

/// How far suns go, radians.
const SUN_STEP: f32 = 0.002;

/// Frames after which lights turn back.
const SWING: usize = 20;

/// Largest change of the light before the first frame, and how many frames it may take.
const SETTLED: (f64, usize) = (1e-3, 100);

/// How much differences are amplified in pictures.
const GAIN: f32 = 8.0;

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
    /// Lights, sky and cameras [default: those of the glTF file]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    /// Levels of detail to compare with none
    #[arg(long, value_name = "SETTINGS", num_args = 1.., value_parser = parse_lod,
          default_values = ["high", "medium", "low", "published"])]
    lod: Vec<LodChoice>,
    /// Move the levels to where they just keep this similarity (SSIM) to none
    #[arg(long, value_name = "SSIM", value_parser = similarity)]
    hold_ssim: Option<f64>,
    /// Cameras by name [default: all]
    #[arg(long, value_name = "NAME", num_args = 1..)]
    camera: Vec<String>,
    /// How far the camera goes ahead over all frames, metres
    #[arg(long, value_name = "METRES", default_value_t = 0.0, allow_negative_numbers = true)]
    dolly: f32,
    /// How far it turns over all frames, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
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
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum LightMotion {
    /// Lamps and suns move a little with each frame
    #[default]
    Moving,
    /// Nothing changes: frames after all light has bounced
    Still,
}

/// What `eval-lod --json` prints.
#[derive(Serialize)]
struct Report {
    file: PathBuf,
    frames: u32,
    light: &'static str,
    rows: Vec<Row>,
}

/// One kind of levels of detail seen by one camera.
#[derive(Serialize)]
struct Row {
    lod: String,
    camera: String,
    /// Receivers that a frame computes on average.
    receivers: f64,
    receivers_all: u64,
    /// Bytes of transport matrices that a frame reads on average.
    bytes: f64,
    bytes_all: u64,
    /// Median time of the stages that compute irradiance.
    ms: f64,
    ms_all: f64,
    /// `ms_all` / `ms`.
    speedup: f64,
    /// Median time of whole frames.
    frame_ms: f64,
    frame_ms_all: f64,
    /// Similarity of the pictures after the last frame.
    ssim: f64,
    flip: f64,
}

/// Compares levels of detail with none.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    if let Some(folder) = &flags.pictures {
        output::create_folder(folder)?;
    }
    let baked = Arc::new(BakedScene::read(&flags.file)?);
    let setup = input::load_setup(flags.setup.as_deref(), &baked.scene)?;
    let names: Vec<Option<&str>> = match &flags.camera[..] {
        [] => setup.cameras.iter().map(|camera| Some(camera.name.as_str())).collect(),
        names => names.iter().map(|name| Some(name.as_str())).collect(),
    };
    ensure!(!names.is_empty(), "there is no camera to look with: --setup gives some");
    let mut bench = LodBench {
        exact: Runtime::new(Arc::clone(&baked)),
        with_lod: Runtime::new(baked),
        lighting: setup.lighting.clone(),
        flags,
    };
    let mut rows = Vec::new();
    for name in names {
        let camera = input::choose_camera(&setup, name, Some(flags.size))?;
        for lod in &flags.lod {
            console.note(format!("measuring {} from {}", lod.name, camera.name));
            rows.push(match flags.hold_ssim {
                Some(least) => bench.held_row(lod, least, &camera, console)?,
                None => bench.row(lod, &camera, console)?,
            });
            interrupt::check()?;
        }
    }
    let light = if flags.light == LightMotion::Still { "still" } else { "moving" };
    let report = Report { file: flags.file.clone(), frames: flags.frames, light, rows };
    if flags.json { console::print_json(&report) } else { console::print(table(&report)?.trim_end()) }
}

/// A scene with and without levels of detail.
struct LodBench<'a> {
    exact: Runtime,
    with_lod: Runtime,
    lighting: Lighting,
    flags: &'a Flags,
}

impl LodBench<'_> {
    /// The row of the same levels as near as pictures stay so similar, found by bisection.
    fn held_row(
        &mut self,
        lod: &LodChoice,
        least: f64,
        camera: &Camera,
        console: &Console,
    ) -> anyhow::Result<Row> {
        let scaled = |scale: f32| LodChoice {
            name: format!("{}@{scale:.2}", lod.name),
            settings: lod.settings.clone().with_distances_scaled(scale),
        };
        let mut search = SimilaritySearch::new(least);
        let mut held = None;
        while let Some(scale) = search.scale() {
            let row = self.row(&scaled(scale), camera, console)?;
            // The first is the best there is, if none is good enough.
            if search.note(row.ssim) || held.is_none() {
                held = Some(row);
            }
        }
        held.context("no levels were tried")
    }

    fn row(&mut self, lod: &LodChoice, camera: &Camera, console: &Console) -> anyhow::Result<Row> {
        self.with_lod.set_lod(lod.settings.clone())?;
        for runtime in [&mut self.exact, &mut self.with_lod] {
            runtime.set_lighting(self.lighting.clone())?;
            runtime.converge(SETTLED.0, SETTLED.1);
        }
        let frames = self.flags.frames as usize;
        let (mut exact, mut with_lod) = (Vec::new(), Vec::new());
        let (mut receivers, mut bytes) = (0u64, 0u64);
        let mut seen = camera.clone();
        for frame in 0..frames {
            seen = moved(camera, self.flags, frame as f32 / frames as f32);
            if self.flags.light == LightMotion::Moving {
                let lighting = swung(&self.lighting, frame);
                self.exact.set_lighting(lighting.clone())?;
                self.with_lod.set_lighting(lighting)?;
            }
            exact.push(self.exact.step(&FrameInput::default()));
            with_lod.push(
                self.with_lod.step(&FrameInput { view: Some((&seen).into()), ..FrameInput::default() }),
            );
            receivers += self.with_lod.work().receivers();
            bytes += self.with_lod.work().matrix_bytes(self.with_lod.baked());
        }
        let [ssim, flip] = self.similarity(lod, &seen, console)?;
        let (ms, ms_all) = (median_ms(&with_lod, irradiance_time), median_ms(&exact, irradiance_time));
        Ok(Row {
            lod: lod.name.clone(),
            camera: camera.name.clone(),
            receivers: receivers as f64 / frames as f64,
            receivers_all: self.exact.work().receivers(),
            bytes: bytes as f64 / frames as f64,
            bytes_all: self.exact.work().matrix_bytes(self.exact.baked()),
            ms,
            ms_all,
            speedup: ms_all / ms,
            frame_ms: median_ms(&with_lod, |timings| timings.frame),
            frame_ms_all: median_ms(&exact, |timings| timings.frame),
            ssim,
            flip,
        })
    }

    /// SSIM and FLIP of the two pictures as a screen shows them.
    fn similarity(&self, lod: &LodChoice, camera: &Camera, console: &Console) -> anyhow::Result<[f64; 2]> {
        let options = RenderOptions { output: RenderOutput::Full, samples: 8, filter: PixelFilter::Box };
        let picture = |runtime| render(View::of(runtime), camera, &options, console);
        let (with_lod, exact) = (picture(&self.with_lod)?, picture(&self.exact)?);
        let tone_map = ToneMap::new(Exposure::Automatic, &exact);
        if let Some(folder) = &self.flags.pictures {
            let file = |what: &str| {
                folder.join(format!("{}-{}-{what}.png", camera.name, lod.name.replace('/', "-")))
            };
            tone_map.apply(&with_lod).write_png(&file("lod"))?;
            tone_map.apply(&exact).write_png(&file("exact"))?;
            difference(&with_lod, &exact, tone_map, GAIN).write_png(&file("difference"))?;
        }
        let [with_lod, exact] = [with_lod, exact].map(|image| tone_map.display_from_image(&image));
        let (a, b) = (image_view(&with_lod)?, image_view(&exact)?);
        Ok([ssim(&a, &b)?, flip(&a, &b)?])
    }
}

/// Where the camera is when a share of the frames has gone by.
fn moved(camera: &Camera, flags: &Flags, share: f32) -> Camera {
    let ahead = camera.target - camera.position;
    let position = camera.position + ahead.normalize() * flags.dolly * share;
    let turned = Quat::from_axis_angle(camera.up.normalize(), (flags.turn * share).to_radians()) * ahead;
    Camera { position, target: position + turned, ..camera.clone() }
}

/// The lights of a frame: on their way there and back.
fn swung(lighting: &Lighting, frame: usize) -> Lighting {
    let phase = (frame + 1) % (2 * SWING);
    let steps = phase.min(2 * SWING - phase) as f32;
    let mut lighting = lighting.clone();
    for light in &mut lighting.lights {
        match light {
            Light::Point { position, .. } | Light::Spot { position, .. } => position.x += LAMP_STEP * steps,
            Light::Directional { direction, .. } => {
                *direction = Quat::from_rotation_y(SUN_STEP * steps) * *direction;
            }
        }
    }
    lighting
}

/// Time of all stages but the first.
fn irradiance_time(timings: &StageTimings) -> Duration {
    timings.stages.values().iter().sum::<Duration>() - timings.stages[Stage::LightSurfels]
}

fn median_ms(timings: &[StageTimings], of: impl Fn(&StageTimings) -> Duration) -> f64 {
    let mut times: Vec<Duration> = timings.iter().map(of).collect();
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

fn table(report: &Report) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(
        text,
        "{} frames, light {}; without levels of detail behind each slash",
        report.frames, report.light
    )?;
    writeln!(
        text,
        "{:<18}{:<10}{:>19}{:>15}{:>15}{:>9}{:>17}{:>8}{:>8}",
        "levels of detail", "camera", "receivers", "MB", "ms", "speedup", "frame ms", "SSIM", "FLIP"
    )?;
    for row in &report.rows {
        let pair = |with: f64, all: f64, digits: usize| format!("{with:.digits$} / {all:.digits$}");
        writeln!(
            text,
            "{:<18}{:<10}{:>19}{:>15}{:>15}{:>9.2}{:>17}{:>8.4}{:>8.4}",
            row.lod,
            row.camera,
            pair(row.receivers, row.receivers_all as f64, 0),
            pair(row.bytes * 1e-6, row.bytes_all as f64 * 1e-6, 2),
            pair(row.ms, row.ms_all, 2),
            row.speedup,
            pair(row.frame_ms, row.frame_ms_all, 2),
            row.ssim,
            row.flip
        )?;
    }
    writeln!(
        text,
        "published: 135452 / 512026 receivers, 1.25 / 1.99 ms, speedup 1.60; 217911 receivers, 1.43 ms, 1.39"
    )?;
    writeln!(text, "published, the fastest of six settings: speedup 4.34 at SSIM 0.972")?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::glam::Vec3;

    #[test]
    fn lights_swing_there_and_back() {
        let lamp = Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE, range: None };
        let lighting = Lighting { lights: vec![lamp], ..Lighting::default() };
        let x = |frame| match swung(&lighting, frame).lights[0] {
            Light::Point { position, .. } => position.x,
            _ => f32::NAN,
        };
        assert_eq!(x(0), LAMP_STEP);
        assert!((x(SWING - 1) - SWING as f32 * LAMP_STEP).abs() < 1e-6);
        assert_eq!(x(2 * SWING - 1), 0.0);
        let all_move = (0..100).all(|frame| (x(frame + 1) - x(frame)).abs() > 0.9 * LAMP_STEP);
        assert!(all_move, "light changes with each frame");
    }
}
