//! How long frames take on a GPU, and how long they would if memory were the only limit.

use std::time::{Duration, Instant};

use super::device::{GpuError, checked, is_software, new_encoder};
use super::gpu_runtime::GpuRuntime;
use super::kernel::{Kernel, whole};
use super::stage_shaders::COPY_WORDS;
use super::storage::Storage;
use super::timestamps::{FrameTimestamps, PassTimestamps};
use crate::{Stage, StageTimings};

/// Stages before each frame that is measured, in the same submission, so that the GPU does not fall asleep.
const STAGES_BEFORE: usize = 15;

/// Most bytes copied to measure the bandwidth: many times what caches hold.
const COPY_BYTES: u64 = 128 << 20;

/// Copies of which the fastest counts.
const COPIES: usize = 10;

impl GpuRuntime {
    /// Measures as many frames. Before each, `change` may change lights, colours and the plan; drawing the shadow maps is
    /// not measured.
    ///
    /// A GPU's own clock tells how long each stage took within a whole frame. Drivers in software note times when
    /// work is handed to their threads, not when it is done; for them, and for GPUs without such a clock, each stage
    /// is submitted by itself and waited for.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer, or an error of `change`.
    pub fn measure_frames(
        &mut self,
        frames: usize,
        mut change: impl FnMut(&mut Self, usize) -> Result<(), GpuError>,
    ) -> Result<Vec<StageTimings>, GpuError> {
        let is_software = is_software(&self.device.adapter_info());
        let timestamps = FrameTimestamps::new(&self.device, &self.queue).filter(|_| !is_software);
        let measure = |frame| {
            change(self, frame)?;
            match &timestamps {
                Some(timestamps) => self.measure_by_timestamps(timestamps),
                None => self.measure_by_waiting(),
            }
        };
        (0..frames).map(measure).collect()
    }

    fn measure_by_timestamps(&mut self, timestamps: &FrameTimestamps) -> Result<StageTimings, GpuError> {
        let mut encoder = new_encoder(&self.device);
        self.encode_shadow_maps(&mut encoder);
        // The later stages of a frame keep the GPU awake; the first one would use up the changes.
        // Where something may wait, they would leave nothing to do.
        let stages_before = if self.work.is_some() { 0 } else { STAGES_BEFORE };
        for stage in Stage::ALL[1..].iter().cycle().take(stages_before) {
            self.encode_stage(*stage, &mut encoder, None);
        }
        self.encode_stages_timed(&mut encoder, timestamps);
        self.queue.submit([encoder.finish()]);
        timestamps.read(&self.device, &self.queue)
    }

    fn measure_by_waiting(&mut self) -> Result<StageTimings, GpuError> {
        let mut encoder = new_encoder(&self.device);
        self.encode_shadow_maps(&mut encoder);
        submit_and_wait(&self.device, &self.queue, encoder)?;
        let mut timings = StageTimings::default();
        for stage in Stage::ALL {
            let mut encoder = new_encoder(&self.device);
            self.encode_stage(stage, &mut encoder, None);
            timings.stages[stage] = submit_and_wait(&self.device, &self.queue, encoder)?;
        }
        timings.frame = timings.stages.values().iter().sum();
        Ok(timings)
    }
}

/// How fast a GPU copies memory, bytes per second: read and written bytes together. Measured as stages are.
///
/// # Errors
/// [`GpuError::OutOfMemory`], or [`GpuError::Lost`] if the GPU does not answer.
pub fn copy_bandwidth(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<f64, GpuError> {
    let is_software = is_software(&device.adapter_info());
    let timestamps = PassTimestamps::new(device, queue, 1).filter(|_| !is_software);
    let storage = Storage::new(device, queue);
    let bytes = COPY_BYTES.min(storage.limit);
    let (kernel, group) = checked(device, "measuring the memory", || {
        let (source, copied) = (storage.zeros("source", bytes)?, storage.zeros("copy", bytes)?);
        let kernel = Kernel::new(device, &COPY_WORDS, None);
        let group = kernel.bind(device, 0, &whole(&[&source, &copied]));
        Ok((kernel, group))
    })?;
    let mut fastest = Duration::MAX;
    for _ in 0..COPIES {
        let mut encoder = new_encoder(device);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("copy"),
            timestamp_writes: timestamps.as_ref().map(|timestamps| timestamps.writes(0)),
        });
        kernel.run(&mut pass, &[&group], (bytes as usize).div_ceil(16 * 1024));
        drop(pass);
        let time = match &timestamps {
            Some(timestamps) => {
                timestamps.resolve(&mut encoder);
                queue.submit([encoder.finish()]);
                timestamps.read(device, queue)?.iter().sum()
            }
            None => submit_and_wait(device, queue, encoder)?,
        };
        fastest = fastest.min(time);
    }
    Ok(2.0 * bytes as f64 / fastest.as_secs_f64())
}

/// How long the GPU takes for some work, as the host sees it.
fn submit_and_wait(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    encoder: wgpu::CommandEncoder,
) -> Result<Duration, GpuError> {
    let commands = encoder.finish();
    let start = Instant::now();
    queue.submit([commands]);
    let waited = device.poll(wgpu::PollType::wait_indefinitely());
    waited.map_err(|error| GpuError::Lost { reason: error.to_string() })?;
    Ok(start.elapsed())
}
