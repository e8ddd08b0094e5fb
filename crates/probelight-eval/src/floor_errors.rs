//! How much of an error no lightmap of the same texels could avoid.

use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use serde::Serialize;

use crate::point_errors::selected_rows;
use crate::{EvalError, PointSelection, ReferencePoints};

/// The error of an ideal lightmap, in which each texel holds the mean of the irradiance on its surface, and what
/// predictions differ from it: the light transport's own error. E is the luminance of irradiance, W/m²; all are shares of
/// the reference (0.05 is 5 %), absent where it is black.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FloorErrors {
    /// Selected rows with a prediction and an ideal one: the rows all figures are about.
    pub compared: usize,
    /// √(mean (E_ideal − E_ref)²) / √(mean E_ref²), the noise of both subtracted.
    pub floor: Option<f64>,
    /// mean (E_ideal − E_ref) / mean E_ref.
    pub floor_bias: Option<f64>,
    /// √(mean (E − E_ideal)²) / √(mean E_ref²), the ideal lightmap's noise subtracted.
    pub above_floor: Option<f64>,
    /// mean (E − E_ideal) / mean E_ref.
    pub above_floor_bias: Option<f64>,
}

impl FloorErrors {
    /// Compares the selected rows. Each row has two ideal predictions whose noise is independent of each other: the mean of
    /// the product of two differences is free of it.
    ///
    /// # Errors
    /// [`EvalError::Mismatch`] if there is not one entry per row, or a prediction is not finite.
    pub fn measure(
        reference: &ReferencePoints,
        predictions: &[Option<Vec3>],
        ideal: &[Vec<Option<Vec3>>; 2],
        selection: &PointSelection,
    ) -> Result<Self, EvalError> {
        let light = |e: Option<Vec3>| e.map(|e| f64::from(luminance(e)));
        let rows = selected_rows(reference, predictions, selection)?;
        let first = selected_rows(reference, &ideal[0], selection)?;
        let second = selected_rows(reference, &ideal[1], selection)?;
        let rows = rows.into_iter().zip(first).zip(second).filter_map(|(((point, ours), (_, a)), (_, b))| {
            Some(Row {
                ours: light(ours)?,
                ideal: [light(a)?, light(b)?],
                reference: f64::from(luminance(point.compared_irradiance())),
                noise_variance: point.luminance_variance(),
            })
        });
        Ok(Self::of(&rows.collect::<Vec<Row>>()))
    }

    fn of(rows: &[Row]) -> Self {
        let mean =
            |value: &dyn Fn(&Row) -> f64| rows.iter().map(value).sum::<f64>() / rows.len().max(1) as f64;
        let light = mean(&|row| row.reference);
        let square = mean(&|row| row.reference.powi(2));
        let root = |squared: f64| (square > 0.0).then(|| (squared.max(0.0) / square).sqrt());
        let share = |bias: f64| (light > 0.0).then(|| bias / light);
        Self {
            compared: rows.len(),
            floor: root(mean(&|row| {
                row.ideal.iter().map(|ideal| ideal - row.reference).product::<f64>() - row.noise_variance
            })),
            floor_bias: share(mean(&|row| row.ideal_mean() - row.reference)),
            above_floor: root(mean(&|row| row.ideal.iter().map(|ideal| row.ours - ideal).product())),
            above_floor_bias: share(mean(&|row| row.ours - row.ideal_mean())),
        }
    }
}

/// Luminances at one point.
struct Row {
    ours: f64,
    ideal: [f64; 2],
    reference: f64,
    noise_variance: f64,
}

impl Row {
    fn ideal_mean(&self) -> f64 {
        0.5 * (self.ideal[0] + self.ideal[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(ours: f64, ideal: [f64; 2], reference: f64) -> Row {
        Row { ours, ideal, reference, noise_variance: 0.0 }
    }

    #[test]
    fn errors_of_texels_and_of_transport_are_told_apart() {
        let errors = FloorErrors::of(&[row(1.3, [1.1; 2], 1.0), row(0.9, [0.9; 2], 1.0)]);
        let near = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9, "{a:?} is not {b}");
        near(errors.floor, 0.1);
        near(errors.floor_bias, 0.0);
        near(errors.above_floor, (0.5_f64 * 0.04).sqrt());
        near(errors.above_floor_bias, 0.1);
    }

    #[test]
    fn noise_of_the_ideal_lightmap_is_no_error() {
        // Noise of either sign in each half, all four combinations: what is left is that of neither.
        let rows = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
            .map(|(a, b)| row(1.0, [1.0 + 0.3 * f64::from(a), 1.0 + 0.3 * f64::from(b)], 1.0));
        let errors = FloorErrors::of(&rows);
        assert!(errors.floor.unwrap() < 1e-9 && errors.above_floor.unwrap() < 1e-9, "{errors:?}");
        let same = rows.map(|row| Row { ideal: [row.ideal[0]; 2], ..row });
        assert!(FloorErrors::of(&same).floor.unwrap() > 0.29, "negative control");
    }

    #[test]
    fn black_references_have_no_shares() {
        let errors = FloorErrors::of(&[row(0.0, [0.0; 2], 0.0)]);
        assert_eq!((errors.compared, errors.floor, errors.above_floor_bias), (1, None, None));
        assert_eq!(FloorErrors::of(&[]).floor, None);
    }
}
