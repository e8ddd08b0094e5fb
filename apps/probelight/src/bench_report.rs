//! What `bench` prints and writes.

use std::fmt::Write;
use std::time::Duration;

use probelight_asset::BakedScene;
use serde::Serialize;

use crate::backend::Backend;
use crate::stage_clock::{MeasuredFrames, MeasuredStage, StageClock};

/// \[SED\] Table 2 without levels of detail: 1.99 ms for 512,026 receivers on a card of 336 GB/s.
const PUBLISHED_BYTES_PER_RECEIVER: f64 = 1.99e-3 * 336e9 / 512_026.0;

/// All figures of one run.
#[derive(Serialize)]
pub(crate) struct BenchReport {
    version: &'static str,
    device: String,
    /// Whether the "GPU" is a driver that computes on the CPU.
    is_software: bool,
    driver: String,
    threads: usize,
    /// Whether lights changed with each frame.
    lights_move: bool,
    /// Gigabytes per second that a copy reads and writes.
    copy_gb_per_s: f64,
    scenes: Vec<SceneReport>,
}

/// What was measured on one scene.
#[derive(Serialize)]
struct SceneReport {
    #[serde(flatten)]
    scene: SceneFigures,
    /// The share of the grid's vertices that frames computed.
    active_share: f64,
    /// With `--moving-lights` those of frames in which lights move.
    stages: Vec<StageReport>,
    frame: StageReport,
    /// A frame in which nothing but bounced light changes, if `frame` is another.
    #[serde(skip_serializing_if = "Option::is_none")]
    still_frame: Option<StageReport>,
    /// What the CPU takes to plan a frame with `--objects`.
    #[serde(skip_serializing_if = "Option::is_none")]
    planning_ms: Option<f64>,
    /// How many times fewer bytes per receiver a copy would move in the time of a frame than the published
    /// implementation's card could: the ratio of the times if both had the same memory.
    times_published_at_same_bandwidth: f64,
}

/// How large a scene is.
#[derive(Serialize)]
pub(crate) struct SceneFigures {
    scene: String,
    receivers: usize,
    clusters: usize,
    probes: usize,
    surfels: usize,
    light_samples: usize,
    matrix_bytes_per_receiver: f64,
    grid_vertices: usize,
}

#[derive(Serialize)]
struct StageReport {
    name: &'static str,
    frames: usize,
    median_ms: f64,
    shortest_ms: f64,
    /// Bytes that must move: each input once, each output once.
    bytes: u64,
    gb_per_s: f64,
    /// Share of the bandwidth of a copy.
    of_copy: f64,
}

impl SceneFigures {
    pub(crate) fn of(scene: String, baked: &BakedScene) -> Self {
        Self {
            scene,
            receivers: baked.receiver_texels.len(),
            clusters: baked.clusters.len(),
            probes: baked.probes.len(),
            surfels: baked.surfels.len(),
            light_samples: baked.light_samples.len(),
            matrix_bytes_per_receiver: baked.matrix_bytes_per_receiver(),
            grid_vertices: baked.grid_vertices.len(),
        }
    }
}

/// The middle one of sorted times.
fn median(times: &[Duration]) -> Duration {
    times.get(times.len() / 2).copied().unwrap_or_default()
}

impl StageReport {
    fn new(stage: &MeasuredStage, copy_bandwidth: f64) -> Self {
        let median = median(&stage.times);
        let shortest = stage.times.first().copied().unwrap_or_default();
        // A stage may be shorter than the clock's tick.
        let seconds = median.max(Duration::from_nanos(1)).as_secs_f64();
        let bytes_per_second = stage.bytes as f64 / seconds;
        Self {
            name: stage.name,
            frames: stage.times.len(),
            median_ms: median.as_secs_f64() * 1e3,
            shortest_ms: shortest.as_secs_f64() * 1e3,
            bytes: stage.bytes,
            gb_per_s: bytes_per_second * 1e-9,
            of_copy: bytes_per_second / copy_bandwidth,
        }
    }
}

impl BenchReport {
    pub(crate) fn new(backend: &Backend, clock: &StageClock, lights_move: bool) -> Self {
        let (is_software, driver) = match backend {
            Backend::Cpu => (false, String::new()),
            Backend::Gpu(gpu) => (gpu.is_software(), format!("{} {}", gpu.info.driver, gpu.info.driver_info)),
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            device: backend.describe(),
            is_software,
            driver,
            threads: rayon::current_num_threads(),
            lights_move,
            copy_gb_per_s: clock.copy_bandwidth * 1e-9,
            scenes: Vec::new(),
        }
    }

    /// Adds what was measured on a scene, and how long the CPU planned such frames, shortest first.
    pub(crate) fn add(
        &mut self,
        scene: SceneFigures,
        still: &MeasuredFrames,
        moving: Option<&MeasuredFrames>,
        planning: Option<&[Duration]>,
    ) {
        let copy_bandwidth = self.copy_gb_per_s * 1e9;
        let report = |stage: &MeasuredStage| StageReport::new(stage, copy_bandwidth);
        let measured = moving.unwrap_or(still);
        let frame = report(&measured.frame);
        let copied_bytes = frame.median_ms * 1e-3 * copy_bandwidth / scene.receivers.max(1) as f64;
        self.scenes.push(SceneReport {
            stages: measured.stages.iter().map(report).collect(),
            times_published_at_same_bandwidth: PUBLISHED_BYTES_PER_RECEIVER / copied_bytes,
            active_share: measured.active_share,
            planning_ms: planning.map(|times| median(times).as_secs_f64() * 1e3),
            still_frame: moving.map(|_| report(&still.frame)),
            scene,
            frame,
        });
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.scenes.is_empty()
    }

    /// The figures as text: the stages of each scene.
    pub(crate) fn table(&self) -> Result<String, std::fmt::Error> {
        let mut text = String::new();
        writeln!(text, "{}{}", self.device, if self.is_software { ", a driver in software" } else { "" })?;
        let changes = if self.lights_move {
            "all lights move before each frame"
        } else {
            "nothing changes but bounced light"
        };
        writeln!(text, "{changes}")?;
        writeln!(text, "a copy reads and writes {:.1} GB/s", self.copy_gb_per_s)?;
        for report in &self.scenes {
            let SceneReport { scene, active_share, stages, frame, still_frame, .. } = report;
            writeln!(
                text,
                "\n{}: {} receivers, {:.1} bytes of matrices each; {} clusters, {} probes, {} surfels",
                scene.scene,
                scene.receivers,
                scene.matrix_bytes_per_receiver,
                scene.clusters,
                scene.probes,
                scene.surfels
            )?;
            if scene.grid_vertices > 0 {
                let (vertices, percent) = (scene.grid_vertices, active_share * 100.0);
                writeln!(text, "{percent:.1} % of the grid's {vertices} vertices are active")?;
            }
            writeln!(
                text,
                "{:<18}{:>11}{:>11}{:>11}{:>9}{:>10}",
                "", "median ms", "shortest", "MB", "GB/s", "of copy"
            )?;
            let still = still_frame.as_ref().map(|frame| ("lights still", frame));
            let lines = stages.iter().chain([frame]).map(|stage| (stage.name, stage)).chain(still);
            for (name, stage) in lines {
                writeln!(
                    text,
                    "{name:<18}{:>11.4}{:>11.4}{:>11.2}{:>9.1}{:>8.1} %",
                    stage.median_ms,
                    stage.shortest_ms,
                    stage.bytes as f64 * 1e-6,
                    stage.gb_per_s,
                    stage.of_copy * 100.0
                )?;
            }
            if let Some(still) = still_frame {
                let ratio = frame.median_ms / still.median_ms;
                writeln!(text, "lights that move make a frame {ratio:.2} times as long")?;
            }
            if let Some(planning) = report.planning_ms {
                writeln!(text, "planning a frame with objects{planning:>11.4} ms")?;
            }
            writeln!(
                text,
                "{:.1} times as fast per receiver as published, at the same bandwidth",
                report.times_published_at_same_bandwidth
            )?;
        }
        Ok(text)
    }
}
