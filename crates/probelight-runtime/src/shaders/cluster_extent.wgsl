// How much of a cluster a frame computes.

/// What a frame computes of a cluster: the leading ones of each.
struct ClusterExtent {
    /// Singular values.
    rank: u32,
    /// Columns of ΣVᵀ.
    columns: u32,
    /// Receivers; with none, nothing of the cluster is computed.
    receivers: u32,
}
