// Packed matrix values; the twin of `probelight_asset::packed`.
//
// A line (a row of ΣVᵀ, a column of U) starts at a word, and its first value has the word's lowest bits. Kernels
// take values in quads: four neighbouring values of a line, which lie in two words of half floats, one word of
// eight-bit or half a word of four-bit values. A kernel calls its matrix `basis`.

const F16: u32 = 0u;
const SNORM8: u32 = 1u;
const SNORM4: u32 = 2u;

/// Words of a line of `count` values.
fn line_words(encoding: u32, count: u32) -> u32 {
    switch encoding {
        case F16: { return (count + 1u) / 2u; }
        case SNORM8: { return (count + 3u) / 4u; }
        default: { return (count + 7u) / 8u; }
    }
}

/// Four signed integers of four bits that start at bit `shift`, as −1 to 1.
fn unpack4x4snorm(word: u32, shift: u32) -> vec4f {
    let values = vec4i(vec4u(word >> shift) << vec4u(28u, 24u, 20u, 16u)) >> vec4u(28u);
    return vec4f(values) * (1.0 / 7.0);
}

/// Four values of a line of the matrix that has `words` words from `start` on.
fn basis_quad(encoding: u32, start: u32, words: u32, quad: u32) -> vec4f {
    switch encoding {
        case F16: {
            let low = basis[start + 2u * quad];
            let high = select(0u, basis[start + 2u * quad + 1u], 2u * quad + 1u < words);
            return vec4f(unpack2x16float(low), unpack2x16float(high));
        }
        case SNORM8: { return unpack4x8snorm(basis[start + quad]); }
        default: { return unpack4x4snorm(basis[start + quad / 2u], quad % 2u * 16u); }
    }
}
