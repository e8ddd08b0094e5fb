//! Predicted irradiance against reference points.

use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use probelight_scene::Bounds;
use serde::Serialize;

use crate::percentile::percentile;
use crate::{EvalError, PointKind, ReferencePoint, ReferencePoints, Sampling};

/// What of the reference is compared: the light that Probelight's lightmap holds. Where a setup has neither
/// emissive surfaces nor a sky, this is `E_indirect` alone.
pub const COMPARED: &str = "E_indirect + E_area + E_sky";

/// This share of the mean reference is added to each point's own in its relative error's denominator, so that
/// dark points do not dominate.
const DARK_POINT_SHARE: f64 = 0.02;

/// A triangle smaller than this (m²) is small: what people look at is detail, yet it has little area.
pub const SMALL_TRIANGLE: f32 = 0.05;

/// Standard errors by which a point's reference must exceed zero to count as lit.
const SURELY_LIT: f64 = 3.0;

/// Rec. 709 luminance weights, squared.
const SQUARED_WEIGHTS: [f64; 3] = [0.2126 * 0.2126, 0.7152 * 0.7152, 0.0722 * 0.0722];

/// Which rows of a table count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSelection {
    /// Only points of this kind.
    pub kind: PointKind,
    /// Only points chosen so.
    pub sampling: Sampling,
    /// Only points on triangles smaller than this, m².
    pub triangles_below: Option<f32>,
    /// Only points inside this box.
    pub within: Option<Bounds>,
}

impl Default for PointSelection {
    /// All points on surfaces that were chosen by area.
    fn default() -> Self {
        Self { kind: PointKind::Surface, sampling: Sampling::ByArea, triangles_below: None, within: None }
    }
}

impl PointSelection {
    /// The points on small triangles among those chosen by triangle.
    pub fn small_triangles() -> Self {
        Self { sampling: Sampling::ByTriangle, triangles_below: Some(SMALL_TRIANGLE), ..Self::default() }
    }

    /// The points in free space.
    pub fn free_space() -> Self {
        Self { kind: PointKind::FreeSpace, ..Self::default() }
    }

    /// Whether a point counts.
    pub fn contains(&self, point: &ReferencePoint) -> bool {
        let is_small = |limit| point.triangle_area.is_some_and(|area| area < limit);
        point.kind == self.kind
            && point.sampling == self.sampling
            && self.triangles_below.is_none_or(is_small)
            && self.within.is_none_or(|bounds| bounds.contains(point.position))
    }
}

impl ReferencePoint {
    /// The irradiance that is compared ([`COMPARED`]), W/m².
    pub fn compared_irradiance(&self) -> Vec3 {
        self.irradiance_indirect + self.irradiance_area + self.irradiance_sky
    }

    /// Variance of the luminance of [`compared_irradiance`](Self::compared_irradiance), (W/m²)², from the
    /// channels' standard errors as if channels and parts were independent. Real channels vary together,
    /// which makes the variance larger (up to 1.8 times for grey light): less is subtracted from an error
    /// than could be.
    pub fn luminance_variance(&self) -> f64 {
        let parts = [self.se_indirect, self.se_area, self.se_sky];
        let channels = parts.iter().flat_map(|se| se.to_array().into_iter().zip(SQUARED_WEIGHTS));
        channels.map(|(se, weight)| weight * f64::from(se).powi(2)).sum()
    }
}

/// How far predictions are from a reference. E is the luminance of irradiance, W/m²; relative figures are
/// shares (0.05 is 5 %) and absent where the reference is black.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointErrors {
    /// What of the reference was compared: [`COMPARED`].
    pub compared: &'static str,
    /// Selected rows with a prediction: the rows all figures are about.
    pub answered: usize,
    /// Selected rows without a prediction.
    pub unanswered: usize,
    /// √(mean (E − E_ref)² − mean noise variance of the reference) / √(mean E_ref²); 0 where noise explains
    /// all of the error.
    pub relative_rmse: Option<f64>,
    /// √(mean (E − E_ref)²) / √(mean E_ref²): the reference's own noise included.
    pub relative_rmse_with_noise: Option<f64>,
    /// √(mean noise variance) / √(mean E_ref²).
    pub reference_noise: Option<f64>,
    /// Median of |E − E_ref| / (|E_ref| + 0.02 · mean E_ref).
    pub median_relative_error: Option<f64>,
    /// 95th percentile of the same.
    pub p95_relative_error: Option<f64>,
    /// Largest of the same.
    pub max_relative_error: Option<f64>,
    /// mean(E − E_ref) / mean E_ref.
    pub mean_bias: Option<f64>,
    /// Share of the points that are exactly black though the reference finds light: more than
    /// 0.02 · mean E_ref, and surely no noise.
    pub black_share: f64,
    /// Mean E.
    pub mean_prediction: f64,
    /// Mean E_ref.
    pub mean_reference: f64,
    /// Largest E.
    pub max_prediction: f64,
    /// Largest E_ref.
    pub max_reference: f64,
}

impl PointErrors {
    /// Compares `predictions` (irradiance, W/m², one entry per row of the table) with the selected rows.
    ///
    /// # Errors
    /// [`EvalError::Mismatch`] if there is not one entry per row, a prediction is not finite, or no selected
    /// row has a prediction.
    pub fn measure(
        reference: &ReferencePoints,
        predictions: &[Option<Vec3>],
        selection: &PointSelection,
    ) -> Result<Self, EvalError> {
        let rows = selected_rows(reference, predictions, selection)?;
        let pairs: Vec<Pair> = rows.iter().filter_map(|(point, e)| Some(Pair::new(point, (*e)?))).collect();
        if pairs.is_empty() {
            return Err(EvalError::mismatch(format!(
                "none of the {} selected reference points has a prediction",
                rows.len()
            )));
        }
        Ok(Self::of(&pairs, rows.len() - pairs.len()))
    }

    fn of(pairs: &[Pair], unanswered: usize) -> Self {
        let mean = |value: &dyn Fn(&Pair) -> f64| pairs.iter().map(value).sum::<f64>() / pairs.len() as f64;
        let max = |value: &dyn Fn(&Pair) -> f64| pairs.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
        let mean_reference = mean(&|pair| pair.reference);
        let mean_prediction = mean(&|pair| pair.prediction);
        let squared_error = mean(&|pair| pair.difference().powi(2));
        let squared_noise = mean(&|pair| pair.noise_variance);
        let squared_reference = mean(&|pair| pair.reference.powi(2));
        let relative =
            |squared: f64| (squared_reference > 0.0).then(|| (squared.max(0.0) / squared_reference).sqrt());
        let errors = sorted_relative_errors(pairs, mean_reference);
        Self {
            compared: COMPARED,
            answered: pairs.len(),
            unanswered,
            relative_rmse: relative(squared_error - squared_noise),
            relative_rmse_with_noise: relative(squared_error),
            reference_noise: relative(squared_noise),
            median_relative_error: percentile(&errors, 0.5),
            p95_relative_error: percentile(&errors, 0.95),
            max_relative_error: errors.last().copied(),
            mean_bias: (mean_reference > 0.0).then(|| (mean_prediction - mean_reference) / mean_reference),
            black_share: mean(&|pair| f64::from(u8::from(pair.is_wrongly_black(mean_reference)))),
            mean_prediction,
            mean_reference,
            max_prediction: max(&|pair| pair.prediction),
            max_reference: max(&|pair| pair.reference),
        }
    }
}

/// Largest channel of the predicted irradiance in the selected rows, W/m² (channels, because a leak of any
/// colour is a leak); `None` if no selected row has a prediction.
///
/// # Errors
/// As [`PointErrors::measure`].
pub fn largest_irradiance(
    reference: &ReferencePoints,
    predictions: &[Option<Vec3>],
    selection: &PointSelection,
) -> Result<Option<f32>, EvalError> {
    let rows = selected_rows(reference, predictions, selection)?;
    Ok(rows.iter().filter_map(|(_, e)| e.map(Vec3::max_element)).reduce(f32::max))
}

/// Luminances of one point.
struct Pair {
    prediction: f64,
    reference: f64,
    noise_variance: f64,
}

impl Pair {
    fn new(point: &ReferencePoint, prediction: Vec3) -> Self {
        Self {
            prediction: f64::from(luminance(prediction)),
            reference: f64::from(luminance(point.compared_irradiance())),
            noise_variance: point.luminance_variance(),
        }
    }

    fn is_wrongly_black(&self, mean_reference: f64) -> bool {
        let lit = (DARK_POINT_SHARE * mean_reference).max(SURELY_LIT * self.noise_variance.sqrt());
        self.prediction <= 0.0 && self.reference > lit
    }

    fn difference(&self) -> f64 {
        self.prediction - self.reference
    }
}

/// The selected points, each with its prediction.
pub(crate) fn selected_rows<'a>(
    reference: &'a ReferencePoints,
    predictions: &[Option<Vec3>],
    selection: &PointSelection,
) -> Result<Vec<(&'a ReferencePoint, Option<Vec3>)>, EvalError> {
    if reference.points.len() != predictions.len() {
        return Err(EvalError::mismatch(format!(
            "{} predictions for {} reference points",
            predictions.len(),
            reference.points.len()
        )));
    }
    if let Some(row) = predictions.iter().position(|e| e.is_some_and(|e| !e.is_finite())) {
        return Err(EvalError::mismatch(format!("the prediction for point {row} is not finite")));
    }
    let rows = reference.points.iter().zip(predictions.iter().copied());
    Ok(rows.filter(|(point, _)| selection.contains(point)).collect())
}

/// Relative errors of all points, ascending; empty where the reference is black.
fn sorted_relative_errors(pairs: &[Pair], mean_reference: f64) -> Vec<f64> {
    if mean_reference <= 0.0 {
        return Vec::new();
    }
    let floor = DARK_POINT_SHARE * mean_reference;
    let relative = |pair: &Pair| pair.difference().abs() / (pair.reference.abs() + floor);
    let mut errors: Vec<f64> = pairs.iter().map(relative).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

#[cfg(test)]
mod tests;
