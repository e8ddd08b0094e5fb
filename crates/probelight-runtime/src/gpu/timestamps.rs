//! How long passes take, by the GPU's own clock.

use std::time::Duration;

use super::device::GpuError;
use super::readback::read_buffer;
use super::stage::{Stage, StageTimings};

/// Pairs of time queries around passes.
#[derive(Debug)]
struct PassTimestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    passes: u32,
    /// Nanoseconds of a tick.
    period: f64,
}

impl PassTimestamps {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, passes: usize) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let passes = passes as u32;
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times of passes"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * passes,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("times of passes"),
            size: 2 * u64::from(passes) * u64::from(wgpu::QUERY_SIZE),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self { queries, resolved, passes, period: f64::from(queue.get_timestamp_period()) })
    }

    fn writes(&self, pass: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * pass as u32;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.passes, &self.resolved, 0);
    }

    /// Beginning and end of each pass since the beginning of the first.
    fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[Duration; 2]>, GpuError> {
        let ticks: Vec<u64> = read_buffer(device, queue, &self.resolved)?;
        let since_start =
            |tick: u64| Duration::from_secs_f64(tick.saturating_sub(ticks[0]) as f64 * self.period * 1e-9);
        Ok(ticks.chunks_exact(2).map(|pair| [since_start(pair[0]), since_start(pair[1])]).collect())
    }
}

/// Time queries around each stage of a frame.
#[derive(Debug)]
pub struct FrameTimestamps(PassTimestamps);

impl FrameTimestamps {
    /// `None` if the device was opened without [`wgpu::Features::TIMESTAMP_QUERY`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        PassTimestamps::new(device, queue, Stage::ALL.len()).map(Self)
    }

    /// What a stage's pass writes.
    pub(super) fn writes(&self, stage: Stage) -> wgpu::ComputePassTimestampWrites<'_> {
        self.0.writes(stage as usize)
    }

    /// Makes the times of a frame's stages readable; goes behind its last stage.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        self.0.resolve(encoder);
    }

    /// Times of the frame that was submitted last. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<StageTimings, GpuError> {
        let passes = self.0.read(device, queue)?;
        Ok(StageTimings {
            stages: Stage::ALL.map(|stage| {
                let [begin, end] = passes[stage as usize];
                end.saturating_sub(begin)
            }),
            frame: passes.iter().map(|[_, end]| *end).max().unwrap_or_default(),
        })
    }
}

/// Time queries around a single pass.
#[derive(Debug)]
pub(super) struct TimestampPair(PassTimestamps);

impl TimestampPair {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        PassTimestamps::new(device, queue, 1).map(Self)
    }

    pub(super) fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        self.0.writes(0)
    }

    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        self.0.resolve(encoder);
    }

    pub(super) fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Duration, GpuError> {
        Ok(self.0.read(device, queue)?.first().map(|[_, end]| *end).unwrap_or_default())
    }
}
