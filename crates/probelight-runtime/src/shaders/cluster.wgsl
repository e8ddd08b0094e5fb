// How a cluster's matrices are stored.

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
