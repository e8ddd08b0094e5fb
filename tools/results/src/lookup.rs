//! Figures by name.
//!
//! `SCENE/FIELD` is a figure of a bake, `SCENE/SET/FIELD` one of its errors, `table NAME` a table.

use anyhow::{Context, bail};

use crate::figures::{Bake, Errors, Figures, is_sampled};
use crate::tables;

/// What is shown for a figure that was not measured.
pub(crate) const NOT_MEASURED: &str = "–";

/// A table between its marks.
pub(crate) fn as_block(table: &str) -> String {
    format!("\n\n{}\n\n", table.trim_end())
}

/// What a document says in place of `name`.
pub(crate) fn value(figures: &Figures, name: &str) -> anyhow::Result<String> {
    if let Some(table) = name.strip_prefix("table ") {
        return Ok(as_block(&tables::by_name(figures, table)?));
    }
    let parts: Vec<&str> = name.split('/').collect();
    let bake =
        |scene: &str| figures.bakes.get(scene).with_context(|| format!("no bake {scene} was measured"));
    let value = match parts[..] {
        ["machine"] => Some(figures.machine.clone()),
        ["formats"] => Some(formats(figures)),
        [scene, "least"] => extreme(bake(scene)?, scene, f64::min),
        [scene, "largest"] => extreme(bake(scene)?, scene, f64::max),
        [scene, field] => bake_figure(bake(scene)?, field)?,
        [scene, set, field] => {
            let errors = bake(scene)?.sets.get(set).with_context(|| format!("no set {set} was measured"))?;
            error_figure(errors, field)?
        }
        _ => bail!("names are SCENE/FIELD, SCENE/SET/FIELD or `table NAME`"),
    };
    Ok(value.unwrap_or_else(|| NOT_MEASURED.into()))
}

/// The versions of the file format that were measured.
fn formats(figures: &Figures) -> String {
    let mut versions: Vec<u64> = figures.bakes.values().map(|bake| bake.format).collect();
    versions.sort_unstable();
    versions.dedup();
    let versions: Vec<String> = versions.iter().map(u64::to_string).collect();
    versions.join(" and ")
}

fn bake_figure(bake: &Bake, field: &str) -> anyhow::Result<Option<String>> {
    Ok(match field {
        "receivers" => bake.receivers.map(grouped),
        "bytes" => Some(format!("{:.0}", bake.bytes_per_receiver)),
        "file" => bake.file_bytes.map(|bytes| format!("{:.1} MB", bytes as f64 * 1e-6)),
        "compression" => bake.compression_error.map(short_percent),
        "time" => bake.seconds.map(|seconds| format!("{seconds:.0} s")),
        "memory" => bake.peak_mib.map(|mib| format!("{mib:.0} MiB")),
        "still" => bake.still_ms.map(milliseconds),
        "moving" => bake.moving_ms.map(milliseconds),
        "random" => bake.random_lights.map(|lights| short_percent(lights.median)),
        _ => bail!("a bake has no figure {field}"),
    })
}

/// The least or largest error of a bake, and the light that it has it under.
fn extreme(bake: &Bake, scene: &str, better: fn(f64, f64) -> f64) -> Option<String> {
    let sets = || bake.sets.iter().filter(|(set, _)| !is_sampled(set));
    let extreme = sets().map(|(_, errors)| errors.relative_rmse).reduce(better)?;
    let (set, _) = sets().find(|(_, errors)| errors.relative_rmse == extreme)?;
    let light = set.strip_prefix(scene).unwrap_or(set).trim_start_matches('_');
    Some(format!("{} ({light})", short_percent(extreme)))
}

fn error_figure(errors: &Errors, field: &str) -> anyhow::Result<Option<String>> {
    Ok(match field {
        "rmse" => Some(short_percent(errors.relative_rmse)),
        "bias" => errors.mean_bias.map(signed_percent),
        "median" => errors.median_relative_error.map(short_percent),
        "p95" => errors.p95_relative_error.map(short_percent),
        _ => bail!("a set has no figure {field}"),
    })
}

/// A share as in running text.
fn short_percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A share as in tables.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// A share with its sign.
pub(crate) fn signed_percent(share: f64) -> String {
    format!("{:+.2} %", 100.0 * share)
}

/// A time, with one digit behind the point from one millisecond on.
pub(crate) fn milliseconds(ms: f64) -> String {
    if ms < 1.0 { format!("{ms:.2} ms") } else { format!("{ms:.1} ms") }
}

/// A number with commas between thousands.
pub(crate) fn grouped(number: u64) -> String {
    match number {
        0..1000 => number.to_string(),
        _ => format!("{},{:03}", grouped(number / 1000), number % 1000),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_as_people_write_them() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(394_187), "394,187");
        assert_eq!(grouped(1_000_005), "1,000,005");
        assert_eq!((milliseconds(0.714).as_str(), milliseconds(11.84).as_str()), ("0.71 ms", "11.8 ms"));
        assert_eq!(signed_percent(0.0096), "+0.96 %");
    }

    #[test]
    fn all_fields_are_found_by_name() {
        let errors = Errors { relative_rmse: 0.1197, mean_bias: Some(-0.0033), ..Errors::default() };
        let sky = Errors { relative_rmse: 0.0237, ..Errors::default() };
        let bake = Bake {
            format: 6,
            still_ms: Some(11.8),
            sets: [
                ("atrium_sky".into(), sky),
                ("atrium_sky_sampled".into(), Errors { relative_rmse: 0.01, ..Errors::default() }),
                ("atrium_sun".into(), errors),
            ]
            .into(),
            ..Bake::default()
        };
        let figures = Figures { bakes: [("atrium".into(), bake)].into(), ..Figures::default() };
        assert_eq!(value(&figures, "atrium/atrium_sun/rmse").unwrap(), "12.0 %");
        assert_eq!(value(&figures, "atrium/atrium_sun/bias").unwrap(), "-0.33 %");
        assert_eq!(value(&figures, "atrium/still").unwrap(), "11.8 ms");
        assert_eq!(value(&figures, "atrium/least").unwrap(), "2.4 % (sky)");
        assert_eq!(value(&figures, "atrium/largest").unwrap(), "12.0 % (sun)");
        assert_eq!(value(&figures, "formats").unwrap(), "6");
        for absent in ["atrium/moving", "atrium/atrium_sun/p95"] {
            assert_eq!(value(&figures, absent).unwrap(), NOT_MEASURED);
        }
        for unknown in ["atrium/colour", "atrium/night/rmse", "hall/still", "a/b/c/d"] {
            assert!(value(&figures, unknown).is_err(), "{unknown}");
        }
    }
}
