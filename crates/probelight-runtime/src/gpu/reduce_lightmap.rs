//! Stage 6: coarser levels of the lightmap, for renderers that show it small. Only the GPU has it: the CPU's
//! renderer takes several samples per pixel instead.

use wgpu::BindingResource;

use super::frame_buffers::{FrameBuffers, level_view};
use super::kernel::Kernel;
use super::stage_shaders::REDUCE_LIGHTMAP;

/// Width and height of a workgroup's texels.
pub(super) const WORKGROUP: u32 = 8;

/// Averages the lightmap.
#[derive(Debug)]
pub(super) struct ReduceLightmap {
    kernel: Kernel,
    /// Bindings and size in workgroups of each level from the second on.
    levels: Vec<(wgpu::BindGroup, [u32; 2])>,
}

impl ReduceLightmap {
    pub(super) fn new(device: &wgpu::Device, buffers: &FrameBuffers) -> Self {
        let kernel = Kernel::new(device, &REDUCE_LIGHTMAP, None);
        let texture = &buffers.lightmap;
        let bind = |level: u32| {
            let views = [level_view(texture, level - 1), level_view(texture, level)];
            let resources = [
                BindingResource::TextureView(&views[0]),
                BindingResource::TextureView(&views[1]),
                buffers.work.flags.as_entire_binding(),
            ];
            let size = [texture.width(), texture.height()].map(|side| (side >> level).max(1));
            (kernel.bind(device, 0, &resources), size.map(|side| side.div_ceil(WORKGROUP)))
        };
        let levels = (1..texture.mip_level_count()).map(bind).collect();
        Self { kernel, levels }
    }

    pub(super) fn reduce_lightmap(&self, pass: &mut wgpu::ComputePass) {
        for (group, [width, height]) in &self.levels {
            self.kernel.run_2d(pass, group, *width, *height);
        }
    }
}
