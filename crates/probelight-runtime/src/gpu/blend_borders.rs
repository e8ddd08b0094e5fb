//! Second half of stage 4: receivers near borders between clusters.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use wgpu::BindingResource;

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, RGB_BYTES, level_view};
use super::kernel::{Kernel, whole};
use super::stage_shaders::BLEND_BORDERS;
use super::storage::Storage;

/// Invocations of a workgroup.
pub(super) const WORKGROUP: usize = 64;

/// A receiver to which more than one cluster contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BlendedReceiver {
    /// Index of the receiver.
    pub(super) receiver: u32,
    /// Index of its texel.
    pub(super) texel: u32,
    /// First of the contributions of clusters other than its own.
    pub(super) first_source: u32,
    /// Number of these.
    pub(super) source_count: u32,
}

/// Adds to the receivers' irradiance what neighbouring clusters say of them.
#[derive(Debug)]
pub(super) struct BlendBorders {
    kernel: Kernel,
    group: wgpu::BindGroup,
    receivers: usize,
    bytes: u64,
}

impl BlendBorders {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let (blended, sources) = blended_receivers(baked);
        let kernel = Kernel::new(storage.device, &BLEND_BORDERS, None);
        let (records, texels) =
            (storage.array("blended receivers", &blended)?, level_view(&buffers.lightmap, 0));
        let sources = storage.array("contributions of neighbours", &sources)?;
        let mut resources = whole(&[&records, &sources, &buffers.border_irradiance, &buffers.irradiance]);
        resources.push(BindingResource::TextureView(&texels));
        let group = kernel.bind(storage.device, 0, &resources);
        let bytes = records.size() + RGB_BYTES * blended.len() as u64 + sources.size();
        Ok(Self { kernel, group, receivers: blended.len(), bytes })
    }

    /// What it reads besides the irradiance beyond borders, bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn blend_borders(&self, pass: &mut wgpu::ComputePass) {
        self.kernel.run(pass, &[&self.group], self.receivers.div_ceil(WORKGROUP));
    }
}

/// Who takes contributions, and these, in the order of the receivers.
fn blended_receivers(baked: &BakedScene) -> (Vec<BlendedReceiver>, Vec<u32>) {
    let mut contributions: Vec<(u32, u32)> = baked.border_receivers.iter().copied().zip(0..).collect();
    contributions.sort_unstable();
    let mut first_source = 0;
    let blended = contributions.chunk_by(|a, b| a.0 == b.0).map(|contributions| {
        let (receiver, source_count) = (contributions[0].0, contributions.len() as u32);
        first_source += source_count;
        BlendedReceiver {
            receiver,
            texel: baked.receiver_texels[receiver as usize],
            first_source: first_source - source_count,
            source_count,
        }
    });
    (blended.collect(), contributions.iter().map(|(_, source)| *source).collect())
}
