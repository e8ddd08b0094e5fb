//! The metric of a cluster's decomposition: the expected second moment of its signals.
//!
//! `M = S Wᵢ Sᵀ + D²`: S holds the signals under each lighting of the ensemble, W the lightings' weights, D
//! independent strengths of the signals. The latter is all there is in the plain and the band metric; in the
//! radiance metric it is a small floor, so that light which the ensemble never held is kept as well.

use faer::{Mat, Scale};

/// Share of the energy that the independent part of the radiance metric has.
const FLOOR_SHARE: f32 = 0.05;

/// How much each lighting counts for a cluster in which it has the given energy: dim ones by what they bring,
/// bright ones all the same.
pub(crate) fn lighting_weights(energies: &[f32], priors: &[f32]) -> Vec<f32> {
    let mean = energies.iter().sum::<f32>() / energies.len().max(1) as f32;
    let weight = |(energy, prior): (&f32, &f32)| prior / (energy + mean).max(f32::MIN_POSITIVE);
    energies.iter().zip(priors).map(weight).collect()
}

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
        let arriving = a * &lit;
        let lightings = lit.ncols();
        let energy = |i: usize| arriving.col(i).iter().map(|e| e * e).sum::<f32>();
        let energies: Vec<f32> = (0..lightings).map(energy).collect();
        let weights = lighting_weights(&energies, priors);
        for (i, weight) in weights.iter().enumerate() {
            let mut column = lit.col_mut(i);
            column *= Scale(weight.sqrt());
        }
        let lit_energy: f32 = energies.iter().zip(&weights).map(|(e, w)| e * w).sum();
        let floor_energy: f32 = (0..a.ncols())
            .map(|c| floor[c] * floor[c] * a.col(c).iter().map(|v| v * v).sum::<f32>())
            .sum();
        let factor = (FLOOR_SHARE * lit_energy / floor_energy.max(f32::MIN_POSITIVE)).sqrt();
        floor.iter_mut().for_each(|strength| *strength *= factor);
        Self { strengths: floor, lit: Some(lit) }
    }

    /// Whether the metric holds light as lightings make it.
    pub(crate) fn knows_the_light(&self) -> bool {
        self.lit.is_some()
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

    /// The signals' mean squares.
    pub(crate) fn second_moments(&self) -> Vec<f32> {
        let lit = |c: usize| {
            self.lit.as_ref().map_or(0.0, |lit| lit.row(c).iter().map(|v| v * v).sum::<f32>())
        };
        self.strengths.iter().enumerate().map(|(c, d)| d * d + lit(c)).collect()
    }
}
