//! Two runtimes of one scene, with levels of detail and without, in turns.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use probelight_asset::BakedScene;
use probelight_eval::{PointErrors, PointSelection, ReferencePoints, flip, ssim};
use probelight_math::glam::Vec3;
use probelight_render::comparison::difference;
use probelight_render::{Exposure, PixelFilter, RenderOptions, RenderOutput, ToneMap, View, render};
use probelight_runtime::{FrameInput, FramePlan, Runtime, SimilaritySearch, Stage, StageTimings};
use probelight_scene::{Camera, Setup};

use super::motion::{CameraMotion, LightMotion};
use super::report::{Row, Work};
use super::steps::LightSteps;
use crate::console::Console;
use crate::lod_flag::LodChoice;
use crate::output::image_view;

/// Largest change of the light before the first frame, and how many frames it may take.
const SETTLED: (f64, usize) = (1e-3, 100);

/// Frames in which the levels come to where the camera is, before the first that counts; and in which still light bounces
/// with them.
const ARRIVAL: usize = 8;
const BOUNCES: usize = 64;

/// How much differences are amplified in pictures.
const GAIN: f32 = 8.0;

/// What the two runtimes show, and what of it is measured.
pub(super) struct Measurement<'a> {
    pub(super) setup: &'a Setup,
    pub(super) reference: Option<&'a ReferencePoints>,
    pub(super) camera: &'a CameraMotion,
    pub(super) light: LightMotion,
    pub(super) frames: usize,
    /// The folder for pictures.
    pub(super) pictures: Option<&'a Path>,
}

/// A scene with and without levels of detail.
pub(super) struct LodDuel {
    exact: Runtime,
    with_lod: Runtime,
}

/// What is added up from frame to frame.
#[derive(Default)]
struct Frames {
    exact: Vec<StageTimings>,
    with_lod: Vec<StageTimings>,
    receivers: u64,
    probes: usize,
    coefficients: usize,
    bytes: u64,
    steps: LightSteps,
}

impl LodDuel {
    pub(super) fn new(baked: Arc<BakedScene>) -> Self {
        Self { exact: Runtime::new(Arc::clone(&baked)), with_lod: Runtime::new(baked) }
    }

    /// The row of the same levels as near as pictures stay so similar, found by bisection.
    pub(super) fn held_row(
        &mut self,
        lod: &LodChoice,
        least: f64,
        measurement: &Measurement<'_>,
        console: &Console,
    ) -> anyhow::Result<Row> {
        let scaled = |scale: f32| LodChoice {
            name: format!("{}@{scale:.2}", lod.name),
            settings: lod.settings.clone().with_distances_scaled(scale),
        };
        let mut search = SimilaritySearch::new(least);
        let mut held = None;
        while let Some(scale) = search.scale() {
            let row = self.row(&scaled(scale), measurement, console)?;
            // The first is the best there is, if none is good enough.
            if search.note(row.ssim) || held.is_none() {
                held = Some(row);
            }
        }
        held.context("no levels were tried")
    }

    /// Measures one kind of levels.
    pub(super) fn row(
        &mut self,
        lod: &LodChoice,
        measurement: &Measurement<'_>,
        console: &Console,
    ) -> anyhow::Result<Row> {
        self.arrive(lod, measurement)?;
        let frames = self.frames(measurement)?;
        let seen = measurement.camera.at((measurement.frames - 1) as f32 / measurement.frames as f32);
        let [ssim, flip] = self.similarity(lod, measurement, &seen, console)?;
        let [rmse, rmse_all] = match measurement.reference {
            Some(reference) => self.errors(measurement, reference, &seen)?,
            None => [None, None],
        };
        let [ms, ms_all] =
            [&frames.with_lod, &frames.exact].map(|timings| median_ms(timings, irradiance_time));
        let [frame_ms, frame_ms_all] =
            [&frames.with_lod, &frames.exact].map(|timings| median_ms(timings, |timings| timings.frame));
        let [largest_change, largest_change_all] = frames.steps.largest();
        Ok(Row {
            lod: lod.name.clone(),
            setup: measurement.setup.name.clone(),
            camera: measurement.camera.name().to_owned(),
            work: frames.work(self.exact.work(), self.exact.baked()),
            ms,
            ms_all,
            speedup: ms_all / ms,
            frame_ms,
            frame_ms_all,
            frame_speedup: frame_ms_all / frame_ms,
            stages_ms: stages_ms(&frames.with_lod),
            stages_ms_all: stages_ms(&frames.exact),
            step: frames.steps.largest_excess(),
            largest_change,
            largest_change_all,
            ssim,
            flip,
            rmse,
            rmse_all,
        })
    }

    /// Light that has bounced, and levels as the camera wants them where it begins.
    fn arrive(&mut self, lod: &LodChoice, measurement: &Measurement<'_>) -> anyhow::Result<()> {
        self.with_lod.set_lod(lod.settings.clone())?;
        for runtime in [&mut self.exact, &mut self.with_lod] {
            runtime.set_lighting(measurement.setup.lighting.clone())?;
            runtime.converge(SETTLED.0, SETTLED.1);
        }
        for _ in 0..ARRIVAL {
            self.step(&measurement.camera.at(0.0));
        }
        Ok(())
    }

    /// A frame of both.
    fn step(&mut self, seen: &Camera) -> [StageTimings; 2] {
        let exact = self.exact.step(&FrameInput::default());
        let input = FrameInput { view: Some(seen.into()), ..FrameInput::default() };
        [self.with_lod.step(&input), exact]
    }

    fn frames(&mut self, measurement: &Measurement<'_>) -> anyhow::Result<Frames> {
        let mut frames = Frames::default();
        for frame in 0..measurement.frames {
            if measurement.light == LightMotion::Moving {
                let lighting = measurement.light.at(&measurement.setup.lighting, frame);
                self.exact.set_lighting(lighting.clone())?;
                self.with_lod.set_lighting(lighting)?;
            }
            let timings = self.step(&measurement.camera.at(frame as f32 / measurement.frames as f32));
            frames.note(timings, self.with_lod.work(), self.with_lod.baked());
            frames.steps.note([self.with_lod.receiver_irradiance(), self.exact.receiver_irradiance()]);
        }
        Ok(frames)
    }

    /// SSIM and FLIP of the two pictures as a screen shows them.
    fn similarity(
        &self,
        lod: &LodChoice,
        measurement: &Measurement<'_>,
        camera: &Camera,
        console: &Console,
    ) -> anyhow::Result<[f64; 2]> {
        let options = RenderOptions { output: RenderOutput::Full, samples: 8, filter: PixelFilter::Box };
        let picture = |runtime| render(View::of(runtime), camera, &options, console);
        let (with_lod, exact) = (picture(&self.with_lod)?, picture(&self.exact)?);
        let tone_map = ToneMap::new(Exposure::Automatic, &exact);
        if let Some(folder) = measurement.pictures {
            let name = measurement.camera.name();
            let file = |what: &str| folder.join(format!("{name}-{}-{what}.png", lod.name.replace('/', "-")));
            tone_map.apply(&with_lod).write_png(&file("lod"))?;
            tone_map.apply(&exact).write_png(&file("exact"))?;
            difference(&with_lod, &exact, tone_map, GAIN).write_png(&file("difference"))?;
        }
        let [with_lod, exact] = [with_lod, exact].map(|image| tone_map.display_from_image(&image));
        let (a, b) = (image_view(&with_lod)?, image_view(&exact)?);
        Ok([ssim(&a, &b)?, flip(&a, &b)?])
    }

    /// Relative RMSE of both under the setup's own light, which stands still until it has bounced.
    fn errors(
        &mut self,
        measurement: &Measurement<'_>,
        reference: &ReferencePoints,
        seen: &Camera,
    ) -> anyhow::Result<[Option<f64>; 2]> {
        for runtime in [&mut self.exact, &mut self.with_lod] {
            runtime.set_lighting(measurement.setup.lighting.clone())?;
        }
        for _ in 0..BOUNCES {
            self.step(seen);
        }
        let error = |runtime: &Runtime| -> anyhow::Result<Option<f64>> {
            let predictions: Vec<Option<Vec3>> = reference
                .points
                .iter()
                .map(|point| runtime.irradiance_at(point.position, point.normal))
                .collect();
            Ok(PointErrors::measure(reference, &predictions, &PointSelection::default())?.relative_rmse)
        };
        Ok([error(&self.with_lod)?, error(&self.exact)?])
    }
}

impl Frames {
    fn note(&mut self, [with_lod, exact]: [StageTimings; 2], work: &FramePlan, baked: &BakedScene) {
        self.with_lod.push(with_lod);
        self.exact.push(exact);
        self.receivers += work.receivers();
        self.probes += work.relit_probes();
        self.coefficients += work.coefficients();
        self.bytes += work.matrix_bytes(baked);
    }

    fn work(&self, all: &FramePlan, baked: &BakedScene) -> Work {
        let mean = |sum: f64| sum / self.exact.len() as f64;
        Work {
            receivers: mean(self.receivers as f64),
            receivers_all: all.receivers(),
            probes: mean(self.probes as f64),
            probes_all: all.relit_probes(),
            coefficients: mean(self.coefficients as f64),
            coefficients_all: all.coefficients(),
            bytes: mean(self.bytes as f64),
            bytes_all: all.matrix_bytes(baked),
        }
    }
}

/// Time of all stages but the first.
fn irradiance_time(timings: &StageTimings) -> Duration {
    timings.stages.values().iter().sum::<Duration>() - timings.stages[Stage::LightSurfels]
}

fn stages_ms(timings: &[StageTimings]) -> BTreeMap<&'static str, f64> {
    Stage::ALL
        .iter()
        .map(|stage| (stage.name(), median_ms(timings, |timings| timings.stages[*stage])))
        .collect()
}

fn median_ms(timings: &[StageTimings], of: impl Fn(&StageTimings) -> Duration) -> f64 {
    let mut times: Vec<Duration> = timings.iter().map(of).collect();
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}
