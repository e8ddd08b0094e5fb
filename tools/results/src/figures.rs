//! The measured figures, as `docs/results.json` holds them.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::documents::write_whole;

/// All figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// What measured: processor and threads.
    pub(crate) machine: String,
    /// Relative RMSE that is wanted of a set of reference points, a share.
    #[serde(default)]
    pub(crate) wanted: BTreeMap<String, f64>,
    /// By scene, followed by the bake's options where these are not the defaults: `cornell --method paper`.
    pub(crate) bakes: BTreeMap<String, Bake>,
    /// Frames of synthetic scenes, by backend: `cpu`, `gpu`.
    #[serde(default)]
    pub(crate) scaling: BTreeMap<String, Scaling>,
    /// Rays of our tracer beside Embree's, by scene; `tools/embree-bench` prints them.
    #[serde(default)]
    pub(crate) rays: BTreeMap<String, Rays>,
}

/// A baked scene and how far its light is from the truth. What was not measured is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bake {
    /// Version of the file format.
    pub(crate) format: u64,
    pub(crate) receivers: Option<u64>,
    pub(crate) probes: Option<u64>,
    /// Matrices with all metadata, per receiver.
    pub(crate) bytes_per_receiver: f64,
    /// The whole file.
    pub(crate) file_bytes: Option<u64>,
    /// Relative error of the compressed transport, mean over the clusters.
    pub(crate) compression_error: Option<f64>,
    /// Time of the bake.
    pub(crate) seconds: Option<f64>,
    /// Largest memory of the bake, MiB.
    pub(crate) peak_mib: Option<f64>,
    /// Shortest whole frame on the CPU while nothing changes but the bounced light, ms.
    pub(crate) still_ms: Option<f64>,
    /// The same while the lights change with each frame, ms.
    pub(crate) moving_ms: Option<f64>,
    /// Errors under random lights.
    pub(crate) random_lights: Option<RandomLights>,
    /// By set of reference points.
    #[serde(default)]
    pub(crate) sets: BTreeMap<String, Errors>,
}

/// How the names of sets end whose points `probelight reference --sample` chose, by area and by triangle. Such points also
/// lie where nobody looks, so these sets are not compared with the others.
const SAMPLED: &str = "_sampled";

/// Whether a set of reference points is one that `probelight reference --sample` chose.
pub(crate) fn is_sampled(set: &str) -> bool {
    set.ends_with(SAMPLED)
}

/// Errors against a set of reference points, shares; named as `probelight eval --json` names them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errors {
    pub(crate) relative_rmse: f64,
    pub(crate) mean_bias: Option<f64>,
    pub(crate) median_relative_error: Option<f64>,
    pub(crate) p95_relative_error: Option<f64>,
    /// Share of the points that are exactly black though the reference finds light.
    pub(crate) black_share: Option<f64>,
    /// On triangles below 0.05 m², if the set has points chosen by triangle.
    pub(crate) small_triangles: Option<SmallTriangles>,
    pub(crate) border_jumps: Option<BorderJumps>,
    /// What of it are the lightmap's own errors.
    pub(crate) floor: Option<Floor>,
    /// Relative RMSE of the light that a GPU computes.
    pub(crate) gpu_relative_rmse: Option<f64>,
}

/// Relative RMSE of an ideal lightmap of the same texels, and how far ours is from it, shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Floor {
    pub(crate) floor: Option<f64>,
    pub(crate) above_floor: Option<f64>,
    pub(crate) above_floor_bias: Option<f64>,
}

/// Errors on small triangles, shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SmallTriangles {
    pub(crate) relative_rmse: Option<f64>,
    pub(crate) median_relative_error: Option<f64>,
    pub(crate) black_share: f64,
}

/// Relative jumps of the light beside the borders between clusters, and the same inside them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BorderJumps {
    pub(crate) median: Option<f64>,
    pub(crate) p99: Option<f64>,
    pub(crate) median_inside: Option<f64>,
    pub(crate) p99_inside: Option<f64>,
}

/// Errors under several random lights, shares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RandomLights {
    pub(crate) lights: usize,
    /// Median of their relative RMSE.
    pub(crate) median: f64,
    pub(crate) largest: Option<f64>,
    /// Mean of the biases' sizes.
    pub(crate) mean_bias_size: Option<f64>,
}

/// Frames of synthetic scenes of many sizes on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Scaling {
    pub(crate) device: String,
    /// What a copy reads and writes.
    pub(crate) copy_gb_per_s: f64,
    pub(crate) scenes: Vec<SyntheticScene>,
}

/// A frame of a synthetic scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SyntheticScene {
    pub(crate) receivers: u64,
    /// Bytes that a frame must move.
    pub(crate) megabytes: f64,
    pub(crate) shortest_ms: f64,
    /// Speed at which these are moved, as a share of that of a copy.
    pub(crate) of_copy: f64,
}

/// Millions of rays per second on one thread, ours and Embree's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Rays {
    pub(crate) closest_hit: [f64; 2],
    pub(crate) occlusion: [f64; 2],
}

impl RandomLights {
    /// Over the errors of each light; `None` if there are none.
    pub(crate) fn of(errors: &[Errors]) -> Option<Self> {
        let mut sorted: Vec<f64> = errors.iter().map(|errors| errors.relative_rmse).collect();
        sorted.sort_by(f64::total_cmp);
        let biases: Vec<f64> = errors.iter().filter_map(|errors| Some(errors.mean_bias?.abs())).collect();
        Some(Self {
            lights: sorted.len(),
            median: sorted.get(sorted.len().saturating_sub(1) / 2).copied()?,
            largest: sorted.last().copied(),
            mean_bias_size: Some(biases.iter().sum::<f64>() / biases.len().max(1) as f64),
        })
    }
}

impl Figures {
    /// Reads a file of figures.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
        serde_json::from_str(&text).with_context(|| format!("{shown} does not hold figures"))
    }

    /// Replaces a file of figures as a whole.
    pub(crate) fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(&tidy(serde_json::to_value(self)?))? + "\n";
        write_whole(path, text.as_bytes())
    }

    /// Takes over what was measured anew; the rest stays.
    pub(crate) fn adopt(&mut self, measured: Self) {
        self.machine = measured.machine;
        self.wanted.extend(measured.wanted);
        self.bakes.extend(measured.bakes);
        self.scaling.extend(measured.scaling);
        self.rays.extend(measured.rays);
    }
}

/// A value without what is absent, its numbers with as many digits as are measured.
fn tidy(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let fields = fields.into_iter().filter(|(_, value)| !value.is_null());
            Value::Object(fields.map(|(name, value)| (name, tidy(value))).collect())
        }
        Value::Array(values) => values.into_iter().map(tidy).collect(),
        Value::Number(number) if number.is_f64() => rounded(number.as_f64().unwrap_or_default()).into(),
        other => other,
    }
}

/// Four significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(relative_rmse: f64, mean_bias: f64) -> Errors {
        Errors { relative_rmse, mean_bias: Some(mean_bias), ..Errors::default() }
    }

    #[test]
    fn random_lights_are_summed_up() {
        assert_eq!(RandomLights::of(&[]), None);
        let lights = [errors(0.3, -0.1), errors(0.1, 0.2), errors(0.2, 0.0), errors(0.4, 0.1)];
        let summary = RandomLights::of(&lights).unwrap();
        assert_eq!((summary.lights, summary.median, summary.largest), (4, 0.2, Some(0.4)));
        assert!((summary.mean_bias_size.unwrap() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_was_measured_anew_replaces_the_old() {
        let bake = |bytes| Bake { bytes_per_receiver: bytes, ..Bake::default() };
        let figures = |entries: &[(&str, f64)]| Figures {
            bakes: entries.iter().map(|(name, bytes)| ((*name).into(), bake(*bytes))).collect(),
            ..Figures::default()
        };
        let mut old = figures(&[("a", 1.0), ("b", 2.0)]);
        old.adopt(figures(&[("b", 3.0), ("c", 4.0)]));
        assert_eq!(old, figures(&[("a", 1.0), ("b", 3.0), ("c", 4.0)]));
    }

    #[test]
    fn figures_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("figures.json");
        let bake =
            Bake { still_ms: Some(0.7), sets: [("set".into(), errors(0.1, 0.2))].into(), ..Bake::default() };
        let figures =
            Figures { machine: "m".into(), bakes: [("scene".into(), bake)].into(), ..Figures::default() };
        figures.write(&path).unwrap();
        assert_eq!(Figures::read(&path).unwrap(), figures);
        assert!(!std::fs::read_to_string(&path).unwrap().contains("null"));
        std::fs::write(&path, "{}").unwrap();
        assert!(format!("{:#}", Figures::read(&path).unwrap_err()).contains("does not hold figures"));
    }
}
