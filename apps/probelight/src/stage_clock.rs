//! How long the stages of a frame take, on whatever computes them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use probelight_asset::{BakedScene, Probe};
use probelight_math::glam::Vec3;
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime, copy_bandwidth};
use probelight_runtime::{
    FrameInput, FramePlan, LodSettings, PerStage, Runtime, Stage, StageTimings, View, stage_bytes,
};
use probelight_scene::{Bounds, Light, Lighting};
use rayon::prelude::*;

use crate::backend::Backend;

/// Frames before the first that is measured: shaders are compiled, caches filled.
const WARM_UP: usize = 3;

/// Bytes copied on the CPU to measure its memory: more than caches hold.
const COPY_BYTES: usize = 256 << 20;

/// Copies of which the fastest counts.
const COPIES: usize = 10;

/// Measures frames on one device.
pub(crate) struct StageClock<'a> {
    gpu: Option<&'a GpuDevice>,
    /// Bytes per second that a copy reads and writes.
    pub(crate) copy_bandwidth: f64,
}

/// A measured stage.
pub(crate) struct MeasuredStage {
    pub(crate) name: &'static str,
    /// Of all frames, shortest first.
    pub(crate) times: Vec<Duration>,
    /// Bytes that must move.
    pub(crate) bytes: u64,
}

/// The stages of a frame, in order, and the frame as a whole.
pub(crate) struct MeasuredFrames {
    pub(crate) stages: Vec<MeasuredStage>,
    pub(crate) frame: MeasuredStage,
    /// The share of the grid's vertices that frames computed; of vertices there are none without a grid.
    pub(crate) active_share: f64,
}

impl<'a> StageClock<'a> {
    /// Measures the memory of what computes.
    pub(crate) fn new(backend: &'a Backend) -> anyhow::Result<Self> {
        match backend {
            Backend::Cpu => Ok(Self { gpu: None, copy_bandwidth: cpu_copy_bandwidth() }),
            Backend::Gpu(gpu) => {
                Ok(Self { gpu: Some(gpu), copy_bandwidth: copy_bandwidth(&gpu.device, &gpu.queue)? })
            }
        }
    }

    /// Measures frames of a scene.
    pub(crate) fn measure(&self, baked: Arc<BakedScene>, show: &LightShow) -> anyhow::Result<MeasuredFrames> {
        match self.gpu {
            None => measure_cpu(baked, show),
            Some(gpu) => measure_gpu(gpu, baked, show),
        }
    }
}

/// The light of the frames that are measured.
pub(crate) struct LightShow {
    pub(crate) lighting: Lighting,
    /// Whether the analytic lights change with each frame; else nothing changes but the bounced light.
    pub(crate) lights_move: bool,
    /// Levels of detail, and who looks.
    pub(crate) lod: LodSettings,
    pub(crate) view: View,
    /// Number of frames.
    pub(crate) frames: usize,
    /// The share of the grid's vertices around which something moves.
    pub(crate) active_share: f64,
}

impl LightShow {
    fn lighting(&self, frame: usize) -> Lighting {
        let mut lighting = self.lighting.clone();
        // To and fro by next to nothing: the work is that of a light that moves.
        if self.lights_move && !frame.is_multiple_of(2) {
            lighting.lights.iter_mut().for_each(nudge);
        }
        lighting
    }
}

fn nudge(light: &mut Light) {
    match light {
        Light::Point { position, .. } | Light::Spot { position, .. } => *position *= 1.0 + 1e-4,
        Light::Directional { direction, .. } => {
            *direction = (*direction + 1e-3 * direction.any_orthonormal_vector()).normalize();
        }
    }
}

/// A lamp in the air near the middle of a scene, and a sun.
pub(crate) fn lamp_and_sun(baked: &BakedScene) -> Vec<Light> {
    let bounds = baked.scene.bounds();
    let middle = bounds.min.midpoint(bounds.max);
    let distance = |probe: &&Probe| probe.position.distance_squared(middle);
    let nearest = baked.probes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let intensity = Vec3::splat(bounds.diagonal().powi(2) / 16.0);
    vec![
        Light::Point { position: nearest.map_or(middle, |probe| probe.position), intensity, range: None },
        Light::Directional { direction: Vec3::new(0.36, -0.8, 0.48), irradiance: Vec3::splat(4.0) },
    ]
}

/// Boxes in which about a share of the grid's vertices lies, beginning in the middle of the scene.
fn active_boxes(baked: &BakedScene, share: f64) -> Vec<Bounds> {
    let middle = baked.scene.bounds().min.midpoint(baked.scene.bounds().max);
    let mut clusters: Vec<_> = baked.clusters[baked.lightmap_clusters()..].iter().collect();
    clusters.sort_by(|a, b| a.bounds.distance(middle).total_cmp(&b.bounds.distance(middle)));
    // What is in the middle of a cluster reaches its neighbours least.
    let small = |bounds: Bounds| Bounds::of([bounds.min.midpoint(bounds.max)]);
    let count = (share * clusters.len() as f64).ceil() as usize;
    clusters.into_iter().take(count).map(|cluster| small(cluster.bounds)).collect()
}

/// The share of the grid's receivers that a plan computes.
fn share_of_grid(baked: &BakedScene, plan: &FramePlan) -> f64 {
    let first = baked.lightmap_clusters();
    let computed = baked.clusters[first..].iter().zip(&plan.clusters()[first..]);
    let computed = computed.map(|(cluster, extent)| extent.receivers.min(cluster.receiver_count));
    computed.map(f64::from).sum::<f64>() / baked.grid_receivers.len().max(1) as f64
}

fn measure_cpu(baked: Arc<BakedScene>, show: &LightShow) -> anyhow::Result<MeasuredFrames> {
    let active = active_boxes(&baked, show.active_share);
    let input = FrameInput { view: Some(show.view), active_boxes: &active, ..FrameInput::default() };
    let mut runtime = Runtime::new(baked);
    runtime.set_lod(show.lod.clone())?;
    let mut timings = Vec::with_capacity(WARM_UP + show.frames);
    for frame in 0..WARM_UP + show.frames {
        runtime.set_lighting(show.lighting(frame))?;
        timings.push(runtime.step(&input));
    }
    let bytes = stage_bytes(runtime.baked(), runtime.work(), show.lights_move);
    let stages: Vec<Stage> = Stage::ALL.into_iter().filter(|stage| stage.is_on_cpu()).collect();
    let share = share_of_grid(runtime.baked(), runtime.plan());
    Ok(MeasuredFrames::new(&stages, &timings[WARM_UP..], &bytes, share))
}

fn measure_gpu(gpu: &GpuDevice, baked: Arc<BakedScene>, show: &LightShow) -> anyhow::Result<MeasuredFrames> {
    let active = active_boxes(&baked, show.active_share);
    let mut runtime = GpuRuntime::new(&gpu.device, &gpu.queue, baked, GpuOptions::default())?;
    runtime.set_lod(show.lod.clone())?;
    let input = FrameInput { view: Some(show.view), active_boxes: &active, ..FrameInput::default() };
    let timings = runtime.measure_frames(WARM_UP + show.frames, |runtime, frame| {
        runtime.plan_frame(&input);
        runtime.set_lighting(show.lighting(frame))
    })?;
    gpu.check()?;
    let share = share_of_grid(runtime.baked(), runtime.plan());
    let bytes = runtime.stage_bytes(show.lights_move);
    Ok(MeasuredFrames::new(&Stage::ALL, &timings[WARM_UP..], &bytes, share))
}

impl MeasuredFrames {
    fn new(stages: &[Stage], timings: &[StageTimings], bytes: &PerStage<u64>, active_share: f64) -> Self {
        let measured = |stage: &Stage| {
            let times = timings.iter().map(|timing| timing.stages[*stage]).collect();
            MeasuredStage::new(stage.name(), times, bytes[*stage])
        };
        let frames = timings.iter().map(|timing| timing.frame).collect();
        Self {
            stages: stages.iter().map(measured).collect(),
            frame: MeasuredStage::new("frame", frames, bytes.values().iter().sum()),
            active_share,
        }
    }
}

impl MeasuredStage {
    fn new(name: &'static str, mut times: Vec<Duration>, bytes: u64) -> Self {
        times.sort_unstable();
        Self { name, times, bytes }
    }
}

/// Bytes per second that all threads together read and write when they copy memory.
fn cpu_copy_bandwidth() -> f64 {
    let words = COPY_BYTES / size_of::<u64>();
    let (source, mut copy) = (vec![1u64; words], vec![0u64; words]);
    let chunk = 1 << 17;
    let fastest = (0..COPIES)
        .map(|_| {
            let start = Instant::now();
            copy.par_chunks_mut(chunk)
                .zip(source.par_chunks(chunk))
                .for_each(|(to, from)| to.copy_from_slice(from));
            std::hint::black_box(&mut copy);
            start.elapsed()
        })
        .min()
        .unwrap_or_default();
    2.0 * COPY_BYTES as f64 / fastest.as_secs_f64()
}
