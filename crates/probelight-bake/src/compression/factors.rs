//! A decomposition that is to be stored, and what storing it in few bits loses.

use faer::Mat;
use probelight_asset::packed::{EXPONENT_STEPS, Precision, column_factor};

use crate::compression::error_feedback::{ErrorFeedback, ROUNDING_VARIANCE};
use crate::compression::metric::SignalMetric;

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
    /// Energy of each row, and how much of it is noise.
    pub(crate) rows: &'a [RowEnergy],
}

impl Factors<'_> {
    /// Energy that the error is a share of.
    pub(crate) fn counted(&self) -> f64 {
        self.rows.iter().map(|row| row.counted).sum()
    }
}

/// Energy of a receiver's row in the metric.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RowEnergy {
    pub(crate) all: f64,
    /// Of this, what the gather rays' noise is expected to have.
    pub(crate) noise: f64,
    /// What its error is a share of: the row's own energy, or its part of all rows of a place.
    pub(crate) counted: f64,
}

/// What the bits of a cluster are weighed by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// Whether integers are allowed; else all values are half floats.
    pub(crate) is_packed: bool,
    /// Wanted relative error.
    pub(crate) error: f64,
    /// Whether more bits than eight are allowed where these miss it.
    pub(crate) must_be_met: bool,
    /// What a byte per receiver must save at least where that is out of reach: a share of the wanted error's energy.
    pub(crate) byte_price: f64,
}

/// Factors that bring all values into −1 to 1.
pub(crate) struct Scales {
    /// Per column of U.
    pub(crate) receivers: Vec<f32>,
    /// Per row of ΣVᵀ.
    pub(crate) rows: Vec<f32>,
    pub(crate) column_exponents: Vec<u8>,
}

/// How much finer the columns of strong signals are rounded: their scales fall with this power of the signals' root
/// mean squares. With 0 each column keeps its digits, with 1 all light is rounded to the same absolute step, and a
/// few strong columns leave none for the others. Between 0.1 and 0.4 the errors of four bits are within a tenth of
/// each other on cornell and atrium, and half of what they are with 0 or 0.6.
const STRENGTH_POWER: f32 = 0.3;

impl Scales {
    pub(crate) fn of(factors: &Factors<'_>, metric: &SignalMetric) -> Self {
        let (rank, columns) = (factors.w.nrows(), factors.w.ncols());
        let moments = metric.second_moments();
        let strongest = moments.iter().fold(f32::MIN_POSITIVE, |a, b| a.max(*b));
        let size = |c: usize| {
            let norm = (0..rank).map(|k| factors.w[(k, c)].powi(2)).sum::<f32>().sqrt();
            // A signal that is hardly ever on must not have the largest column.
            let strength = (moments[c] / strongest).max(1e-9).sqrt();
            norm.powf(1.0 - STRENGTH_POWER) * strength.powf(-STRENGTH_POWER)
        };
        let sizes: Vec<f32> = (0..columns).map(size).collect();
        let largest = sizes.iter().fold(f32::MIN_POSITIVE, |a, b| a.max(*b));
        let exponent = |size: &f32| ((-f32::from(EXPONENT_STEPS) * (size / largest).log2()).max(0.0)) as u8;
        let column_exponents: Vec<u8> = sizes.iter().map(exponent).collect();
        let largest_or_one = |values: &mut dyn Iterator<Item = f32>| {
            let largest = values.fold(0f32, |largest, value| largest.max(value.abs()));
            if largest > 0.0 { largest } else { 1.0 }
        };
        let row = |k| {
            let scaled = |(c, exponent): (usize, &u8)| factors.w[(k, c)] / column_factor(*exponent);
            largest_or_one(&mut column_exponents.iter().enumerate().map(scaled))
        };
        Self {
            receivers: (0..rank).map(|k| largest_or_one(&mut factors.u.col(k).iter().copied())).collect(),
            rows: (0..rank).map(row).collect(),
            column_exponents,
        }
    }
}

/// Energy that rounding each component to steps of 1 adds; it grows with the square of the step.
pub(crate) struct RoundingNoise {
    u: Vec<f64>,
    w: Vec<f64>,
}

impl RoundingNoise {
    pub(crate) fn of(factors: &Factors<'_>, scales: &Scales, feedback: &ErrorFeedback) -> Self {
        let squared = |v: f32| f64::from(v) * f64::from(v);
        let rows = factors.u.nrows() as f64;
        let of_column = feedback.rounding_energy();
        Self {
            u: factors
                .energies
                .iter()
                .zip(&scales.receivers)
                .map(|(energy, scale)| ROUNDING_VARIANCE * rows * squared(*scale) * energy)
                .collect(),
            w: scales.rows.iter().map(|scale| squared(*scale) * of_column).collect(),
        }
    }

    pub(crate) fn of_u(&self, k: usize, precision: Precision) -> f64 {
        self.u[k] * f64::from(precision.step()).powi(2)
    }

    pub(crate) fn of_w(&self, k: usize, precision: Precision) -> f64 {
        self.w[k] * f64::from(precision.step()).powi(2)
    }
}
