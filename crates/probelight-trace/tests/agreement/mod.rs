//! How well irradiance estimates agree with independent reference estimates of the same points.

#![allow(dead_code, reason = "the example prints figures and leaves the verdict to its reader")]

use std::path::Path;

use probelight_math::glam::Vec3;
use probelight_trace::PointIrradiance;

/// One row of a reference points file.
pub(crate) struct ReferencePoint {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) irradiance: PointIrradiance,
}

/// Reads the surface points (kind 0, where there is such a column) of a reference CSV file.
pub(crate) fn read_reference(path: &Path) -> Vec<ReferencePoint> {
    let text = std::fs::read_to_string(path).expect("the reference file is readable");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("the file has a header").split(',').collect();
    let column = |name: &str| header.iter().position(|title| *title == name);
    let vector = |row: &[f32], name: &str, axes: [&str; 3]| {
        Vec3::from_array(axes.map(|axis| row[column(&format!("{name}_{axis}")).expect("a known column")]))
    };
    lines
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect::<Vec<f32>>())
        .filter(|row| column("kind").is_none_or(|kind| row[kind] == 0.0))
        .map(|row| {
            let colour = |name| vector(&row, name, ["r", "g", "b"]);
            ReferencePoint {
                position: vector(&row, "position", ["x", "y", "z"]),
                normal: vector(&row, "normal", ["x", "y", "z"]),
                irradiance: PointIrradiance {
                    delta: colour("E_delta"),
                    area: colour("E_area"),
                    sky: colour("E_sky"),
                    indirect: colour("E_indirect"),
                    se_area: colour("se_area"),
                    se_sky: colour("se_sky"),
                    se_indirect: colour("se_indirect"),
                },
            }
        })
        .collect()
}

/// The scatter of `(ours − reference) / √(se² + se_ref²)` over points and channels, and the mean bias.
#[derive(Debug)]
pub(crate) struct Agreement {
    /// Values compared.
    pub(crate) count: usize,
    /// Σ ours / Σ reference − 1.
    pub(crate) bias: f64,
    /// Standard error of `bias`.
    pub(crate) bias_error: f64,
    /// Mean z-score; 0 if unbiased.
    pub(crate) mean_z: f64,
    /// Standard deviation of the z-scores; 1 if the standard errors are right.
    pub(crate) std_z: f64,
    /// Share of z-scores beyond ±3.
    pub(crate) outliers: f64,
}

/// A part of the irradiance and its standard error.
type Part = fn(&PointIrradiance) -> (Vec3, Vec3);

/// What has a standard error: all but the analytic lights' direct part.
pub(crate) const ESTIMATED_PARTS: [(&str, Part); 3] = [
    ("area", |e| (e.area, e.se_area)),
    ("sky", |e| (e.sky, e.se_sky)),
    ("indirect", |e| (e.indirect, e.se_indirect)),
];

impl Agreement {
    /// Compares one part; `None` if the reference has nothing of it.
    pub(crate) fn of(part: Part, ours: &[PointIrradiance], reference: &[ReferencePoint]) -> Option<Self> {
        let (mut sum, mut sum_reference, mut variance_of_sum) = (0.0, 0.0, 0.0);
        let mut z_scores = Vec::new();
        for (ours, reference) in ours.iter().zip(reference) {
            let ((value, error), (expected, expected_error)) = (part(ours), part(&reference.irradiance));
            let mut error_of_channels = 0.0;
            for c in 0..3 {
                sum += f64::from(value[c]);
                sum_reference += f64::from(expected[c]);
                // Rounding of the file's six digits is an error too.
                let error = f64::from(error[c]).hypot(f64::from(expected_error[c]));
                let error = error.hypot(1e-5 * f64::from(expected[c]));
                // Channels share their paths: their errors add up, those of points only in quadrature.
                error_of_channels += error;
                if error > 0.0 {
                    z_scores.push(f64::from(value[c] - expected[c]) / error);
                }
            }
            variance_of_sum += error_of_channels * error_of_channels;
        }
        if sum_reference == 0.0 {
            assert_eq!(sum, 0.0, "light where the reference has none");
            return None;
        }
        let count = z_scores.len();
        let mean_z = z_scores.iter().sum::<f64>() / count as f64;
        let variance = z_scores.iter().map(|z| (z - mean_z).powi(2)).sum::<f64>() / count as f64;
        let outliers = z_scores.iter().filter(|z| z.abs() > 3.0).count() as f64 / count as f64;
        let bias_error = variance_of_sum.sqrt() / sum_reference;
        Some(Self {
            count,
            bias: sum / sum_reference - 1.0,
            bias_error,
            mean_z,
            std_z: variance.sqrt(),
            outliers,
        })
    }

    /// Whether both sides may well estimate the same numbers. The three channels of a point share their paths,
    /// so a third of the values is independent.
    pub(crate) fn is_convincing(&self) -> bool {
        let independent = (self.count as f64 / 3.0).sqrt();
        self.bias.abs() < f64::max(0.005, 3.0 * self.bias_error)
            && self.bias_error < 0.01
            && self.mean_z.abs() < 4.0 / independent
            && (0.7..1.3).contains(&self.std_z)
            && self.outliers < 0.03
    }
}

/// Share of points whose direct light of analytic lights differs by more than 1 %. It is discontinuous at
/// shadow edges, so a few may.
pub(crate) fn delta_mismatches(ours: &[PointIrradiance], reference: &[ReferencePoint]) -> f64 {
    let differs = |(ours, reference): &(&PointIrradiance, &ReferencePoint)| {
        let expected = reference.irradiance.delta;
        (ours.delta - expected).length() > 0.01 * expected.length() + 1e-6
    };
    ours.iter().zip(reference).filter(differs).count() as f64 / reference.len() as f64
}
