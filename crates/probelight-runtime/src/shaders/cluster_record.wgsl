// Where a cluster's parts lie in the buffers of its shard.

/// Singular values stored as half floats, as eight bits, as four bits, in this order.
struct Ranks {
    f16: u32,
    snorm8: u32,
    snorm4: u32,
}

struct ClusterRecord {
    /// Among all clusters.
    number: u32,
    /// Among all receivers.
    first_receiver: u32,
    /// In the shard's `receiver_texels`.
    first_texel: u32,
    receiver_count: u32,
    /// In `column_signals`.
    first_column: u32,
    column_count: u32,
    /// Of U, and of ΣVᵀ: as many.
    receiver_ranks: Ranks,
    signal_ranks: Ranks,
    /// First word of U.
    receiver_basis_offset: u32,
    /// First word of ΣVᵀ.
    signal_basis_offset: u32,
    /// In `row_scales` and in the coefficients.
    first_row: u32,
    /// First word of the columns' exponents, four to a word.
    exponent_offset: u32,
}
