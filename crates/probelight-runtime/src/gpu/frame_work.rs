//! What of a frame is new, in the memory of a GPU. Where nothing may wait, all of it is.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;

use super::device::GpuError;
use super::storage::Storage;
use crate::frame::BLOCK;

/// What the kernels of a frame tell each other; zero makes a frame light everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FrameFlags {
    /// Whether surfels shine as in the last frame, but for what they reflect.
    pub(super) is_quiet: u32,
    /// Whether any surfel is lit.
    pub(super) any_dirty: u32,
    /// Whether the light of any receiver changes.
    pub(super) any_touched: u32,
}

/// What kernels ask before they do anything.
#[derive(Debug)]
pub(super) struct FrameWork {
    /// Of each block of scalar signals, whether its surfels are lit.
    pub(super) dirty: wgpu::Buffer,
    /// Of each cluster, whether the light of its receivers changes.
    pub(super) touched: wgpu::Buffer,
    pub(super) flags: wgpu::Buffer,
    blocks: usize,
    clusters: usize,
}

impl FrameWork {
    /// Everything is new.
    pub(super) fn new(storage: &Storage, baked: &BakedScene) -> Result<Self, GpuError> {
        let (blocks, clusters) = (baked.scalar_signals().div_ceil(BLOCK), baked.clusters.len());
        let work = Self {
            dirty: storage.zeros("dirty blocks", 4 * blocks as u64)?,
            touched: storage.zeros("touched clusters", 4 * clusters as u64)?,
            flags: storage.zeros("flags of a frame", size_of::<FrameFlags>() as u64)?,
            blocks,
            clusters,
        };
        work.set_all(storage.queue);
        Ok(work)
    }

    /// Makes everything new until kernels say otherwise.
    pub(super) fn set_all(&self, queue: &wgpu::Queue) {
        queue.write_buffer(&self.dirty, 0, bytemuck::cast_slice(&vec![1u32; self.blocks]));
        queue.write_buffer(&self.touched, 0, bytemuck::cast_slice(&vec![1u32; self.clusters]));
        let flags = FrameFlags { is_quiet: 0, any_dirty: 1, any_touched: 1 };
        queue.write_buffer(&self.flags, 0, bytemuck::bytes_of(&flags));
    }
}
