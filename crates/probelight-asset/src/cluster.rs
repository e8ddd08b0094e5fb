//! Receivers with a common transport matrix.

use bytemuck::{Pod, Zeroable};
use probelight_scene::Bounds;

use crate::packed::Ranks;

/// Receivers that share a compressed transport matrix A ≈ U·(ΣVᵀ) (\[SED\] eq. 6).
///
/// A's input is a list of signals. Its first `signal_count` columns are [scalar
/// signals](crate::BakedParts::scalar_signals); then come the coefficients of the cluster's P probes: column
/// `signal_count + P·l² + p·(2l+1) + (l+m)` is coefficient (l, m) of the p-th, so that fewer bands are fewer
/// leading columns.
///
/// Value (k, c) of ΣVᵀ is `row_scale[k] · 2^(−column_exponent[c]/8) · v` with v as stored; U's values are as
/// stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Cluster {
    /// Box around the receivers, metres.
    pub bounds: Bounds,
    /// Where in the scene's air its receivers lie: no light gets from one air space to another. [`NONE`](crate::NONE) for receivers
    /// that see no probe.
    pub air_space: u32,
    /// First receiver (index into `receiver_texels`).
    pub first_receiver: u32,
    /// Number of receivers.
    pub receiver_count: u32,
    /// First scalar signal (index into `cluster_signals`).
    pub first_signal: u32,
    /// Number of scalar signals.
    pub signal_count: u32,
    /// First probe (index into `cluster_probes`).
    pub first_probe: u32,
    /// Number of probes.
    pub probe_count: u32,
    /// How many singular values are kept, and with which precision U has them.
    pub receiver_ranks: Ranks,
    /// With which precision ΣVᵀ has them; as many.
    pub signal_ranks: Ranks,
    /// Relative error of the compressed matrix in the bake's metric.
    pub error: f32,
    /// Offset of U in `receiver_basis`, words.
    pub receiver_basis_offset: u64,
    /// Offset of ΣVᵀ in `signal_basis`, words.
    pub signal_basis_offset: u64,
    /// Offset of the row scales in `row_scales`.
    pub row_scale_offset: u64,
    /// Offset of the column exponents in `column_exponents`.
    pub column_exponent_offset: u64,
}

const _: () = assert!(size_of::<Cluster>() == 112, "the file format says so");

impl Cluster {
    /// Number of singular values.
    pub const fn rank(&self) -> u32 {
        self.receiver_ranks.total()
    }

    /// Words of U.
    pub fn receiver_basis_words(&self) -> u64 {
        self.receiver_ranks.words(u64::from(self.receiver_count))
    }
}
