//! Decoding of half floats in vectors.

use bytemuck::cast;
use half::f16;
use wide::{i16x16, i32x16};

use super::{LANES, Lanes};

/// The finite half floats as `f32`.
///
/// Sign, exponent and mantissa move to their places in an `f32`, and one multiplication corrects the exponent's
/// bias (2¹¹², exact, also for subnormal values): vector operations that every target has. Infinity and NaN
/// would come out as large numbers; [`crate::Runtime::new`] refuses them.
#[inline(always)]
pub(super) fn decode(encoded: &[f16; LANES]) -> Lanes {
    const REBIAS: f32 = f32::from_bits((127 + 112) << 23);
    const SIGN_EXPONENT_MANTISSA: i32 = 0x8fff_e000_u32.cast_signed();
    let widened = i32x16::from(cast::<[f16; LANES], i16x16>(*encoded)) << 13;
    cast::<i32x16, Lanes>(widened & i32x16::splat(SIGN_EXPONENT_MANTISSA)) * Lanes::splat(REBIAS)
}

/// The first [`LANES`] values of a slice, or all of a shorter one followed by zeros.
#[inline(always)]
pub(super) fn padded(values: &[f16]) -> [f16; LANES] {
    match values.first_chunk() {
        Some(chunk) => *chunk,
        None => {
            let mut padded = [f16::ZERO; LANES];
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
                assert_eq!(
                    decode(&[half; LANES]).to_array()[0].to_bits(),
                    half.to_f32().to_bits(),
                    "{bits:#06x}"
                );
            }
        }
    }
}
