//! Predictions as comma-separated values.

use std::io::Write;
use std::path::Path;

use probelight_asset::write_atomically;
use probelight_math::glam::Vec3;

use crate::EvalError;

/// Writes predicted irradiance (W/m², linear Rec. 709), one row per reference row in its order: columns
/// `E_r,E_g,E_b`, with `NaN` where there is no answer. The file appears whole or not at all.
///
/// # Errors
/// [`EvalError::Io`].
pub fn write_predictions(path: &Path, predictions: &[Option<Vec3>]) -> Result<(), EvalError> {
    write_atomically(path, |file| {
        writeln!(file, "E_r,E_g,E_b")?;
        for prediction in predictions {
            let Vec3 { x, y, z } = prediction.unwrap_or(Vec3::NAN);
            writeln!(file, "{x},{y},{z}")?;
        }
        Ok(())
    })
    .map_err(|source| EvalError::Io { action: "write", path: path.into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_an_answer_are_nan() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("predictions.csv");
        let rows = [Some(Vec3::new(0.1, 2.0, 1e-9)), None, Some(Vec3::ZERO)];
        write_predictions(&path, &rows).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "E_r,E_g,E_b\n0.1,2,0.000000001\nNaN,NaN,NaN\n0,0,0\n");
        assert!(write_predictions(&path.join("below a file"), &rows).is_err());
    }
}
