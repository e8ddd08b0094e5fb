//! `probelight info FILE`

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use probelight_asset::{BakedInfo, BakedScene};

use crate::console;

const EXAMPLES: &str = "\
Examples:
  probelight info room.plight
  probelight info room.plight --json | jq .report.uncovered_fraction";

/// Flags of `info`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Prints what a baked file says about itself.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    let info = BakedScene::read_info(&flags.file)?;
    if flags.json {
        return console::print_json(&info);
    }
    let mut text = describe(&info)?;
    for section in &info.sections {
        writeln!(text, "{:<22}{}", format!("section {}", section.name), megabytes(section.bytes))?;
    }
    console::print(text.trim_end())
}

/// The summary as text, a figure a line.
pub(crate) fn describe(info: &BakedInfo) -> Result<String, std::fmt::Error> {
    let (settings, report) = (&info.settings, &info.report);
    let mut text = String::new();
    let mut line = |name: &str, value: String| writeln!(text, "{name:<22}{value}");
    line("file", format!("{} (format version {})", megabytes(info.file_bytes), info.format_version))?;
    line("scene", format!("{} triangles, hash {:016x}", info.triangles, info.scene_hash))?;
    line(
        "lightmap",
        format!(
            "{} × {} texels, {} page(s), {} texels per metre",
            info.lightmap_width, info.lightmap_height, info.lightmap_pages, settings.texels_per_meter
        ),
    )?;
    line("texels", format!("{} in charts, {} inside geometry", report.chart_texels, report.invalid_texels))?;
    line("receivers", format!("{}, {} gather rays each", info.receivers, settings.gather_rays))?;
    line(
        "probes",
        format!(
            "{}, {:.2} m apart, spherical harmonics degree {}, {} relight rays each",
            info.probes, settings.probe_spacing, settings.sh_degree, settings.relight_rays
        ),
    )?;
    line(
        "clusters",
        format!(
            "{}, at most {} receivers and rank {}, {} probes (up to twice as many where rays end unseen)",
            info.clusters, settings.receivers_per_cluster, settings.max_rank, settings.probes_per_cluster
        ),
    )?;
    line("matrices", format!("{:.1} bytes per receiver", info.matrix_bytes_per_receiver))?;
    line(
        "truncation error",
        format!(
            "mean {}, largest {}, wanted at most {}",
            percent(report.mean_cluster_error),
            percent(report.max_cluster_error),
            percent(f64::from(settings.max_cluster_error))
        ),
    )?;
    line(
        "hits no probe sees",
        format!(
            "{} approximated, {} lost",
            percent(report.approximated_fraction),
            percent(report.uncovered_fraction)
        ),
    )?;
    for warning in &report.warnings {
        line("warning", warning.clone())?;
    }
    Ok(text)
}

/// A share as a percentage.
fn percent(share: f64) -> String {
    format!("{:.2} %", share * 100.0)
}

/// A file size in decimal units.
pub(crate) fn megabytes(bytes: u64) -> String {
    if bytes < 1_000_000 {
        format!("{:.1} kB", bytes as f64 / 1e3)
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}
