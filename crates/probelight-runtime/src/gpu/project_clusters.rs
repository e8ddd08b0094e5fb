//! Stage 3: the clusters' coefficients. The twin of `cpu::project_clusters`.

use super::cluster_shards::ClusterShard;
use super::frame_buffers::FrameBuffers;
use super::kernel::{Kernel, whole};
use super::stage_shaders::PROJECT_CLUSTERS;

/// Multiplies signals with the clusters' ΣVᵀ.
#[derive(Debug)]
pub(super) struct ProjectClusters {
    kernel: Kernel,
    /// Bindings and number of clusters of each shard.
    shards: Vec<(wgpu::BindGroup, usize)>,
}

impl ProjectClusters {
    pub(super) fn new(device: &wgpu::Device, shards: &[ClusterShard], buffers: &FrameBuffers) -> Self {
        let kernel = Kernel::new(device, &PROJECT_CLUSTERS, None);
        let bind = |shard: &ClusterShard| {
            let columns = [&shard.clusters, &shard.column_signals, &shard.exponents];
            let matrices = [&shard.row_scales, &shard.signal_basis, &buffers.signals, &shard.coefficients];
            let extents = [&buffers.extents.clusters];
            let resources = [&columns[..], &matrices, &extents].concat();
            (kernel.bind(device, 0, &whole(&resources)), shard.cluster_count)
        };
        let shards = shards.iter().map(bind).collect();
        Self { kernel, shards }
    }

    pub(super) fn project_clusters(&self, pass: &mut wgpu::ComputePass) {
        for (group, clusters) in &self.shards {
            self.kernel.run(pass, &[group], *clusters);
        }
    }
}
