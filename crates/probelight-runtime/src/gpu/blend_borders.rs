//! Second half of stage 4: receivers beside the borders between clusters. The twin of `cpu::blend_borders`.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use wgpu::BindingResource;

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, RGB_BYTES, level_view};
use super::kernel::Kernel;
use super::stage_shaders::{BLEND_BORDERS, KEEP_UNBLENDED};
use super::storage::Storage;
use crate::frame::{BorderRecord, ReceiverPlace, border_records};

/// Invocations of a workgroup.
pub(super) const WORKGROUP: usize = 64;

/// A receiver beside a border between clusters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BorderReceiver {
    /// Index of the receiver.
    pub(super) receiver: u32,
    /// Index of its texel.
    pub(super) texel: u32,
    /// First of its records.
    pub(super) first_record: u32,
    /// Number of these.
    pub(super) record_count: u32,
    /// Index of its cluster.
    pub(super) cluster: u32,
    /// Which of the cluster's receivers it is.
    pub(super) index: u32,
}

/// Blends the irradiance of the receivers beside borders with what is across.
#[derive(Debug)]
pub(super) struct BlendBorders {
    keep: (Kernel, wgpu::BindGroup),
    blend: (Kernel, wgpu::BindGroup),
    receivers: usize,
    unblended: wgpu::Buffer,
}

impl BlendBorders {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let (border_receivers, records) = border_receivers(baked);
        let receivers = storage.array("receivers beside borders", &border_receivers)?;
        let records = storage.array("blends across borders", &records)?;
        let unblended = storage.zeros("unblended irradiance", RGB_BYTES * border_receivers.len() as u64)?;
        let texels = level_view(&buffers.lightmap, 0);
        let resources = [
            receivers.as_entire_binding(),
            records.as_entire_binding(),
            buffers.irradiance.as_entire_binding(),
            unblended.as_entire_binding(),
            BindingResource::TextureView(&texels),
            buffers.extents.clusters.as_entire_binding(),
        ];
        let bind = |shader, bindings: &[u32]| {
            let kernel = Kernel::new(storage.device, shader, None);
            let bound = bindings.iter().map(|binding| (*binding, resources[*binding as usize].clone()));
            let group = kernel.bind_at(storage.device, 0, bound);
            (kernel, group)
        };
        Ok(Self {
            keep: bind(&KEEP_UNBLENDED, &[0, 2, 3, 5]),
            blend: bind(&BLEND_BORDERS, &[0, 1, 2, 3, 4, 5]),
            receivers: border_receivers.len(),
            unblended,
        })
    }

    pub(super) fn blend_borders(&self, pass: &mut wgpu::ComputePass) {
        for (kernel, group) in [&self.keep, &self.blend] {
            kernel.run(pass, &[group], self.receivers.div_ceil(WORKGROUP));
        }
    }

    /// Forgets all light.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.unblended, 0, None);
    }
}

/// Where the records of each receiver lie, and the records.
fn border_receivers(baked: &BakedScene) -> (Vec<BorderReceiver>, Vec<BorderRecord>) {
    let mut records = Vec::new();
    let receiver = |(receiver, its): (u32, Vec<BorderRecord>)| {
        let place = ReceiverPlace::at(&baked.clusters, receiver);
        let border = BorderReceiver {
            receiver,
            texel: baked.receiver_texels[receiver as usize],
            first_record: records.len() as u32,
            record_count: its.len() as u32,
            cluster: place.cluster,
            index: place.index,
        };
        records.extend(its);
        border
    };
    let receivers =
        border_records(&baked.clusters, &baked.border_blends()).into_iter().map(receiver).collect();
    (receivers, records)
}
