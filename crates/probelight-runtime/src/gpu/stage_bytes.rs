//! How many bytes the stages move on a GPU.

use super::gpu_runtime::GpuRuntime;
use crate::PerStage;
use crate::frame::{Held, stage_bytes_with};

impl GpuRuntime {
    /// Bytes that each stage must move by the present plan if it reads each of its inputs once and writes each of its
    /// outputs once. Shadow maps are not counted, direct light and shading only if `lights_move`.
    pub fn stage_bytes(&self, lights_move: bool) -> PerStage<u64> {
        let lightmap = &self.buffers.lightmap;
        let texel = lightmap.format().block_copy_size(None).map_or(0, u64::from);
        let level = |level: u32| {
            let size = lightmap.size().mip_level_size(level, wgpu::TextureDimension::D2);
            texel * u64::from(size.width) * u64::from(size.height)
        };
        let levels = if self.stages.reduce_lightmap.is_some() { lightmap.mip_level_count() } else { 1 };
        let held = Held {
            feedback: self.stages.light_surfels.feedback_bytes(),
            shading: self.stages.light_surfels.shading_bytes(),
            column_numbers: [4.0; 2],
            texel,
            reduction: (1..levels).map(|n| level(n - 1) + level(n)).sum(),
        };
        stage_bytes_with(&self.baked, self.plan(), lights_move, &held)
    }
}
