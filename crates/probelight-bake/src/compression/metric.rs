//! The metric of a cluster's decomposition: the expected second moment of its signals.
//!
//! `M = S Wᵢ Sᵀ + D²`: S holds the signals under each lighting of the ensemble, W the lightings' weights, D
//! independent strengths of the signals. The latter is all there is in the plain and the band metric; in the
//! radiance metric it is a small floor, so that light which the ensemble never held is kept as well.

use faer::{Mat, Scale};

/// Lightings whose energy in a cluster is below this share of the mean count less.
const DIM_SHARE: f32 = 0.02;

/// Energy of the independent part of the radiance metric, as a share of the rest: what a narrow spot lights is a few
/// surfels, which the lightings that are drawn hardly ever light alone.
const FLOOR_SHARE: f32 = 0.2;

/// How much each lighting counts for a cluster in which it has the given energy: those dimmer than a share
/// `dim_share` of the mean by what they bring, brighter ones all the same.
pub(crate) fn lighting_weights(energies: &[f32], priors: &[f32], dim_share: f32) -> Vec<f32> {
    let mean = energies.iter().sum::<f32>() / energies.len().max(1) as f32;
    let weight = |(energy, prior): (&f32, &f32)| prior / (energy + dim_share * mean).max(f32::MIN_POSITIVE);
    energies.iter().zip(priors).map(weight).collect()
}

/// Least strength of a signal in the floor, as a share of the strongest's. Surfaces in a dark crevice light each other;
/// without it nothing would bound the error of that light, and each bounce could multiply it.
const LEAST_STRENGTH: f32 = 0.1;

/// Second moment of a cluster's signals.
pub(crate) struct SignalMetric {
    /// Independent strength D of each signal.
    strengths: Vec<f32>,
    /// √W S, signals by lightings.
    lit: Option<Mat<f32>>,
}

impl SignalMetric {
    /// All signals independent, each of its own strength.
    pub(crate) fn independent(strengths: Vec<f32>) -> Self {
        Self { strengths, lit: None }
    }

    /// Signals as lightings make them: `lit` has a row for each signal and a column for each lighting,
    /// `floor` the signals' independent strengths up to a common factor. `a` is the cluster's matrix.
    pub(crate) fn radiance(mut lit: Mat<f32>, priors: &[f32], mut floor: Vec<f32>, a: &Mat<f32>) -> Self {
        let least = LEAST_STRENGTH * floor.iter().copied().fold(0.0, f32::max);
        floor.iter_mut().for_each(|strength| *strength = strength.max(least));
        let arriving = a * &lit;
        let lightings = lit.ncols();
        let energy = |i: usize| arriving.col(i).iter().map(|e| e * e).sum::<f32>();
        let energies: Vec<f32> = (0..lightings).map(energy).collect();
        let weights = lighting_weights(&energies, priors, DIM_SHARE);
        for (i, weight) in weights.iter().enumerate() {
            let mut column = lit.col_mut(i);
            column *= Scale(weight.sqrt());
        }
        let lit_energy: f32 = energies.iter().zip(&weights).map(|(e, w)| e * w).sum();
        let floor_energy: f32 =
            (0..a.ncols()).map(|c| floor[c] * floor[c] * a.col(c).iter().map(|v| v * v).sum::<f32>()).sum();
        if lit_energy <= 0.0 {
            // None of the lightings gets here, so all light is unforeseen.
            let has_floor = floor_energy > 0.0;
            return Self::independent(if has_floor { floor } else { vec![1.0; a.ncols()] });
        }
        let factor = (FLOOR_SHARE * lit_energy / floor_energy.max(f32::MIN_POSITIVE)).sqrt();
        floor.iter_mut().for_each(|strength| *strength *= factor);
        Self { strengths: floor, lit: Some(lit) }
    }

    /// Whether the metric holds light as lightings make it.
    pub(crate) fn knows_the_light(&self) -> bool {
        self.lit.is_some()
    }

    /// Independent strength D of each signal.
    pub(crate) fn strengths(&self) -> &[f32] {
        &self.strengths
    }

    /// √W S, signals by lightings, if the metric has lightings.
    pub(crate) fn lit(&self) -> Option<&Mat<f32>> {
        self.lit.as_ref()
    }

    /// `A M Aᵀ`.
    pub(crate) fn gram(&self, a: &Mat<f32>) -> Mat<f64> {
        let scaled = Mat::from_fn(a.nrows(), a.ncols(), |r, c| a[(r, c)] * self.strengths[c]);
        let mut gram = &scaled * scaled.transpose();
        if let Some(lit) = &self.lit {
            let arriving = a * lit;
            gram += &arriving * arriving.transpose();
        }
        Mat::from_fn(gram.nrows(), gram.ncols(), |r, c| f64::from(gram[(r, c)]))
    }

    /// Diagonal of `A M Aᵀ`.
    pub(crate) fn row_energies(&self, a: &Mat<f32>) -> Vec<f64> {
        let squared = |v: f32| f64::from(v) * f64::from(v);
        let floor = |r: usize| (0..a.ncols()).map(|c| squared(a[(r, c)] * self.strengths[c])).sum::<f64>();
        let mut energies: Vec<f64> = (0..a.nrows()).map(floor).collect();
        if let Some(lit) = &self.lit {
            let arriving = a * lit;
            for (r, energy) in energies.iter_mut().enumerate() {
                *energy += arriving.row(r).iter().map(|e| squared(*e)).sum::<f64>();
            }
        }
        energies
    }

    /// The signals' mean squares.
    pub(crate) fn second_moments(&self) -> Vec<f32> {
        let lit =
            |c: usize| self.lit.as_ref().map_or(0.0, |lit| lit.row(c).iter().map(|v| v * v).sum::<f32>());
        self.strengths.iter().enumerate().map(|(c, d)| d * d + lit(c)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::sampling::Rng;

    const RECEIVERS: usize = 7;
    const SIGNALS: usize = 5;
    const LIGHTINGS: usize = 11;

    fn random(rows: usize, columns: usize, seed: u64) -> Mat<f32> {
        let mut rng = Rng::new(seed, 1);
        Mat::from_fn(rows, columns, |_, _| rng.next_f32())
    }

    fn floor() -> Vec<f32> {
        (1..=SIGNALS).map(|c| c as f32).collect()
    }

    fn trace(gram: &Mat<f64>) -> f64 {
        (0..gram.nrows()).map(|i| gram[(i, i)]).sum()
    }

    #[test]
    fn without_lightings_the_radiance_metric_is_the_independent_one() {
        let a = random(RECEIVERS, SIGNALS, 1);
        let independent = SignalMetric::independent(floor());
        let dark = SignalMetric::radiance(Mat::zeros(SIGNALS, 0), &[], floor(), &a);
        assert_eq!(dark.gram(&a), independent.gram(&a));
        assert_eq!(dark.second_moments(), independent.second_moments());
        // The same holds where the lightings bring nothing: a room that none of them lit.
        let unlit = SignalMetric::radiance(Mat::zeros(SIGNALS, LIGHTINGS), &[1.0; LIGHTINGS], floor(), &a);
        assert_eq!(unlit.gram(&a), independent.gram(&a));
        // Negative control: light makes a difference.
        let lit = SignalMetric::radiance(random(SIGNALS, LIGHTINGS, 2), &[1.0; LIGHTINGS], floor(), &a);
        assert_ne!(lit.gram(&a), independent.gram(&a));
    }

    #[test]
    fn signals_that_are_dark_under_every_lighting_still_count() {
        let a = random(RECEIVERS, SIGNALS, 1);
        let nothing =
            SignalMetric::radiance(Mat::zeros(SIGNALS, LIGHTINGS), &[1.0; LIGHTINGS], vec![0.0; SIGNALS], &a);
        assert!(trace(&nothing.gram(&a)) > 0.0);
    }

    #[test]
    fn the_floor_has_its_share_of_the_energy() {
        let a = random(RECEIVERS, SIGNALS, 1);
        let metric = SignalMetric::radiance(random(SIGNALS, LIGHTINGS, 2), &[1.0; LIGHTINGS], floor(), &a);
        let independent = SignalMetric::independent(metric.strengths.clone());
        let lit = trace(&metric.gram(&a)) - trace(&independent.gram(&a));
        let share = trace(&independent.gram(&a)) / lit;
        assert!((share / f64::from(FLOOR_SHARE) - 1.0).abs() < 1e-3, "{share}");
    }

    #[test]
    fn gram_and_moments_are_those_of_the_second_moment_matrix() {
        let a = random(RECEIVERS, SIGNALS, 1);
        let metric = SignalMetric::radiance(random(SIGNALS, LIGHTINGS, 2), &[1.0; LIGHTINGS], floor(), &a);
        // With A = identity, the Gram matrix is M itself.
        let m = metric.gram(&Mat::identity(SIGNALS, SIGNALS));
        for (c, moment) in metric.second_moments().iter().enumerate() {
            assert!((m[(c, c)] / f64::from(*moment) - 1.0).abs() < 1e-5);
        }
        let a = Mat::from_fn(RECEIVERS, SIGNALS, |r, c| f64::from(a[(r, c)]));
        let expected = &a * &m * a.transpose();
        let gram = metric.gram(&random(RECEIVERS, SIGNALS, 1));
        assert!((&gram - &expected).norm_l2() < 1e-5 * expected.norm_l2());
    }

    #[test]
    fn bright_lightings_count_no_more_than_others_and_dim_ones_by_what_they_bring() {
        let energies = [1e4, 1e4, 1e-4, 1.0];
        let weights = lighting_weights(&energies, &[1.0, 2.0, 1.0, 1.0], 1.0);
        let counted: Vec<f32> = energies.iter().zip(&weights).map(|(e, w)| e * w).collect();
        assert!((counted[1] / counted[0] - 2.0).abs() < 1e-5, "priors count");
        assert!(counted[0] < 1.0 && (counted[3] / counted[2] / 1e4 - 1.0).abs() < 1e-2);
    }
}
