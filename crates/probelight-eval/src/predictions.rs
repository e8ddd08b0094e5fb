//! Predictions as comma-separated values.

use std::io::Write;
use std::path::Path;

use probelight_asset::write_atomically;
use probelight_math::glam::Vec3;

use crate::EvalError;

/// Writes predicted irradiance (W/m², linear Rec. 709), one row per reference row in its order. Each set of predictions
/// is three columns, `NAME_r`, `NAME_g` and `NAME_b`, with `NaN` where there is no answer. The file appears whole or not at
/// all.
///
/// # Errors
/// [`EvalError::Io`].
pub fn write_predictions(path: &Path, sets: &[(&str, &[Option<Vec3>])]) -> Result<(), EvalError> {
    write_atomically(path, |file| {
        let names =
            sets.iter().flat_map(|(name, _)| ["r", "g", "b"].map(|channel| format!("{name}_{channel}")));
        writeln!(file, "{}", names.collect::<Vec<_>>().join(","))?;
        for row in 0..sets.iter().map(|(_, rows)| rows.len()).max().unwrap_or(0) {
            let values = sets.iter().flat_map(|(_, rows)| {
                let irradiance = rows.get(row).copied().flatten();
                irradiance.unwrap_or(Vec3::NAN).to_array().map(|value| value.to_string())
            });
            writeln!(file, "{}", values.collect::<Vec<_>>().join(","))?;
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
        write_predictions(&path, &[("E", &rows), ("I", &rows[..1])]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            "E_r,E_g,E_b,I_r,I_g,I_b\n0.1,2,0.000000001,0.1,2,0.000000001\nNaN,NaN,NaN,NaN,NaN,NaN\n0,0,0,NaN,NaN,NaN\n"
        );
        assert!(write_predictions(&path.join("below a file"), &[]).is_err());
    }
}
