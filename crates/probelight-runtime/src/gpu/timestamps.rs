//! How long passes take, by the GPU's own clock.

use std::time::Duration;

use super::device::GpuError;
#[cfg(feature = "blocking")]
use super::device::wait_for;
use super::readback::read_buffer_async;
use crate::{PerStage, Stage, StageTimings};

/// Time queries at the beginnings of passes, and of an empty one behind the last.
///
/// A pass takes until the next one begins. Its own end would not do: drivers in software note it when the work
/// has been handed to their threads, not when it is done.
#[derive(Debug)]
pub(super) struct PassTimestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Number of passes, the empty one included.
    count: u32,
    /// Nanoseconds of a tick.
    period: f64,
}

impl PassTimestamps {
    /// `None` if the device was opened without [`wgpu::Features::TIMESTAMP_QUERY`].
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, passes: usize) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let count = passes as u32 + 1;
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times of passes"),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let resolved = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("times of passes"),
            size: u64::from(count) * u64::from(wgpu::QUERY_SIZE),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self { queries, resolved, count, period: f64::from(queue.get_timestamp_period()) })
    }

    /// What pass number `pass` writes.
    pub(super) fn writes(&self, pass: usize) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(pass as u32),
            end_of_pass_write_index: None,
        }
    }

    /// Ends the last pass's time, and makes all times readable.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        drop(encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("end"),
            timestamp_writes: Some(self.writes(self.count as usize - 1)),
        }));
        encoder.resolve_query_set(&self.queries, 0..self.count, &self.resolved, 0);
    }

    /// How long each pass took. Waits for the GPU.
    #[cfg(feature = "blocking")]
    pub(super) fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<Duration>, GpuError> {
        wait_for(device, self.read_async(device, queue))
    }

    /// How long each pass took.
    async fn read_async(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<Duration>, GpuError> {
        let ticks: Vec<u64> = read_buffer_async(device, queue, &self.resolved).await?;
        let duration = |pair: &[u64]| {
            Duration::from_secs_f64(pair[1].saturating_sub(pair[0]) as f64 * self.period * 1e-9)
        };
        Ok(ticks.windows(2).map(duration).collect())
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
    #[cfg(feature = "blocking")]
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<StageTimings, GpuError> {
        wait_for(device, self.read_async(device, queue))
    }

    /// Times of the frame that was submitted last; see [`readback`](super::readback).
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub async fn read_async(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<StageTimings, GpuError> {
        let passes = self.0.read_async(device, queue).await?;
        Ok(StageTimings {
            stages: PerStage::from_fn(|stage| passes[stage as usize]),
            frame: passes.iter().sum(),
        })
    }
}
