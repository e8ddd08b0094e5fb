//! Stage 5: texels around the charts. The twin of `cpu::dilate_lightmap`.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use wgpu::BindingResource;

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, level_view};
use super::kernel::Kernel;
use super::stage_shaders::DILATE_LIGHTMAP;
use super::storage::Storage;

/// Invocations of a workgroup.
pub(super) const WORKGROUP: usize = 64;

/// A texel outside the charts and the receiver whose light it repeats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TexelCopy {
    /// Index of the texel.
    pub(super) texel: u32,
    /// Index of the receiver.
    pub(super) receiver: u32,
    /// Index of the receiver's cluster.
    pub(super) cluster: u32,
}

/// Fills the texels around charts that bilinear lookups touch.
#[derive(Debug)]
pub(super) struct DilateLightmap {
    kernel: Kernel,
    group: wgpu::BindGroup,
    copies: usize,
}

impl DilateLightmap {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let (receivers, clusters) = (baked.receivers_of_texels(), baked.clusters_of_receivers());
        let copy = |[texel, source]: &[u32; 2]| {
            let receiver = receivers[*source as usize];
            TexelCopy { texel: *texel, receiver, cluster: clusters[receiver as usize] }
        };
        let mut copies: Vec<TexelCopy> = baked.lightmap.dilation.iter().map(copy).collect();
        copies.sort_unstable_by_key(|copy| copy.texel);
        let kernel = Kernel::new(storage.device, &DILATE_LIGHTMAP, None);
        let (records, texels) = (storage.array("dilated texels", &copies)?, level_view(&buffers.lightmap, 0));
        let resources = [
            records.as_entire_binding(),
            buffers.irradiance.as_entire_binding(),
            BindingResource::TextureView(&texels),
            buffers.work.touched.as_entire_binding(),
        ];
        let group = kernel.bind(storage.device, 0, &resources);
        Ok(Self { kernel, group, copies: copies.len() })
    }

    pub(super) fn dilate_lightmap(&self, pass: &mut wgpu::ComputePass) {
        self.kernel.run(pass, &[&self.group], self.copies.div_ceil(WORKGROUP));
    }
}
