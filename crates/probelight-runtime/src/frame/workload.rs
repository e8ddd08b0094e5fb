//! What a frame computed of what there is.

use probelight_asset::BakedScene;

use super::plan::{ClusterExtent, matrix_bytes_of_all, receivers};

/// What a frame computed, and what it left for later ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Workload {
    /// Receivers whose irradiance was computed.
    pub receivers: u64,
    /// Bytes of the transport matrices that were read: U and ΣVᵀ.
    pub matrix_bytes: u64,
    /// Clusters that changed by more than next to nothing since they were last computed.
    pub pending_clusters: usize,
}

impl Workload {
    /// Of what was computed of each cluster.
    pub(crate) fn new(baked: &BakedScene, computed: &[ClusterExtent], pending_clusters: usize) -> Self {
        Self {
            receivers: receivers(computed),
            matrix_bytes: matrix_bytes_of_all(baked, computed),
            pending_clusters,
        }
    }
}
