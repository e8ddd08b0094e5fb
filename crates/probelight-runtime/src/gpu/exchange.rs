//! Reading what the stages hand to each other, and replacing it: for still pictures, measurements and tests of
//! single stages. Reading waits for the GPU, except where it is `async`; see [`readback`](super::readback).

use std::sync::Arc;

use bytemuck::cast_slice;
use probelight_math::glam::Vec3;

use super::device::GpuError;
#[cfg(feature = "blocking")]
use super::device::wait_for;
use super::frame_buffers::RGB_BYTES;
use super::gpu_runtime::GpuRuntime;
#[cfg(feature = "blocking")]
use super::readback::read_buffer;
use super::readback::read_buffer_async;
use crate::{ClusterExtent, IrradianceLightmap, Workload};

impl GpuRuntime {
    /// Irradiance of the receivers in the last frame, W/m², in the order of
    /// [`receiver_texels`](probelight_asset::BakedParts::receiver_texels). Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_irradiance(&self) -> Result<Vec<Vec3>, GpuError> {
        wait_for(&self.device, self.read_irradiance_async())
    }

    /// Irradiance of the receivers in the last frame, W/m², in the order of
    /// [`receiver_texels`](probelight_asset::BakedParts::receiver_texels).
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub async fn read_irradiance_async(&self) -> Result<Vec<Vec3>, GpuError> {
        self.read_rgb(&self.buffers.irradiance, self.baked.receiver_count()).await
    }

    /// The lightmap of the last frame as the CPU would have it, in full precision. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_lightmap(&self) -> Result<IrradianceLightmap, GpuError> {
        wait_for(&self.device, self.read_lightmap_async())
    }

    /// The lightmap of the last frame as the CPU would have it, in full precision.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub async fn read_lightmap_async(&self) -> Result<IrradianceLightmap, GpuError> {
        let layout = &self.baked.lightmap;
        let mut lightmap = IrradianceLightmap::new(layout.width, layout.height);
        for (texel, value) in self.baked.receiver_texels.iter().zip(self.read_irradiance_async().await?) {
            lightmap.texels[*texel as usize] = value;
        }
        for [texel, source] in &layout.dilation {
            lightmap.texels[*texel as usize] = lightmap.texels[*source as usize];
        }
        Ok(lightmap)
    }

    /// The scalar signals of the last frame, then all coefficients of each probe, W·m⁻²·sr⁻¹.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_signals(&self) -> Result<Vec<Vec3>, GpuError> {
        let coefficients = self.baked.probes.len() * self.baked.coefficients();
        self.wait_for_rgb(&self.buffers.signals, self.baked.scalar_signals() + coefficients)
    }

    /// The clusters' coefficients b of the last frame: one RGB row per singular value, in the order of
    /// [`row_scales`](probelight_asset::BakedParts::row_scales).
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_coefficients(&self) -> Result<Vec<Vec3>, GpuError> {
        let parts = self.shards.iter().map(|shard| self.wait_for_rgb(&shard.coefficients, shard.row_count));
        Ok(parts.collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// Irradiance of the analytic lights on each surfel, W/m², as of the last frame.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_direct(&self) -> Result<Vec<Vec3>, GpuError> {
        let parts = self.stages.light_surfels.direct();
        let parts = parts.map(|(surfels, buffer)| self.wait_for_rgb(buffer, surfels.len()));
        Ok(parts.collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// What the last frame computed of each cluster: of the [plan](Self::plan) what did not wait.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_work(&self) -> Result<Vec<ClusterExtent>, GpuError> {
        read_buffer(&self.device, &self.queue, &self.buffers.extents.clusters)
    }

    /// The same in numbers, and what waits. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn read_workload(&self) -> Result<Workload, GpuError> {
        wait_for(&self.device, self.read_workload_async())
    }

    /// What the last frame computed that was submitted before this is first polled, and what waits.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub fn read_workload_async(&self) -> impl Future<Output = Result<Workload, GpuError>> + use<> {
        let (device, queue, baked) = (self.device.clone(), self.queue.clone(), Arc::clone(&self.baked));
        let extents = self.buffers.extents.clusters.clone();
        let waiting = self.work.as_ref().map(|work| work.pending_clusters());
        async move {
            let pending = match waiting {
                Some((states, count)) => count(read_buffer_async(&device, &queue, &states).await?),
                None => 0,
            };
            let computed: Vec<ClusterExtent> = read_buffer_async(&device, &queue, &extents).await?;
            Ok(Workload::new(&baked, &computed, pending))
        }
    }

    /// Replaces the receivers' irradiance: the next frame's feedback.
    pub fn write_irradiance(&self, irradiance: &[Vec3]) {
        self.queue.write_buffer(&self.buffers.irradiance, 0, cast_slice(irradiance));
    }

    /// Replaces signals from the one numbered `first` on; see [`read_signals`](Self::read_signals).
    pub fn write_signals(&self, first: usize, signals: &[Vec3]) {
        self.queue.write_buffer(&self.buffers.signals, RGB_BYTES * first as u64, cast_slice(signals));
    }

    /// Replaces the clusters' coefficients b.
    pub fn write_coefficients(&self, coefficients: &[Vec3]) {
        let mut rest = coefficients;
        for shard in &self.shards {
            let (here, behind) = rest.split_at(shard.row_count.min(rest.len()));
            self.queue.write_buffer(&shard.coefficients, 0, cast_slice(here));
            rest = behind;
        }
    }

    /// Replaces the irradiance of the analytic lights on the surfels until a light changes. It takes effect with the next
    /// change of a colour.
    pub fn write_direct(&self, direct: &[Vec3]) {
        for (surfels, buffer) in self.stages.light_surfels.direct() {
            self.queue.write_buffer(buffer, 0, cast_slice(&direct[surfels]));
        }
    }

    /// Number of portions into which surfels and clusters are divided, so that shaders can bind them.
    pub fn shard_counts(&self) -> [usize; 2] {
        [self.stages.light_surfels.direct().count(), self.shards.len()]
    }

    #[cfg(feature = "blocking")]
    fn wait_for_rgb(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<Vec3>, GpuError> {
        wait_for(&self.device, self.read_rgb(buffer, count))
    }

    async fn read_rgb(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<Vec3>, GpuError> {
        let values: Vec<f32> = read_buffer_async(&self.device, &self.queue, buffer).await?;
        Ok(values.chunks_exact(3).take(count).map(Vec3::from_slice).collect())
    }
}
