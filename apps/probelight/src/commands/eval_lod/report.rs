//! What `eval-lod` prints.

use std::collections::BTreeMap;
use std::fmt::{Error, Write};
use std::path::PathBuf;

use probelight_runtime::Stage;
use serde::Serialize;

/// What `eval-lod --json` prints.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) file: PathBuf,
    pub(super) frames: u32,
    pub(super) light: &'static str,
    pub(super) rows: Vec<Row>,
}

/// One kind of levels of detail seen by one camera under one setup. What ends in `_all` is without levels of detail.
#[derive(Serialize)]
pub(super) struct Row {
    pub(super) lod: String,
    pub(super) setup: String,
    pub(super) camera: String,
    #[serde(flatten)]
    pub(super) work: Work,
    /// Median time of the stages that compute irradiance.
    pub(super) ms: f64,
    pub(super) ms_all: f64,
    /// `ms_all` / `ms`.
    pub(super) speedup: f64,
    /// Median time of whole frames, direct light included.
    pub(super) frame_ms: f64,
    pub(super) frame_ms_all: f64,
    /// `frame_ms_all` / `frame_ms`.
    pub(super) frame_speedup: f64,
    /// Median time of each stage.
    pub(super) stages_ms: BTreeMap<&'static str, f64>,
    pub(super) stages_ms_all: BTreeMap<&'static str, f64>,
    /// How much more a receiver's irradiance changes from one frame to the next than without levels of detail, at most; share
    /// of the mean irradiance.
    pub(super) step: f64,
    /// The largest change of a receiver's irradiance from one frame to the next, with levels of detail; share of the same.
    pub(super) largest_change: f64,
    pub(super) largest_change_all: f64,
    /// Similarity of the pictures after the last frame.
    pub(super) ssim: f64,
    pub(super) flip: f64,
    /// Relative RMSE against a reference under still light, its noise subtracted.
    pub(super) rmse: Option<f64>,
    pub(super) rmse_all: Option<f64>,
}

/// What a frame computes on average.
#[derive(Serialize)]
pub(super) struct Work {
    pub(super) receivers: f64,
    pub(super) receivers_all: u64,
    /// Probes that are relit.
    pub(super) probes: f64,
    pub(super) probes_all: usize,
    /// Coefficients that they get.
    pub(super) coefficients: f64,
    pub(super) coefficients_all: usize,
    /// Bytes of transport matrices that are read.
    pub(super) bytes: f64,
    pub(super) bytes_all: u64,
}

impl Report {
    pub(super) fn tables(&self) -> Result<String, Error> {
        let mut text = String::new();
        let Self { frames, light, .. } = self;
        writeln!(text, "{frames} frames, light {light}; without levels of detail behind each slash")?;
        self.write_light(&mut text)?;
        self.write_work(&mut text)?;
        self.write_stages(&mut text)?;
        writeln!(
            text,
            "published: 135452 / 512026 receivers, 1.25 / 1.99 ms, speedup 1.60; 217911 receivers, 1.43 ms, 1.39"
        )?;
        writeln!(text, "published, the fastest of six settings: speedup 4.34 at SSIM 0.972")?;
        Ok(text)
    }

    fn write_light(&self, text: &mut String) -> Result<(), Error> {
        writeln!(
            text,
            "{:<18}{:<11}{:<18}{:>17}{:>9}{:>17}{:>8}{:>8}{:>8}{:>9}{:>18}",
            "levels of detail",
            "camera",
            "setup",
            "ms",
            "speedup",
            "frame ms",
            "",
            "SSIM",
            "FLIP",
            "step",
            "RMSE"
        )?;
        for row in &self.rows {
            let rmse = row
                .rmse
                .zip(row.rmse_all)
                .map(|(with, all)| format!("{:.2} / {:.2} %", with * 100.0, all * 100.0));
            writeln!(
                text,
                "{:<18}{:<11}{:<18}{:>17}{:>9.2}{:>17}{:>8.2}{:>8.4}{:>8.4}{:>7.2} %{:>18}",
                row.lod,
                row.camera,
                row.setup,
                pair(row.ms, row.ms_all, 2),
                row.speedup,
                pair(row.frame_ms, row.frame_ms_all, 2),
                row.frame_speedup,
                row.ssim,
                row.flip,
                row.step * 100.0,
                rmse.unwrap_or_default()
            )?;
        }
        Ok(())
    }

    fn write_work(&self, text: &mut String) -> Result<(), Error> {
        writeln!(
            text,
            "\n{:<18}{:<11}{:<18}{:>19}{:>15}{:>19}{:>17}{:>8}",
            "computed a frame", "", "", "receivers", "probes", "coefficients", "MB", "times"
        )?;
        for row in &self.rows {
            let Work { receivers, probes, coefficients, bytes, .. } = row.work;
            writeln!(
                text,
                "{:<18}{:<11}{:<18}{:>19}{:>15}{:>19}{:>17}{:>8.2}",
                row.lod,
                row.camera,
                row.setup,
                pair(receivers, row.work.receivers_all as f64, 0),
                pair(probes, row.work.probes_all as f64, 0),
                pair(coefficients, row.work.coefficients_all as f64, 0),
                pair(bytes * 1e-6, row.work.bytes_all as f64 * 1e-6, 2),
                row.work.bytes_all as f64 / bytes
            )?;
        }
        Ok(())
    }

    fn write_stages(&self, text: &mut String) -> Result<(), Error> {
        let took = |name: &&str| self.rows.iter().any(|row| row.stages_ms_all[name] > 0.0);
        let stages: Vec<&str> = Stage::ALL.iter().map(|stage| stage.name()).filter(took).collect();
        write!(text, "\n{:<18}{:<11}{:<18}", "stages, ms", "", "")?;
        for stage in &stages {
            write!(text, "{stage:>18}")?;
        }
        writeln!(text)?;
        for row in &self.rows {
            write!(text, "{:<18}{:<11}{:<18}", row.lod, row.camera, row.setup)?;
            for stage in &stages {
                write!(text, "{:>18}", pair(row.stages_ms[stage], row.stages_ms_all[stage], 2))?;
            }
            writeln!(text)?;
        }
        writeln!(text)
    }
}

fn pair(with: f64, all: f64, digits: usize) -> String {
    format!("{with:.digits$} / {all:.digits$}")
}
