//! Rounding so that errors cancel: what one column of ΣVᵀ loses, others gain.
//!
//! Signals go up and down together, as the light does, so an error in one column can be made up for in others.
//! Columns are rounded one after the other, the strongest first; each aims at what is best after the errors so far,
//! given that the columns still to come will do their best, too. That is the nearest-plane rounding of Babai 1986 in
//! the metric of the decomposition, `M = S Sᵀ + D²`. Since S has few columns, the triangular factor of M is never
//! formed: each step is one of a recursive least-squares estimate.

use crate::compression::metric::SignalMetric;
use crate::light::ensemble::add_scaled;

/// How many times the independent strengths D² count. The lightings are but a sample of the light that will be, and
/// rounding errors that cancel under them show under other light, most of all where it is dim: with 1, atrium takes a
/// tenth fewer bytes, but a flower pot in the shade turns black while the sun shines beside it.
const UNFORESEEN: f32 = 4.0;

/// Variance of the errors of rounding to steps of 1.
pub(crate) const ROUNDING_VARIANCE: f64 = 1.0 / 12.0;

/// What rounding one column does to the others.
pub(crate) struct ErrorFeedback {
    /// Columns in the order of rounding, the strongest first.
    order: Vec<u32>,
    /// Number of lightings.
    lightings: usize,
    /// Per column and lighting: the scaled signal.
    lit: Vec<f32>,
    /// Per column: square of the scaled independent strength.
    floors: Vec<f32>,
    /// How many times these count for where errors go.
    floor_factor: f32,
    /// Per column and lighting: how far the column must move to make up for an error of 1, times `stiffness`.
    responses: Vec<f32>,
    /// Per column: energy of an error of 1 after all weaker columns have made up for it.
    stiffness: Vec<f32>,
    /// Whether the lightings count as energy; else they only see to it that sums are kept.
    counts_lightings: bool,
}

impl ErrorFeedback {
    /// For columns whose values are multiplied by `scales`.
    pub(crate) fn new(metric: &SignalMetric, scales: &[f32]) -> Self {
        let columns = scales.len();
        // A metric without lightings gets one in which all signals are on, so that many small values of one sign do
        // not all become zero.
        let lightings = metric.lit().map_or(1, |lit| lit.ncols());
        let value = |c: usize, i: usize| metric.lit().map_or(metric.strengths()[c], |lit| lit[(c, i)]);
        let lit: Vec<f32> = (0..columns)
            .flat_map(|c| (0..lightings).map(move |i| (c, i)))
            .map(|(c, i)| scales[c] * value(c, i))
            .collect();
        let floors = scales.iter().zip(metric.strengths()).map(|(scale, d)| (scale * d).powi(2)).collect();
        let mut feedback = Self {
            order: Vec::new(),
            lightings,
            lit,
            floors,
            floor_factor: if metric.lit().is_some() { UNFORESEEN } else { 1.0 },
            responses: vec![0.0; columns * lightings],
            stiffness: vec![0.0; columns],
            counts_lightings: metric.lit().is_some(),
        };
        let energy = |c: &u32| {
            let c = *c as usize;
            feedback.floors[c] + feedback.lit(c).iter().map(|v| v * v).sum::<f32>()
        };
        let mut order: Vec<u32> = (0..columns as u32).collect();
        order.sort_by(|a, b| energy(b).total_cmp(&energy(a)).then(a.cmp(b)));
        feedback.order = order;
        feedback.find_responses();
        feedback
    }

    fn lit(&self, column: usize) -> &[f32] {
        &self.lit[column * self.lightings..][..self.lightings]
    }

    /// Starting with the weakest column: `left` is what remains of the lightings' errors when the columns so far have
    /// made up for them, (1 + Σ b bᵀ / d²)⁻¹ over their lit values b and weighted floors d².
    fn find_responses(&mut self) {
        let count = self.lightings;
        let mut left = vec![0.0; count * count];
        left.iter_mut().step_by(count + 1).for_each(|v| *v = 1.0);
        for place in (0..self.order.len()).rev() {
            let c = self.order[place] as usize;
            let mut response = vec![0.0; count];
            for (row, b) in left.chunks_exact(count).zip(self.lit(c)) {
                add_scaled(&mut response, *b, row);
            }
            let stiffness = self.floor_factor * self.floors[c] + dot(&response, self.lit(c));
            if stiffness > 0.0 {
                for (row, factor) in left.chunks_exact_mut(count).zip(&response) {
                    add_scaled(row, -factor / stiffness, &response);
                }
            }
            self.responses[c * count..][..count].copy_from_slice(&response);
            self.stiffness[c] = stiffness;
        }
    }

    /// Expected energy of the errors that rounding to steps of 1 leaves, unforeseen light counted as above.
    pub(crate) fn rounding_energy(&self) -> f64 {
        ROUNDING_VARIANCE * self.stiffness.iter().map(|s| f64::from(*s)).sum::<f64>()
    }

    /// A row with its values rounded to multiples of `step` between −1 and 1, and the energy of its errors in the metric.
    pub(crate) fn round(&self, row: &[f32], step: f32) -> (Vec<f32>, f64) {
        let mut rounded = vec![0.0; row.len()];
        // What the errors so far amount to under each lighting.
        let mut errors = vec![0.0; self.lightings];
        let mut energy = 0.0;
        for c in self.order.iter().map(|c| *c as usize) {
            let make_up = if self.stiffness[c] > 0.0 {
                dot(&self.responses[c * self.lightings..][..self.lightings], &errors) / self.stiffness[c]
            } else {
                0.0
            };
            rounded[c] = (((row[c] - make_up) / step).round() * step).clamp(-1.0, 1.0);
            let error = rounded[c] - row[c];
            add_scaled(&mut errors, error, self.lit(c));
            energy += f64::from(error * error * self.floors[c]);
        }
        if self.counts_lightings {
            energy += errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>();
        }
        (rounded, energy)
    }
}

fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use probelight_math::sampling::Rng;

    const COLUMNS: usize = 120;
    const LIGHTINGS: usize = 15;
    const STEP: f32 = 1.0 / 7.0;

    fn random_row(rng: &mut Rng) -> Vec<f32> {
        (0..COLUMNS).map(|_| 1.6 * rng.next_f32() - 0.8).collect()
    }

    /// Signals that go up and down together.
    fn metric(rng: &mut Rng) -> SignalMetric {
        let lit = Mat::from_fn(COLUMNS, LIGHTINGS, |_, _| rng.next_f32());
        let transport = Mat::from_fn(8, COLUMNS, |_, _| rng.next_f32() - 0.5);
        SignalMetric::radiance(lit, &[1.0; LIGHTINGS], vec![1.0; COLUMNS], &transport)
    }

    /// Energy of a row's errors, value by value.
    fn energy(metric: &SignalMetric, errors: &[f32]) -> f64 {
        let row = Mat::from_fn(1, COLUMNS, |_, c| errors[c]);
        metric.gram(&row)[(0, 0)]
    }

    fn nearest(row: &[f32]) -> Vec<f32> {
        row.iter().map(|v| (v / STEP).round() * STEP).collect()
    }

    #[test]
    fn errors_under_light_that_occurs_cancel() {
        let mut rng = Rng::new(4, 5);
        let metric = metric(&mut rng);
        let feedback = ErrorFeedback::new(&metric, &[1.0; COLUMNS]);
        let (mut fed_back, mut weighted, mut plain, mut expected) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..20 {
            let row = random_row(&mut rng);
            let (rounded, reported) = feedback.round(&row, STEP);
            let difference = |to: &[f32]| -> Vec<f32> { to.iter().zip(&row).map(|(a, b)| a - b).collect() };
            let real = energy(&metric, &difference(&rounded));
            assert!((real / reported - 1.0).abs() < 1e-3, "{real}, not {reported}");
            assert!(rounded.iter().all(|v| (v / STEP - (v / STEP).round()).abs() < 1e-4 && v.abs() <= 1.0));
            fed_back += real;
            let unforeseen = |(d, error): (&f32, f32)| f64::from(d * error).powi(2);
            let floor: f64 = metric.strengths().iter().zip(difference(&rounded)).map(unforeseen).sum();
            weighted += real + f64::from(UNFORESEEN - 1.0) * floor;
            plain += energy(&metric, &difference(&nearest(&row)));
            expected += feedback.rounding_energy() * f64::from(STEP * STEP);
        }
        assert!(fed_back < 0.2 * plain, "{fed_back} against {plain}");
        assert!((0.8..1.25).contains(&(weighted / expected)), "{weighted}, expected {expected}");
    }

    #[test]
    fn without_lightings_sums_are_kept() {
        let strengths = vec![1.0; 500];
        let feedback = ErrorFeedback::new(&SignalMetric::independent(strengths), &[1.0; 500]);
        let row = vec![0.02; 500];
        let (rounded, energy) = feedback.round(&row, STEP);
        assert!((rounded.iter().sum::<f32>() - 10.0).abs() < 4.0 * STEP);
        let squared: f32 = rounded.iter().zip(&row).map(|(a, b)| (a - b) * (a - b)).sum();
        assert!((f64::from(squared) / energy - 1.0).abs() < 1e-4);
        // Negative control: each rounded by itself, they vanish.
        assert!(nearest(&row).iter().all(|value| *value == 0.0));
    }

    #[test]
    fn signals_that_are_never_lit_are_rounded_by_themselves() {
        let feedback = ErrorFeedback::new(&SignalMetric::independent(vec![0.0; 3]), &[1.0; 3]);
        let (rounded, energy) = feedback.round(&[0.1, -0.3, 2.0], 0.25);
        assert_eq!((rounded, energy), (vec![0.0, -0.25, 1.0], 0.0));
    }
}
