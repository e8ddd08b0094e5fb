//! How long frames take on a GPU, and how long they would if memory were the only limit.

use std::time::Duration;

use super::cluster_shards::ClusterShard;
use super::device::{GpuError, checked};
use super::frame_buffers::RGB_BYTES;
use super::gpu_runtime::GpuRuntime;
use super::kernel::{Kernel, whole};
use super::stage::{Stage, StageTimings};
use super::stage_shaders::COPY_WORDS;
use super::storage::Storage;
use super::timestamps::{FrameTimestamps, TimestampPair};

/// Frames before each that is measured, in the same submission, so that the GPU does not fall asleep in between.
const FRAMES_BEFORE: usize = 3;

/// Most bytes copied to measure the bandwidth: many times what caches hold.
const COPY_BYTES: u64 = 128 << 20;

/// Copies of which the fastest counts.
const COPIES: usize = 20;

impl GpuRuntime {
    /// Measures as many frames in which nothing changes but the bounced light.
    ///
    /// # Errors
    /// [`GpuError::NoTimestamps`], or [`GpuError::Lost`] if the GPU does not answer.
    pub fn measure_frames(&mut self, frames: usize) -> Result<Vec<StageTimings>, GpuError> {
        let (device, queue) = (self.device.clone(), self.queue.clone());
        let timestamps = FrameTimestamps::new(&device, &queue).ok_or(GpuError::NoTimestamps)?;
        let mut timings = Vec::with_capacity(frames);
        for _ in 0..frames {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for _ in 0..FRAMES_BEFORE {
                self.encode(&mut encoder);
            }
            self.encode_timed(&mut encoder, &timestamps);
            queue.submit([encoder.finish()]);
            timings.push(timestamps.read(&device, &queue)?);
        }
        Ok(timings)
    }

    /// Bytes that each stage must move if it reads each of its inputs once and writes each of its outputs once; in the
    /// order of [`Stage::ALL`]. Shadow maps and shading after changes are not counted.
    pub fn stage_bytes(&self) -> [u64; Stage::ALL.len()] {
        let (baked, buffers) = (&self.baked, &self.buffers);
        let texel = 8;
        let rgb = RGB_BYTES;
        let level = |level: u32| {
            let size = buffers.lightmap.size().mip_level_size(level, wgpu::TextureDimension::D2);
            texel * u64::from(size.width) * u64::from(size.height)
        };
        let levels =
            if self.stages.reduce_lightmap.is_some() { buffers.lightmap.mip_level_count() } else { 1 };
        let dilated = baked.lightmap.dilation.len() as u64;
        let scalar_signals = rgb * baked.scalar_signals() as u64;
        let coefficients = rgb * (baked.probes.len() * baked.coefficients()) as u64;
        let basis = 4 * (baked.relight_directions.len() * baked.coefficients()) as u64;
        let surfels = rgb * baked.surfels.len() as u64;
        let relight_rays = size_of_val(&baked.relight_surfels[..]) as u64;
        let clusters = |bytes: fn(&ClusterShard) -> u64| self.shards.iter().map(bytes).sum::<u64>();
        Stage::ALL.map(|stage| match stage {
            Stage::LightSurfels => {
                self.stages.light_surfels.feedback_bytes() + buffers.irradiance.size() + scalar_signals
            }
            Stage::RelightProbes => relight_rays + basis + surfels + coefficients,
            Stage::ProjectClusters => clusters(|shard| shard.projection_bytes()) + buffers.signals.size(),
            Stage::GatherReceivers => {
                let texels = texel * baked.receiver_texels.len() as u64;
                clusters(|shard| shard.gather_bytes()) + buffers.irradiance.size() + texels
            }
            Stage::DilateLightmap => dilated * (8 + rgb + texel),
            Stage::ReduceLightmap => (1..levels).map(|n| level(n - 1) + level(n)).sum(),
        })
    }
}

/// How fast a GPU copies memory, bytes per second: read and written bytes together.
///
/// # Errors
/// [`GpuError::NoTimestamps`], [`GpuError::OutOfMemory`], or [`GpuError::Lost`] if the GPU does not answer.
pub fn copy_bandwidth(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<f64, GpuError> {
    let timestamps = TimestampPair::new(device, queue).ok_or(GpuError::NoTimestamps)?;
    let storage = Storage::new(device, queue);
    let bytes = COPY_BYTES.min(storage.limit);
    let (kernel, group) = checked(device, "measuring the memory", || {
        let (source, copied) = (storage.zeros("source", bytes)?, storage.zeros("copy", bytes)?);
        let kernel = Kernel::new(device, &COPY_WORDS, None);
        let group = kernel.bind(device, 0, &whole(&[&source, &copied]));
        Ok::<_, GpuError>((kernel, group))
    })??;
    let mut fastest = Duration::MAX;
    for _ in 0..COPIES {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for timed in [false, true] {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("copy"),
                timestamp_writes: timed.then(|| timestamps.writes()),
            });
            kernel.run(&mut pass, &[&group], (bytes as usize).div_ceil(16 * 1024));
        }
        timestamps.resolve(&mut encoder);
        queue.submit([encoder.finish()]);
        fastest = fastest.min(timestamps.read(device, queue)?);
    }
    Ok(2.0 * bytes as f64 / fastest.as_secs_f64())
}
