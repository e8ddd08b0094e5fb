//! Decoding of half floats in vectors.

use half::f16;

/// The finite half floats as `f32`.
///
/// Written in integer operations that the compiler turns into vector instructions, which it does not do with
/// the conversion of single values: sign, exponent and mantissa move to their places in an `f32`, and one
/// multiplication corrects the exponent's bias (2¹¹², exact, also for subnormal values). Infinity and NaN
/// would come out as large numbers; [`crate::Runtime::new`] refuses them.
#[inline(always)]
pub(super) fn decode<const N: usize>(encoded: &[f16; N]) -> [f32; N] {
    const REBIAS: f32 = f32::from_bits((127 + 112) << 23);
    encoded.map(|half| {
        let widened = i32::from(half.to_bits().cast_signed()).cast_unsigned() << 13;
        f32::from_bits(widened & 0x8fff_e000) * REBIAS
    })
}

/// The first `N` values of a slice, or all of a shorter one followed by zeros.
#[inline(always)]
pub(super) fn padded<const N: usize>(values: &[f16]) -> [f16; N] {
    match values.first_chunk() {
        Some(chunk) => *chunk,
        None => {
            let mut padded = [f16::ZERO; N];
            padded[..values.len()].copy_from_slice(values);
            padded
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_half_is_decoded_exactly() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            if half.is_finite() {
                assert_eq!(decode(&[half])[0].to_bits(), half.to_f32().to_bits(), "{bits:#06x}");
            }
        }
    }
}
