//! A frame's plan in the memory of a GPU.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;

use super::device::GpuError;
use super::storage::Storage;
use crate::frame::first_weight;
use crate::{FramePlan, ProbeExtent};

/// What a frame computes of a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ProbeRecord {
    /// Leading rays.
    pub(super) rays: u32,
    /// Leading coefficients.
    pub(super) coefficients: u32,
    /// First of the weights of so many rays.
    pub(super) first_weight: u32,
}

/// What the present frame computes of each cluster and each probe.
#[derive(Debug)]
pub(super) struct FrameExtents {
    /// A [`ClusterExtent`](crate::ClusterExtent) for each cluster.
    pub(super) clusters: wgpu::Buffer,
    /// A [`ProbeRecord`] for each probe.
    pub(super) probes: wgpu::Buffer,
    /// What they hold.
    uploaded: FramePlan,
    stored_rays: u32,
}

impl FrameExtents {
    /// Those of a frame that computes everything.
    pub(super) fn new(storage: &Storage, baked: &BakedScene) -> Result<Self, GpuError> {
        let plan = FramePlan::full(baked);
        let stored_rays = baked.relight_directions.len() as u32;
        Ok(Self {
            clusters: storage.array("extents of clusters", plan.clusters())?,
            probes: storage.array("extents of probes", &probe_records(plan.probes(), stored_rays))?,
            uploaded: plan,
            stored_rays,
        })
    }

    /// Uploads a plan to where kernels have written another.
    pub(super) fn upload_again(&mut self, queue: &wgpu::Queue, plan: &FramePlan) {
        self.uploaded = FramePlan::default();
        self.upload(queue, plan);
    }

    /// Uploads what is not there yet of a plan.
    pub(super) fn upload(&mut self, queue: &wgpu::Queue, plan: &FramePlan) {
        if plan.clusters() != self.uploaded.clusters() {
            queue.write_buffer(&self.clusters, 0, bytemuck::cast_slice(plan.clusters()));
        }
        if plan.probes() != self.uploaded.probes() {
            let records = probe_records(plan.probes(), self.stored_rays);
            queue.write_buffer(&self.probes, 0, bytemuck::cast_slice(&records));
        }
        self.uploaded.clone_from(plan);
    }
}

/// What is computed of probes, as shaders see it.
pub(super) fn probe_records(extents: &[ProbeExtent], stored_rays: u32) -> Vec<ProbeRecord> {
    let record = |extent: &ProbeExtent| ProbeRecord {
        rays: extent.rays,
        coefficients: extent.coefficients() as u32,
        first_weight: first_weight(stored_rays, extent.rays),
    };
    extents.iter().map(record).collect()
}
