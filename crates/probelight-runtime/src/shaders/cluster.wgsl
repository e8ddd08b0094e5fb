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

/// The precisions of the leading singular values.
fn leading(ranks: Ranks, rank: u32) -> Ranks {
    let f16 = min(ranks.f16, rank);
    let snorm8 = min(ranks.snorm8, rank - f16);
    return Ranks(f16, snorm8, min(ranks.snorm4, rank - f16 - snorm8));
}

fn rank(ranks: Ranks) -> u32 {
    return ranks.f16 + ranks.snorm8 + ranks.snorm4;
}

/// Encoding of the singular value number `row`.
fn row_encoding(ranks: Ranks, row: u32) -> u32 {
    return select(select(SNORM4, SNORM8, row < ranks.f16 + ranks.snorm8), F16, row < ranks.f16);
}

/// Where the line of the singular value number `row` starts in a matrix with lines of `stride` values, words.
fn line_start(ranks: Ranks, row: u32, stride: u32) -> u32 {
    let f16_rows = min(row, ranks.f16);
    let snorm8_rows = min(row - f16_rows, ranks.snorm8);
    let snorm4_rows = row - f16_rows - snorm8_rows;
    return f16_rows * line_words(F16, stride)
        + snorm8_rows * line_words(SNORM8, stride)
        + snorm4_rows * line_words(SNORM4, stride);
}
