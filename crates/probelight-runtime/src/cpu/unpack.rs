//! Vectors of packed matrix values, decoded straight from their words.

use bytemuck::cast;
use probelight_asset::packed::Precision;
use wide::{i8x16, i16x16, i32x16, u32x16};

use super::{LANES, Lanes};

/// A [`Precision`] that kernels are compiled for.
pub(super) trait Encoding {
    /// Which one.
    const PRECISION: Precision;

    /// The value that a decoded 1 stands for. Decoding leaves it out: a factor for a whole line costs less than
    /// one for each value.
    const UNIT: f32;

    /// The first [`LANES`] values of a slice, in multiples of [`UNIT`](Self::UNIT).
    fn decode(words: &[u32]) -> Lanes;
}

/// Words of a vector in the longest encoding.
pub(super) const MOST_WORDS: usize = LANES / Precision::F16.values_per_word();

/// [`Precision::F16`].
pub(super) struct F16;

/// [`Precision::Snorm8`].
pub(super) struct Snorm8;

/// [`Precision::Snorm4`].
pub(super) struct Snorm4;

impl Encoding for F16 {
    const PRECISION: Precision = Precision::F16;
    const UNIT: f32 = 1.0;

    /// Sign, exponent and mantissa move to their places in an `f32`, and one multiplication corrects the
    /// exponent's bias (2¹¹², exact, also for subnormal values): vector operations that every target has.
    /// Infinity and NaN would come out as large numbers; a valid scene has none.
    #[inline(always)]
    fn decode(words: &[u32]) -> Lanes {
        const REBIAS: f32 = f32::from_bits((127 + 112) << 23);
        const SIGN_EXPONENT_MANTISSA: i32 = 0x8fff_e000_u32.cast_signed();
        let widened = i32x16::from(cast::<[u32; 8], i16x16>(first(words))) << 13;
        cast::<i32x16, Lanes>(widened & i32x16::splat(SIGN_EXPONENT_MANTISSA)) * Lanes::splat(REBIAS)
    }
}

impl Encoding for Snorm8 {
    const PRECISION: Precision = Precision::Snorm8;
    const UNIT: f32 = 1.0 / 127.0;

    #[inline(always)]
    fn decode(words: &[u32]) -> Lanes {
        i32x16::from(i16x16::from(cast::<[u32; 4], i8x16>(first(words)))).round_float()
    }
}

impl Encoding for Snorm4 {
    const PRECISION: Precision = Precision::Snorm4;
    const UNIT: f32 = 1.0 / 7.0;

    /// Each lane takes the word that holds its value, moves the value to the top and back down with its sign.
    #[inline(always)]
    fn decode(words: &[u32]) -> Lanes {
        const TO_THE_TOP: [u32; LANES] = [28, 24, 20, 16, 12, 8, 4, 0, 28, 24, 20, 16, 12, 8, 4, 0];
        let [a, b] = first(words);
        let words = u32x16::new([a, a, a, a, a, a, a, a, b, b, b, b, b, b, b, b]);
        let at_the_top = words.unbounded_shl(u32x16::new(TO_THE_TOP));
        cast::<u32x16, i32x16>(at_the_top).unbounded_shr_scalar(28).round_float()
    }
}

/// The first `N` words of a slice.
#[inline(always)]
fn first<const N: usize>(words: &[u32]) -> [u32; N] {
    let mut first = [0; N];
    first.copy_from_slice(&words[..N]);
    first
}

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    /// Whether all lanes of `words` are decoded to what [`Precision::unpack`] says.
    fn decodes_all<E: Encoding>(words: &[u32]) -> bool {
        let decoded = E::decode(words).to_array();
        (0..LANES).all(|i| (decoded[i] * E::UNIT - E::PRECISION.unpack(words, i)).abs() < 1e-7)
    }

    #[test]
    fn every_finite_half_is_decoded_exactly() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            if half.is_finite() {
                let decoded = F16::decode(&[u32::from(bits) | u32::from(bits) << 16; 8]).to_array();
                assert_eq!(decoded.map(f32::to_bits), [half.to_f32().to_bits(); LANES], "{bits:#06x}");
            }
        }
    }

    #[test]
    fn integers_are_decoded_in_order() {
        let snorm8: Vec<u32> =
            (0..64u32).map(|i| u32::from_le_bytes([0, 1, 2, 3].map(|b| 4 * i as u8 + b))).collect();
        for words in snorm8.chunks(4).filter(|words| !words.iter().any(|w| w.to_le_bytes().contains(&0x80))) {
            assert!(decodes_all::<Snorm8>(words), "{words:x?}");
        }
        for words in [[0x7654_3210, 0xfedc_ba99], [0x1357_9bdf, 0x1234_5679], [u32::MAX, 0]] {
            assert!(decodes_all::<Snorm4>(&words), "{words:x?}");
        }
        assert!(!decodes_all::<Snorm4>(&[8, 0]), "−8 is no value, and the comparison does not notice");
    }
}
