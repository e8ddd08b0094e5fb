//! Stage 4: irradiance of the receivers. The twin of `cpu::gather_receivers`.

use wgpu::BindingResource;

use super::cluster_shards::ClusterShard;
use super::frame_buffers::{FrameBuffers, level_view};
use super::kernel::{Kernel, whole};
use super::stage_shaders::GATHER_RECEIVERS;

/// Multiplies the clusters' coefficients with their U.
#[derive(Debug)]
pub(super) struct GatherReceivers {
    kernel: Kernel,
    /// Bindings and number of tasks of each shard.
    shards: Vec<(wgpu::BindGroup, usize)>,
}

impl GatherReceivers {
    pub(super) fn new(device: &wgpu::Device, shards: &[ClusterShard], buffers: &FrameBuffers) -> Self {
        let kernel = Kernel::new(device, &GATHER_RECEIVERS, None);
        let texels = level_view(&buffers.lightmap, 0);
        let bind = |shard: &ClusterShard| {
            let input = [&shard.clusters, &shard.tasks, &shard.receiver_basis, &shard.coefficients];
            let mut resources = whole(&input);
            resources.extend(whole(&[&shard.receiver_texels, &buffers.irradiance]));
            resources.push(BindingResource::TextureView(&texels));
            resources.push(buffers.extents.clusters.as_entire_binding());
            (kernel.bind(device, 0, &resources), shard.task_count)
        };
        let shards = shards.iter().map(bind).collect();
        Self { kernel, shards }
    }

    pub(super) fn gather_receivers(&self, pass: &mut wgpu::ComputePass) {
        for (group, tasks) in &self.shards {
            self.kernel.run(pass, &[group], *tasks);
        }
    }
}
