//! How long the stages take, by the GPU's own clock.

use std::time::Duration;

use super::device::GpuError;
use super::readback::read_buffer;
use super::stage::{Stage, StageTimings};

/// Time queries around each stage of a frame.
#[derive(Debug)]
pub struct FrameTimestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Nanoseconds of a tick.
    period: f32,
}

/// A query before and one after each stage.
const QUERIES: u32 = 2 * Stage::ALL.len() as u32;

impl FrameTimestamps {
    /// `None` if the device was opened without [`wgpu::Features::TIMESTAMP_QUERY`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count: QUERIES,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("times of stages"),
            size: u64::from(QUERIES) * u64::from(wgpu::QUERY_SIZE),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self { queries, resolved, period: queue.get_timestamp_period() })
    }

    /// What a stage's pass writes.
    pub fn writes(&self, stage: Stage) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * stage as u32;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Makes the times of a frame's stages readable; goes behind its last stage.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..QUERIES, &self.resolved, 0);
    }

    /// Times of the frame that was submitted last. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<StageTimings, GpuError> {
        let ticks: Vec<u64> = read_buffer(device, queue, &self.resolved)?;
        let duration = |from: usize, to: usize| {
            let nanoseconds = ticks[to].saturating_sub(ticks[from]) as f64 * f64::from(self.period);
            Duration::from_secs_f64(nanoseconds * 1e-9)
        };
        let last = ticks.len() - 1;
        Ok(StageTimings {
            stages: Stage::ALL.map(|stage| duration(2 * stage as usize, 2 * stage as usize + 1)),
            frame: duration(0, last),
        })
    }
}
