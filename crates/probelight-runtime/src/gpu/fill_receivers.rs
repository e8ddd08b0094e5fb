//! Second part of stage 4, where levels of detail leave receivers out. The twin is in `cpu::gather_receivers`.

use probelight_asset::BakedScene;
use wgpu::BindingResource;

use super::cluster_shards::ClusterShard;
use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, level_view};
use super::kernel::Kernel;
use super::stage_shaders::FILL_RECEIVERS;
use super::storage::Storage;
use crate::frame::FillTables;

/// Fills receivers from those that are computed.
#[derive(Debug)]
pub(super) struct FillReceivers {
    kernel: Kernel,
    /// Bindings and number of tasks of each shard.
    shards: Vec<(wgpu::BindGroup, usize)>,
    levels: usize,
}

impl FillReceivers {
    /// For levels of the lightmap up to `coarsest`.
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
        shards: &[ClusterShard],
        coarsest: u32,
    ) -> Result<Self, GpuError> {
        let tables = FillTables::new(baked, coarsest);
        let fills = storage.array("filled receivers", &tables.records)?;
        let count = storage.uniform("receivers of a level", &(baked.receiver_texels.len() as u32));
        let kernel = Kernel::new(storage.device, &FILL_RECEIVERS, None);
        let texels = level_view(&buffers.lightmap, 0);
        let bind = |shard: &ClusterShard| {
            let resources = [
                shard.clusters.as_entire_binding(),
                shard.tasks.as_entire_binding(),
                shard.receiver_texels.as_entire_binding(),
                fills.as_entire_binding(),
                count.as_entire_binding(),
                buffers.irradiance.as_entire_binding(),
                BindingResource::TextureView(&texels),
                buffers.extents.clusters.as_entire_binding(),
            ];
            (kernel.bind(storage.device, 0, &resources), shard.task_count)
        };
        let shards = shards.iter().map(bind).collect();
        Ok(Self { kernel, shards, levels: tables.levels() })
    }

    /// Levels of the lightmap that it can fill from.
    pub(super) fn levels(&self) -> usize {
        self.levels
    }

    pub(super) fn fill_receivers(&self, pass: &mut wgpu::ComputePass) {
        for (group, tasks) in &self.shards {
            self.kernel.run(pass, &[group], *tasks);
        }
    }
}
