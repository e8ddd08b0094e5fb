//! Storing a decomposition in as few bits as its error allows.

use faer::Mat;
use probelight_asset::packed::{Precision, Ranks};
use serde::{Deserialize, Serialize};

/// U and ΣVᵀ of a cluster, and what each singular value is worth.
pub(crate) struct Factors<'a> {
    /// Orthonormal columns.
    pub(crate) u: &'a Mat<f32>,
    /// ΣVᵀ = Uᵀ A.
    pub(crate) w: &'a Mat<f32>,
    /// Energy of each component in the metric, descending.
    pub(crate) energies: &'a [f64],
    /// Energy that is lost if only the first k are kept, for every k.
    pub(crate) tails: &'a [f64],
    /// Energy of the whole matrix.
    pub(crate) total: f64,
}

/// Matrices in words, and how to read them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PackedFactors {
    /// How many singular values are kept, and how precisely.
    pub(crate) ranks: Ranks,
    /// U: one line of one value per receiver for each singular value.
    pub(crate) receiver_basis: Vec<u32>,
    /// ΣVᵀ: one line of one value per column of A for each singular value.
    pub(crate) signal_basis: Vec<u32>,
    /// One scale per row.
    pub(crate) row_scales: Vec<f32>,
    /// One scale per column, as an exponent.
    pub(crate) column_exponents: Vec<u8>,
    /// Relative error in the metric, of truncation and rounding together.
    pub(crate) error: f32,
}

/// Column exponents count eighths of octaves.
const STEPS_PER_OCTAVE: f32 = 8.0;

/// Packs the factors with the fewest bits that keep the relative error at `target`, or with the least error
/// if none does. `moments` are the signals' mean squares.
pub(crate) fn quantize(
    factors: &Factors<'_>,
    moments: &[f32],
    is_packed: bool,
    target: f64,
) -> PackedFactors {
    let scales = Scales::of(factors);
    let noise = RoundingNoise::of(factors, &scales, moments);
    let (ranks, energy) = choose_ranks(factors, &noise, is_packed, target);
    let mut packed = PackedFactors {
        ranks,
        column_exponents: scales.column_exponents.clone(),
        error: (energy / factors.total.max(f64::MIN_POSITIVE)).max(0.0).sqrt() as f32,
        ..PackedFactors::default()
    };
    let weights: Vec<f32> =
        moments.iter().enumerate().map(|(c, moment)| scales.column(c) * moment.sqrt()).collect();
    for k in 0..ranks.total() as usize {
        let precision = ranks.precision(k);
        let line: Vec<f32> = factors.u.col(k).iter().map(|u| u / scales.receivers[k]).collect();
        precision.pack(&line, &mut packed.receiver_basis);
        let mut line = scales.row(factors, k);
        if precision != Precision::F16 {
            line = carry_errors(&line, precision.step(), &weights);
        }
        precision.pack(&line, &mut packed.signal_basis);
        packed.row_scales.push(scales.rows[k] * scales.receivers[k]);
    }
    packed
}

/// A row rounded so that errors do not add up: what one column loses the next one gains, in proportion to their
/// signals' strengths (`weights`). Many small values of one sign would otherwise all become zero.
fn carry_errors(row: &[f32], step: f32, weights: &[f32]) -> Vec<f32> {
    let mut carried = 0.0;
    let rounded = row.iter().zip(weights).map(|(value, weight)| {
        if *weight <= 0.0 {
            return *value;
        }
        // A weak signal cannot make up for a strong one's error.
        let wanted = value + (carried / weight).clamp(-0.5 * step, 0.5 * step);
        let rounded = ((wanted / step).round() * step).clamp(-1.0, 1.0);
        carried += (value - rounded) * weight;
        rounded
    });
    rounded.collect()
}

/// Factors that bring all values into −1 to 1.
struct Scales {
    /// Per column of U.
    receivers: Vec<f32>,
    /// Per row of ΣVᵀ.
    rows: Vec<f32>,
    column_exponents: Vec<u8>,
}

impl Scales {
    fn of(factors: &Factors<'_>) -> Self {
        let (rank, columns) = (factors.w.nrows(), factors.w.ncols());
        // A column's norm: its strongest entries, most often those of the first row, decide.
        let share = |c: usize| (0..rank).map(|k| factors.w[(k, c)].powi(2)).sum::<f32>().sqrt();
        let shares: Vec<f32> = (0..columns).map(share).collect();
        let largest = shares.iter().fold(f32::MIN_POSITIVE, |a, b| a.max(*b));
        let exponent = |share: &f32| ((-STEPS_PER_OCTAVE * (share / largest).log2()).max(0.0)) as u8;
        let mut scales = Self {
            receivers: Vec::new(),
            rows: Vec::new(),
            column_exponents: shares.iter().map(exponent).collect(),
        };
        let largest_or_one = |values: &mut dyn Iterator<Item = f32>| {
            let largest = values.fold(0f32, |largest, value| largest.max(value.abs()));
            if largest > 0.0 { largest } else { 1.0 }
        };
        for k in 0..rank {
            scales.receivers.push(largest_or_one(&mut factors.u.col(k).iter().copied()));
            let row = &mut (0..columns).map(|c| factors.w[(k, c)] / scales.column(c));
            scales.rows.push(largest_or_one(row));
        }
        scales
    }

    /// Row k of ΣVᵀ, scaled.
    fn row(&self, factors: &Factors<'_>, k: usize) -> Vec<f32> {
        (0..factors.w.ncols()).map(|c| factors.w[(k, c)] / (self.rows[k] * self.column(c))).collect()
    }

    fn column(&self, c: usize) -> f32 {
        (-f32::from(self.column_exponents[c]) / STEPS_PER_OCTAVE).exp2()
    }
}

/// Energy that rounding each component to steps of 1 adds; it grows with the square of the step.
struct RoundingNoise(Vec<f64>);

impl RoundingNoise {
    fn of(factors: &Factors<'_>, scales: &Scales, moments: &[f32]) -> Self {
        // The variance of rounding to steps of 1. Values of ΣVᵀ also carry the error of the one before.
        const VARIANCE: f64 = 1.0 / 12.0;
        let squared = |v: f32| f64::from(v) * f64::from(v);
        let columns: f64 =
            moments.iter().enumerate().map(|(c, m)| squared(scales.column(c)) * f64::from(*m)).sum();
        let of_component = |k: usize| {
            let of_u = factors.u.nrows() as f64 * squared(scales.receivers[k]) * factors.energies[k];
            let of_w = squared(scales.rows[k]) * columns;
            VARIANCE * (of_u + 2.0 * of_w)
        };
        Self((0..factors.energies.len()).map(of_component).collect())
    }

    fn at(&self, k: usize, precision: Precision) -> f64 {
        self.0[k] * f64::from(precision.step()).powi(2)
    }
}

/// What a byte per receiver must save at least where the target is out of reach: a share of the target's energy.
const BYTE_PRICE: f64 = 0.1;

/// The cheapest ranks within the target; where none are, those beyond which more bytes are not worth it. And the
/// energy of their error.
fn choose_ranks(factors: &Factors<'_>, noise: &RoundingNoise, is_packed: bool, target: f64) -> (Ranks, f64) {
    let most = factors.energies.len();
    let accepted = target * target * factors.total;
    let tail = |kept: usize| factors.tails[kept];
    if !is_packed {
        let rank = (0..=most).find(|rank| tail(*rank) <= accepted).unwrap_or(most);
        let rounding: f64 = (0..rank).map(|k| noise.at(k, Precision::F16)).sum();
        return (Ranks { f16: rank as u32, ..Ranks::default() }, tail(rank) + rounding);
    }
    let (rows, columns) = (factors.u.nrows(), factors.w.ncols());
    // A bit of a singular value is one for each row of U and each column of ΣVᵀ.
    let bit_price = BYTE_PRICE * accepted * (rows + columns) as f64 / (8 * rows.max(1)) as f64;
    let mut best = (Ranks::default(), factors.total);
    let mut lowest_cost = (true, f64::INFINITY);
    for total in 0..=most {
        let mut energy = tail(total) + (0..total).map(|k| noise.at(k, Precision::Snorm4)).sum::<f64>();
        for fine in 0..=total {
            if fine > 0 {
                energy += noise.at(fine - 1, Precision::Snorm8) - noise.at(fine - 1, Precision::Snorm4);
            }
            let price = bit_price * (8 * fine + 4 * (total - fine)) as f64;
            let misses = energy > accepted;
            let cost = (misses, if misses { energy + price } else { price });
            if cost < lowest_cost {
                lowest_cost = cost;
                best = (Ranks { f16: 0, snorm8: fine as u32, snorm4: (total - fine) as u32 }, energy);
            }
        }
    }
    best
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use probelight_math::sampling::Rng;
    use std::f32::consts::PI;

    /// U·ΣVᵀ as a runtime reads it.
    pub(crate) fn unpacked(packed: &PackedFactors, receivers: usize, columns: usize) -> Mat<f32> {
        let ranks = packed.ranks;
        let lines = |words: &[u32], count: usize| {
            Mat::from_fn(ranks.total() as usize, count, |k, i| {
                ranks.precision(k).unpack(&words[ranks.line_start(k, count)..], i)
            })
        };
        let (u, w) = (lines(&packed.receiver_basis, receivers), lines(&packed.signal_basis, columns));
        let scale = |k: usize, c: usize| {
            packed.row_scales[k] * (-f32::from(packed.column_exponents[c]) / STEPS_PER_OCTAVE).exp2()
        };
        let w = Mat::from_fn(w.nrows(), columns, |k, c| w[(k, c)] * scale(k, c));
        u.transpose() * w
    }

    const RECEIVERS: usize = 150;
    const COLUMNS: usize = 90;
    const COMPONENTS: usize = 24;

    /// A matrix A = U·W whose components become weaker by a constant factor, and the signals' mean squares.
    struct Sample {
        u: Mat<f32>,
        w: Mat<f32>,
        moments: Vec<f32>,
        energies: Vec<f64>,
        tails: Vec<f64>,
    }

    impl Sample {
        fn new(falloff: f32) -> Self {
            // Cosines, which are orthonormal.
            let cosine = |r: usize, k: usize| {
                let angle = PI * (r as f32 + 0.5) * (k + 1) as f32 / RECEIVERS as f32;
                (2.0 / RECEIVERS as f32).sqrt() * angle.cos()
            };
            let mut rng = Rng::new(2, 3);
            let moments: Vec<f32> = (0..COLUMNS).map(|_| 0.1 + 4.0 * rng.next_f32()).collect();
            // Some columns are far weaker than others.
            let reach: Vec<f32> = (0..COLUMNS).map(|_| (-6.0 * rng.next_f32()).exp2()).collect();
            let w = Mat::from_fn(COMPONENTS, COLUMNS, |k, c| {
                falloff.powi(k as i32) * reach[c] * (rng.next_f32() - 0.5)
            });
            let energies: Vec<f64> = (0..COMPONENTS)
                .map(|k| (0..COLUMNS).map(|c| f64::from(w[(k, c)]).powi(2) * f64::from(moments[c])).sum())
                .collect();
            let tails = (0..=COMPONENTS).map(|k| energies[k..].iter().sum()).collect();
            Self { u: Mat::from_fn(RECEIVERS, COMPONENTS, cosine), w, moments, energies, tails }
        }

        fn quantize(&self, is_packed: bool, target: f64) -> PackedFactors {
            let factors = Factors {
                u: &self.u,
                w: &self.w,
                energies: &self.energies,
                tails: &self.tails,
                total: self.tails[0],
            };
            quantize(&factors, &self.moments, is_packed, target)
        }

        /// Relative error of packed factors in the metric, compared value by value.
        fn error_of(&self, packed: &PackedFactors) -> f64 {
            let difference = &self.u * &self.w - unpacked(packed, RECEIVERS, COLUMNS);
            let energy = |c: usize| {
                let squared = difference.col(c).iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
                squared * f64::from(self.moments[c])
            };
            ((0..COLUMNS).map(energy).sum::<f64>() / self.tails[0]).sqrt()
        }
    }

    /// Whether a reported error bounds the real one and is near it. Rounding is predicted by the variance of
    /// uniform errors; values far below a step err by less.
    fn is_plausible(real: f64, reported: f64) -> bool {
        (0.85..=1.02).contains(&(real / reported))
    }

    #[test]
    fn the_target_is_met_where_it_can_be_and_the_reported_error_is_real() {
        for (falloff, target) in [(0.5, 0.02), (0.7, 0.05), (0.8, 0.1), (0.9, 0.3)] {
            let sample = Sample::new(falloff);
            for is_packed in [false, true] {
                let packed = sample.quantize(is_packed, target);
                let (reported, real) = (f64::from(packed.error), sample.error_of(&packed));
                assert!(reported <= target * 1.001, "{falloff} {is_packed}: {reported} for {target}");
                assert!(is_plausible(real, reported), "{falloff} {is_packed}: {real}, not {reported}");
            }
        }
    }

    #[test]
    fn where_the_target_is_out_of_reach_bytes_that_save_little_are_left_out() {
        let sample = Sample::new(0.8);
        let packed = sample.quantize(true, 1e-4);
        let (reported, real) = (f64::from(packed.error), sample.error_of(&packed));
        assert!(real > 1e-3 && is_plausible(real, reported), "{real}, not {reported}");
        assert_eq!(packed.ranks.snorm4, 0, "against this target four bits are never worth their error");
        // Negative control: the comparison sees a value that is off by half its range.
        let mut wrong = packed;
        wrong.signal_basis[0] ^= 0x40;
        assert!(!is_plausible(sample.error_of(&wrong), reported));
        // A target that is barely missed is worth less.
        let slow = Sample::new(0.97);
        let ranks = [1e-4, 0.2].map(|target| slow.quantize(true, target).ranks.total());
        assert!(ranks[1] < ranks[0] && ranks[0] == COMPONENTS as u32, "{ranks:?}");
    }

    #[test]
    fn many_small_values_of_one_sign_keep_their_sum() {
        let row = vec![0.002; 500];
        let rounded = carry_errors(&row, Precision::Snorm8.step(), &[1.0; 500]);
        assert!((rounded.iter().sum::<f32>() - 1.0).abs() < Precision::Snorm8.step());
        // Negative control: each rounded by itself, they vanish.
        assert!(row.iter().all(|value| value / Precision::Snorm8.step() < 0.5));
    }

    #[test]
    fn wider_targets_take_fewer_bits() {
        let sample = Sample::new(0.8);
        let words = |target| {
            let packed = sample.quantize(true, target);
            packed.receiver_basis.len() + packed.signal_basis.len()
        };
        let sizes = [0.02, 0.05, 0.1, 0.3, 1.0].map(words);
        assert!(sizes.is_sorted_by(|a, b| a > b) && sizes[4] == 0, "{sizes:?}");
        assert!(sample.quantize(true, 0.1).ranks.snorm4 > 0);
    }
}
