//! Matrix values in words of 32 bits: half floats, eight bits or four.
//!
//! A line (a row of ΣVᵀ or a column of U) starts at a word. Within a word the first value has the lowest bits,
//! as WGSL's `unpack2x16float` and `unpack4x8snorm` read them.
//!
//! The constants by which other stored numbers become light are here too. Shaders repeat them, which a test compares.

use bytemuck::{Pod, Zeroable};
use half::f16;

/// The gain of a relight ray whose light counts as it is, see [`BakedParts::relight_gains`](crate::BakedParts::relight_gains).
pub const GAIN_STEPS: u8 = 128;

/// Steps of a column's exponent that halve its factor.
pub const EXPONENT_STEPS: u8 = 8;

/// Steepest slope that is continued across a border between clusters, per texel, as a share of the irradiance: beyond, it
/// is the edge of a shadow, not a gradient.
pub const STEEPEST_SLOPE: f32 = 0.25;

/// Factor of a column of ΣVᵀ with an exponent e: 2^(−e/8).
pub fn column_factor(exponent: u8) -> f32 {
    (-f32::from(exponent) / f32::from(EXPONENT_STEPS)).exp2()
}

/// How the values of a line are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Half floats, two to a word.
    F16,
    /// Integers from −127 to 127 that stand for −1 to 1, four to a word.
    Snorm8,
    /// Integers from −7 to 7 that stand for −1 to 1, eight to a word.
    Snorm4,
}

impl Precision {
    /// Values in a word.
    pub const fn values_per_word(self) -> usize {
        match self {
            Self::F16 => 2,
            Self::Snorm8 => 4,
            Self::Snorm4 => 8,
        }
    }

    /// Words of a line of `count` values.
    pub const fn words(self, count: usize) -> usize {
        count.div_ceil(self.values_per_word())
    }

    /// Distance between neighbouring values that can be stored near 1.
    pub const fn step(self) -> f32 {
        match self {
            Self::F16 => 1.0 / 1024.0,
            Self::Snorm8 => 1.0 / 127.0,
            Self::Snorm4 => 1.0 / 7.0,
        }
    }

    /// Appends a line of values (within −1 to 1 for the integer formats).
    pub fn pack(self, values: &[f32], words: &mut Vec<u32>) {
        let bits = 32 / self.values_per_word();
        words.extend(values.chunks(self.values_per_word()).map(|chunk| {
            chunk.iter().enumerate().fold(0, |word, (i, value)| word | self.encode(*value) << (i * bits))
        }));
    }

    fn encode(self, value: f32) -> u32 {
        let integer = |largest: f32| (value.clamp(-1.0, 1.0) * largest).round() as i32 as u32;
        match self {
            Self::F16 => u32::from(f16::from_f32(value).to_bits()),
            Self::Snorm8 => integer(127.0) & 0xff,
            Self::Snorm4 => integer(7.0) & 0xf,
        }
    }

    /// Value `index` of a line.
    #[inline]
    pub fn unpack(self, line: &[u32], index: usize) -> f32 {
        let per_word = self.values_per_word();
        let bits = 32 / per_word;
        let shifted = line[index / per_word] >> (index % per_word * bits);
        let integer = |bits: u32| ((shifted << (32 - bits)).cast_signed() >> (32 - bits)) as f32;
        match self {
            Self::F16 => f16::from_bits(shifted as u16).to_f32(),
            Self::Snorm8 => (integer(8) / 127.0).max(-1.0),
            Self::Snorm4 => (integer(4) / 7.0).max(-1.0),
        }
    }
}

/// How many singular values are stored in each precision; the strongest come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub struct Ranks {
    /// As half floats.
    pub f16: u32,
    /// As eight bits.
    pub snorm8: u32,
    /// As four bits.
    pub snorm4: u32,
}

impl Ranks {
    /// All of them.
    pub const fn total(self) -> u32 {
        self.f16 + self.snorm8 + self.snorm4
    }

    /// All of them, or `None` if there are more than any file can have.
    pub fn checked_total(self) -> Option<u32> {
        self.f16.checked_add(self.snorm8)?.checked_add(self.snorm4)
    }

    /// Precision of the k-th singular value.
    pub const fn precision(self, k: usize) -> Precision {
        if k < self.f16 as usize {
            Precision::F16
        } else if k < (self.f16 + self.snorm8) as usize {
            Precision::Snorm8
        } else {
            Precision::Snorm4
        }
    }

    /// Words of a matrix with one line of `count` values for each singular value.
    pub fn words(self, count: u64) -> u64 {
        u64::from(self.f16) * count.div_ceil(2)
            + u64::from(self.snorm8) * count.div_ceil(4)
            + u64::from(self.snorm4) * count.div_ceil(8)
    }

    /// Where the k-th line starts in a matrix with lines of `count` values, words.
    pub const fn line_start(self, k: usize, count: usize) -> usize {
        let (f16, snorm8) = (self.f16 as usize, self.snorm8 as usize);
        let (a, b) = (min(k, f16), min(k.saturating_sub(f16), snorm8));
        let c = k.saturating_sub(f16 + snorm8);
        a * Precision::F16.words(count)
            + b * Precision::Snorm8.words(count)
            + c * Precision::Snorm4.words(count)
    }
}

const fn min(a: usize, b: usize) -> usize {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_within_half_a_step() {
        let values: Vec<f32> = (0..101).map(|i| (i as f32 / 50.0) - 1.0).collect();
        for precision in [Precision::F16, Precision::Snorm8, Precision::Snorm4] {
            let mut words = Vec::new();
            precision.pack(&values, &mut words);
            assert_eq!(words.len(), precision.words(values.len()));
            for (i, value) in values.iter().enumerate() {
                let error = (precision.unpack(&words, i) - value).abs();
                assert!(error <= 0.501 * precision.step(), "{precision:?} {value}: off by {error}");
            }
        }
    }

    #[test]
    fn lines_follow_each_other() {
        let ranks = Ranks { f16: 1, snorm8: 2, snorm4: 3 };
        let starts: Vec<usize> = (0..=6).map(|k| ranks.line_start(k, 9)).collect();
        assert_eq!(starts, [0, 5, 8, 11, 13, 15, 17]);
        assert_eq!(ranks.words(9), 17);
        let precisions: Vec<Precision> = (0..6).map(|k| ranks.precision(k)).collect();
        assert_eq!(precisions[..3], [Precision::F16, Precision::Snorm8, Precision::Snorm8]);
        assert_eq!(precisions[3..], [Precision::Snorm4; 3]);
    }
}
