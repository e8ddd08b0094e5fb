//! Second half of stage 4: receivers beside the borders between clusters. The twin of `cpu::blend_borders`.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, BorderBlend};
use wgpu::BindingResource;

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, RGB_BYTES, level_view};
use super::kernel::{Kernel, whole};
use super::stage_shaders::{BLEND_BORDERS, STORE_BLENDED};
use super::storage::Storage;
use crate::frame::ReceiverPlace;

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
    blend: (Kernel, wgpu::BindGroup),
    store: (Kernel, wgpu::BindGroup),
    receivers: usize,
}

impl BlendBorders {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let records = baked.border_blends();
        let border_receivers = border_receivers(&records, baked);
        let receivers = storage.array("receivers beside borders", &border_receivers)?;
        let records = storage.array("blends across borders", &records)?;
        let blended = storage.zeros("blended irradiance", RGB_BYTES * border_receivers.len() as u64)?;
        let blend = Kernel::new(storage.device, &BLEND_BORDERS, None);
        let extents = buffers.extents.clusters.as_entire_binding();
        let inputs = whole(&[&receivers, &records, &buffers.irradiance, &blended]);
        let group = blend.bind_at(storage.device, 0, (0..).zip(inputs).chain([(5, extents.clone())]));
        let store = Kernel::new(storage.device, &STORE_BLENDED, None);
        let texels = level_view(&buffers.lightmap, 0);
        let outputs = [
            (0, receivers.as_entire_binding()),
            (2, buffers.irradiance.as_entire_binding()),
            (3, blended.as_entire_binding()),
            (4, BindingResource::TextureView(&texels)),
            (5, extents),
        ];
        let store_group = store.bind_at(storage.device, 0, outputs);
        Ok(Self { blend: (blend, group), store: (store, store_group), receivers: border_receivers.len() })
    }

    pub(super) fn blend_borders(&self, pass: &mut wgpu::ComputePass) {
        for (kernel, group) in [&self.blend, &self.store] {
            kernel.run(pass, &[group], self.receivers.div_ceil(WORKGROUP));
        }
    }
}

/// Where the records of each receiver lie.
fn border_receivers(records: &[BorderBlend], baked: &BakedScene) -> Vec<BorderReceiver> {
    let receivers: Vec<u32> = BorderBlend::by_receiver(records).map(|records| records[0].receiver).collect();
    let mut first_record = 0;
    let record = |(records, place): (&[BorderBlend], ReceiverPlace)| {
        let (receiver, record_count) = (records[0].receiver, records.len() as u32);
        first_record += record_count;
        BorderReceiver {
            receiver,
            texel: baked.receiver_texels[receiver as usize],
            first_record: first_record - record_count,
            record_count,
            cluster: place.cluster,
            index: place.index,
        }
    };
    BorderBlend::by_receiver(records)
        .zip(ReceiverPlace::of(&baked.clusters, &receivers))
        .map(record)
        .collect()
}
