// How much of a cluster a frame computes.

/// What a frame computes of a cluster: the leading ones of each.
struct ClusterExtent {
    /// Singular values.
    rank: u32,
    /// Columns of ΣVᵀ.
    columns: u32,
    /// Receivers; with none, nothing of the cluster is computed.
    receivers: u32,
    /// Singular values that count in full; those behind them are on their way out.
    solid: u32,
    /// How much these still count, in parts of FADE_STEPS.
    fade: u32,
    /// Level of the lightmap from which the other receivers are filled, or 0.
    fill: u32,
}

/// Parts of a singular value that fades out.
const FADE_STEPS: u32 = 16u;
