//! A cluster as it lies in the file.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec3;
use probelight_scene::Bounds;

use crate::Cluster;
use crate::packed::Ranks;

/// [`Cluster`] without implicit padding: 112 bytes, aligned to 8.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ClusterRecord {
    bounds_min: Vec3,
    bounds_max: Vec3,
    air_space: u32,
    /// Zero.
    reserved: u32,
    first_receiver: u32,
    receiver_count: u32,
    first_signal: u32,
    signal_count: u32,
    first_probe: u32,
    probe_count: u32,
    receiver_ranks: Ranks,
    signal_ranks: Ranks,
    row_scale_offset: u32,
    error: f32,
    receiver_basis_offset: u64,
    signal_basis_offset: u64,
    column_exponent_offset: u64,
}

const _: () = assert!(size_of::<ClusterRecord>() == 112, "the file format says so");

impl From<&Cluster> for ClusterRecord {
    fn from(cluster: &Cluster) -> Self {
        Self {
            bounds_min: cluster.bounds.min,
            bounds_max: cluster.bounds.max,
            air_space: cluster.air_space,
            reserved: 0,
            first_receiver: cluster.first_receiver,
            receiver_count: cluster.receiver_count,
            first_signal: cluster.first_signal,
            signal_count: cluster.signal_count,
            first_probe: cluster.first_probe,
            probe_count: cluster.probe_count,
            receiver_ranks: cluster.receiver_ranks,
            signal_ranks: cluster.signal_ranks,
            row_scale_offset: cluster.row_scale_offset,
            error: cluster.error,
            receiver_basis_offset: cluster.receiver_basis_offset,
            signal_basis_offset: cluster.signal_basis_offset,
            column_exponent_offset: cluster.column_exponent_offset,
        }
    }
}

impl From<&ClusterRecord> for Cluster {
    fn from(record: &ClusterRecord) -> Self {
        Self {
            bounds: Bounds { min: record.bounds_min, max: record.bounds_max },
            air_space: record.air_space,
            first_receiver: record.first_receiver,
            receiver_count: record.receiver_count,
            first_signal: record.first_signal,
            signal_count: record.signal_count,
            first_probe: record.first_probe,
            probe_count: record.probe_count,
            receiver_ranks: record.receiver_ranks,
            signal_ranks: record.signal_ranks,
            receiver_basis_offset: record.receiver_basis_offset,
            signal_basis_offset: record.signal_basis_offset,
            row_scale_offset: record.row_scale_offset,
            column_exponent_offset: record.column_exponent_offset,
            error: record.error,
        }
    }
}
