//! How many bytes the transport takes, and what of it.

use crate::{BakedParts, Cluster};

/// Bytes of transport matrices and of what belongs to them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MatrixBytes {
    /// U.
    pub receiver_basis: u64,
    /// ΣVᵀ and its scales.
    pub signal_basis: u64,
    /// Which signals and probes the columns stand for.
    pub signals: u64,
    /// Clusters, and where their receivers belong.
    pub metadata: u64,
}

impl MatrixBytes {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.receiver_basis + self.signal_basis + self.signals + self.metadata
    }
}

impl BakedParts {
    /// What belongs to the lightmap.
    pub fn lightmap_bytes(&self) -> MatrixBytes {
        let mut bytes = self.bytes_of_clusters(0, self.lightmap_clusters());
        bytes.metadata += size_of_val(&self.receiver_texels[..]) as u64;
        bytes
    }

    /// What belongs to the grid.
    pub fn grid_bytes(&self) -> MatrixBytes {
        let mut bytes = self.bytes_of_clusters(self.lightmap_clusters(), self.clusters.len());
        let of_grid = size_of_val(&self.grid_blocks[..])
            + size_of_val(&self.grid_vertices[..])
            + size_of_val(&self.grid_receivers[..])
            + size_of_val(&self.grid_cell_blocks[..])
            + size_of_val(&self.grid_cells[..])
            + size_of_val(&self.grid_planes[..]);
        bytes.metadata += of_grid as u64;
        bytes
    }

    /// Bytes of the lightmap's transport matrices and their metadata (what a frame reads to gather light), per
    /// receiver.
    pub fn matrix_bytes_per_receiver(&self) -> f64 {
        self.lightmap_bytes().total() as f64 / self.receiver_texels.len().max(1) as f64
    }

    fn bytes_of_clusters(&self, first: usize, end: usize) -> MatrixBytes {
        let length = |of_all: usize, offset: &dyn Fn(&Cluster) -> u64| {
            let offset = |cluster: usize| self.clusters.get(cluster).map_or(of_all as u64, offset);
            offset(end).saturating_sub(offset(first))
        };
        let signals = length(self.cluster_signals.len(), &|c| u64::from(c.first_signal));
        let probes = length(self.cluster_probes.len(), &|c| u64::from(c.first_probe));
        let scales = length(self.row_scales.len(), &|c| c.row_scale_offset);
        let exponents = length(self.column_exponents.len(), &|c| c.column_exponent_offset);
        MatrixBytes {
            receiver_basis: 4 * length(self.receiver_basis.len(), &|c| c.receiver_basis_offset),
            signal_basis: 4 * length(self.signal_basis.len(), &|c| c.signal_basis_offset)
                + 4 * scales
                + exponents,
            signals: 4 * (signals + probes),
            metadata: size_of::<Cluster>() as u64 * (end - first) as u64,
        }
    }
}
