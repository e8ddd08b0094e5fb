//! The clusters: arrays that they divide among them, matrices of finite numbers.

use crate::packed::{Precision, Ranks};
use crate::{BakedParts, Cluster};

impl BakedParts {
    /// Clusters divide receivers, signals, probes, matrices and their scales among them, one after the other.
    pub(super) fn check_clusters(&self) -> Result<(), String> {
        let (signals, probes) = (self.scalar_signals(), self.probes.len());
        for (i, signal) in self.cluster_signals.iter().enumerate() {
            ensure!(
                (*signal as usize) < signals,
                "entry {i} of the clusters' signals is {signal} of {signals}"
            );
        }
        for (i, probe) in self.cluster_probes.iter().enumerate() {
            ensure!((*probe as usize) < probes, "entry {i} of the clusters' probes is {probe} of {probes}");
        }
        let mut end = ClusterEnd::default();
        for (c, cluster) in self.clusters.iter().enumerate() {
            ensure!(end.is_start_of(cluster), "cluster {c} does not start where the one before it ends");
            let box_ = &cluster.bounds;
            ensure!(
                box_.min.is_finite() && box_.max.is_finite() && box_.min.cmple(box_.max).all(),
                "cluster {c} has a box that is not one"
            );
            ensure!(cluster.error >= 0.0 && cluster.error.is_finite(), "cluster {c} has no usable error");
            ensure!(
                cluster.receiver_ranks.checked_total() == cluster.signal_ranks.checked_total(),
                "cluster {c} has different numbers of singular values in its two matrices"
            );
            end.advance(cluster, self.coefficients() as u64)
                .ok_or_else(|| format!("cluster {c} is too large"))?;
        }
        let lengths = ClusterEnd {
            receivers: self.receiver_count() as u64,
            signals: self.cluster_signals.len() as u64,
            probes: self.cluster_probes.len() as u64,
            receiver_basis: self.receiver_basis.len() as u64,
            signal_basis: self.signal_basis.len() as u64,
            row_scales: self.row_scales.len() as u64,
            column_exponents: self.column_exponents.len() as u64,
        };
        let errors = self.receiver_errors.len() as u64;
        ensure!(
            errors == lengths.receivers,
            "there are {errors} receivers' errors for {} receivers",
            lengths.receivers
        );
        ensure!(end == lengths, "the clusters need {end:?}, and there are {lengths:?}");
        Ok(())
    }

    /// Relies on the clusters' offsets.
    pub(super) fn check_matrices(&self) -> Result<(), String> {
        for (c, cluster) in self.clusters.iter().enumerate() {
            let u = &self.receiver_basis[cluster.receiver_basis_offset as usize..];
            let sv = &self.signal_basis[cluster.signal_basis_offset as usize..];
            let usable = lines_are_usable(u, cluster.receiver_ranks, cluster.receiver_count as usize)
                && lines_are_usable(sv, cluster.signal_ranks, self.column_count(cluster));
            ensure!(usable, "a transport matrix of cluster {c} has a value that is not finite, or below −1");
        }
        ensure!(self.row_scales.iter().all(|v| v.is_finite()), "a row scale is not finite");
        Ok(())
    }
}

/// Whether all of a matrix's half floats are finite, and no integer is the one that stands for less than −1.
fn lines_are_usable(matrix: &[u32], ranks: Ranks, count: usize) -> bool {
    let section = |precision: Precision, first: u32, lines: u32| {
        let start = ranks.line_start(first as usize, count);
        matrix[start..][..lines as usize * precision.words(count)].iter()
    };
    // An exponent of ones is infinite or not a number.
    section(Precision::F16, 0, ranks.f16).all(|word| [*word, word >> 16].iter().all(|h| h & 0x7c00 != 0x7c00))
        && section(Precision::Snorm8, ranks.f16, ranks.snorm8)
            .all(|word| word.to_le_bytes().iter().all(|b| *b != 0x80))
        && section(Precision::Snorm4, ranks.f16 + ranks.snorm8, ranks.snorm4)
            .all(|word| word.to_le_bytes().iter().all(|b| b & 0x0f != 0x08 && b & 0xf0 != 0x80))
}

/// How much of the shared arrays the clusters so far have taken.
#[derive(Debug, Default, PartialEq)]
struct ClusterEnd {
    receivers: u64,
    signals: u64,
    probes: u64,
    receiver_basis: u64,
    signal_basis: u64,
    row_scales: u64,
    column_exponents: u64,
}

impl ClusterEnd {
    fn is_start_of(&self, cluster: &Cluster) -> bool {
        u64::from(cluster.first_receiver) == self.receivers
            && u64::from(cluster.first_signal) == self.signals
            && u64::from(cluster.first_probe) == self.probes
            && cluster.receiver_basis_offset == self.receiver_basis
            && cluster.signal_basis_offset == self.signal_basis
            && cluster.row_scale_offset == self.row_scales
            && cluster.column_exponent_offset == self.column_exponents
    }

    /// Adds a cluster; `None` if it is larger than any file can be.
    fn advance(&mut self, cluster: &Cluster, coefficients: u64) -> Option<()> {
        let rank = cluster.receiver_ranks.checked_total()?;
        let receivers = u64::from(cluster.receiver_count);
        let columns = u64::from(cluster.signal_count) + u64::from(cluster.probe_count) * coefficients;
        // With lines shorter than this, the words of a matrix cannot overflow.
        u32::try_from(columns).ok()?;
        self.receivers = self.receivers.checked_add(receivers)?;
        self.signals = self.signals.checked_add(u64::from(cluster.signal_count))?;
        self.probes = self.probes.checked_add(u64::from(cluster.probe_count))?;
        self.receiver_basis = self.receiver_basis.checked_add(cluster.receiver_ranks.words(receivers))?;
        self.signal_basis = self.signal_basis.checked_add(cluster.signal_ranks.words(columns))?;
        self.row_scales = self.row_scales.checked_add(u64::from(rank))?;
        self.column_exponents = self.column_exponents.checked_add(columns)?;
        Some(())
    }
}
