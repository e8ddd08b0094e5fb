//! Storing a decomposition in as few bits as its error allows.

use probelight_asset::ERROR_STEPS;
use probelight_asset::packed::{Precision, Ranks, column_factor};
use serde::{Deserialize, Serialize};

use crate::compression::error_feedback::ErrorFeedback;
use crate::compression::factors::{Aim, Factors, RoundingNoise, RowEnergy, Scales};
use crate::compression::metric::SignalMetric;
use crate::compression::ranks::choose_ranks;

/// Matrices in words, and how to read them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PackedFactors {
    /// How many singular values are kept, and how precisely in U.
    pub(crate) receiver_ranks: Ranks,
    /// How precisely in ΣVᵀ.
    pub(crate) signal_ranks: Ranks,
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
    /// Each receiver's relative error, as [`probelight_asset::BakedParts::receiver_errors`] has it.
    pub(crate) receiver_errors: Vec<u8>,
}

impl PackedFactors {
    /// Size of U and ΣVᵀ, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.receiver_basis[..]) + size_of_val(&self.signal_basis[..])
    }
}

/// Packs the factors with the fewest bits that keep the wanted error; where none do, those beyond which more bytes
/// are not worth it.
pub(crate) fn quantize(factors: &Factors<'_>, metric: &SignalMetric, aim: Aim) -> PackedFactors {
    let scales = Scales::of(factors, metric);
    let columns: Vec<f32> = scales.column_exponents.iter().copied().map(column_factor).collect();
    let feedback = ErrorFeedback::new(metric, &columns);
    let noise = RoundingNoise::of(factors, &scales, &feedback);
    let (receiver_ranks, signal_ranks) = choose_ranks(factors, &noise, aim);
    let mut packed = PackedFactors {
        receiver_ranks,
        signal_ranks,
        column_exponents: scales.column_exponents.clone(),
        ..PackedFactors::default()
    };
    let rank = receiver_ranks.total() as usize;
    let mut energy = factors.tails[rank];
    let mut rows = RowErrors::new(factors, rank);
    for k in 0..rank {
        let precision = receiver_ranks.precision(k);
        let line: Vec<f32> = factors.u.col(k).iter().map(|u| u / scales.receivers[k]).collect();
        precision.pack(&line, &mut packed.receiver_basis);
        energy += noise.of_u(k, precision);
        rows.add_rounding_of_u(noise.of_u(k, precision));
        let precision = signal_ranks.precision(k);
        let mut line: Vec<f32> = columns
            .iter()
            .enumerate()
            .map(|(c, factor)| factors.w[(k, c)] / (scales.rows[k] * factor))
            .collect();
        let rounding = if precision == Precision::F16 {
            noise.of_w(k, precision)
        } else {
            let rounded = feedback.round(&line, precision.step());
            line = rounded.0;
            rounded.1 * f64::from(scales.rows[k]).powi(2)
        };
        energy += rounding;
        rows.add_rounding_of_w(factors, k, rounding);
        precision.pack(&line, &mut packed.signal_basis);
        packed.row_scales.push(scales.rows[k] * scales.receivers[k]);
    }
    packed.error = (energy / factors.counted().max(f64::MIN_POSITIVE)).max(0.0).sqrt() as f32;
    packed.receiver_errors = rows.in_steps(factors, aim.error);
    packed
}

/// Energy of what each receiver loses.
struct RowErrors(Vec<f64>);

impl RowErrors {
    /// By truncation to `rank` components. Of the noise they keep as much as of any random row.
    fn new(factors: &Factors<'_>, rank: usize) -> Self {
        let lost = |(r, row): (usize, &RowEnergy)| {
            let squared = |k: usize| f64::from(factors.u[(r, k)]).powi(2);
            let kept: f64 = (0..rank).map(|k| squared(k) * factors.energies[k]).sum();
            let kept_noise: f64 = (0..rank).map(squared).sum();
            (row.all - kept - (1.0 - kept_noise) * row.noise).max(0.0)
        };
        Self(factors.rows.iter().enumerate().map(lost).collect())
    }

    /// Adds what a column of U loses, all rows alike.
    fn add_rounding_of_u(&mut self, energy: f64) {
        let share = energy / self.0.len() as f64;
        self.0.iter_mut().for_each(|lost| *lost += share);
    }

    /// Adds what row k of ΣVᵀ loses, as far as U passes it on.
    fn add_rounding_of_w(&mut self, factors: &Factors<'_>, k: usize, energy: f64) {
        for (lost, u) in self.0.iter_mut().zip(factors.u.col(k).iter()) {
            *lost += f64::from(u * u) * energy;
        }
    }

    fn in_steps(&self, factors: &Factors<'_>, target: f64) -> Vec<u8> {
        let steps = |(lost, row): (&f64, &RowEnergy)| {
            let light = (row.counted - row.noise).max(f64::MIN_POSITIVE);
            let error = (lost / light).sqrt() / target;
            // Casts end at 255.
            (f64::from(ERROR_STEPS) * error).round() as u8
        };
        self.0.iter().zip(factors.rows).map(steps).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use faer::Mat;
    use probelight_math::sampling::Rng;
    use std::f32::consts::PI;

    /// U·ΣVᵀ as a runtime reads it.
    pub(crate) fn unpacked(packed: &PackedFactors, receivers: usize, columns: usize) -> Mat<f32> {
        let lines = |ranks: Ranks, words: &[u32], count: usize| {
            Mat::from_fn(ranks.total() as usize, count, |k, i| {
                ranks.precision(k).unpack(&words[ranks.line_start(k, count)..], i)
            })
        };
        let u = lines(packed.receiver_ranks, &packed.receiver_basis, receivers);
        let w = lines(packed.signal_ranks, &packed.signal_basis, columns);
        let scale = |k: usize, c: usize| packed.row_scales[k] * column_factor(packed.column_exponents[c]);
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

        /// Without noise.
        fn rows(&self) -> Vec<RowEnergy> {
            let energy = |r: usize| {
                (0..COMPONENTS).map(|k| f64::from(self.u[(r, k)]).powi(2) * self.energies[k]).sum::<f64>()
            };
            (0..RECEIVERS).map(|r| RowEnergy { all: energy(r), noise: 0.0, counted: energy(r) }).collect()
        }

        fn quantize(&self, is_packed: bool, target: f64, byte_price: f64) -> PackedFactors {
            let factors = Factors {
                u: &self.u,
                w: &self.w,
                energies: &self.energies,
                tails: &self.tails,
                rows: &self.rows(),
            };
            let metric = SignalMetric::independent(self.moments.iter().map(|m| m.sqrt()).collect());
            let aim = Aim { is_packed, error: target, must_be_met: false, byte_price };
            quantize(&factors, &metric, aim)
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

    /// What a byte must save where nothing else is said.
    const PRICE: f64 = 0.44;

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
                let packed = sample.quantize(is_packed, target, 1e-6);
                let (reported, real) = (f64::from(packed.error), sample.error_of(&packed));
                assert!(reported <= target * 1.001, "{falloff} {is_packed}: {reported} for {target}");
                assert!(is_plausible(real, reported), "{falloff} {is_packed}: {real}, not {reported}");
            }
        }
    }

    #[test]
    fn where_the_target_is_out_of_reach_bytes_that_save_little_are_left_out() {
        let sample = Sample::new(0.8);
        let packed = sample.quantize(true, 1e-4, PRICE);
        let (reported, real) = (f64::from(packed.error), sample.error_of(&packed));
        assert!(real > 1e-3 && is_plausible(real, reported), "{real}, not {reported}");
        assert_eq!(
            packed.signal_ranks.snorm4, 0,
            "against this target four bits are never worth their error"
        );
        // Negative control: the comparison sees a value that is off by half its range.
        let mut wrong = packed;
        wrong.signal_basis[0] ^= 0x40;
        assert!(!is_plausible(sample.error_of(&wrong), reported));
        // A target that is barely missed is worth less.
        let slow = Sample::new(0.97);
        let ranks = [1e-4, 0.2].map(|target| slow.quantize(true, target, PRICE).receiver_ranks.total());
        assert!(ranks[1] < ranks[0] && ranks[0] == COMPONENTS as u32, "{ranks:?}");
    }

    #[test]
    fn wider_targets_take_fewer_bits() {
        let sample = Sample::new(0.8);
        let words = |target| {
            let packed = sample.quantize(true, target, PRICE);
            packed.receiver_basis.len() + packed.signal_basis.len()
        };
        let sizes = [0.02, 0.05, 0.1, 0.3, 1.0].map(words);
        assert!(sizes.is_sorted_by(|a, b| a > b) && sizes[4] == 0, "{sizes:?}");
        assert!(sample.quantize(true, 0.1, PRICE).signal_ranks.snorm4 > 0);
    }
}
