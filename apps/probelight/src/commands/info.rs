//! `probelight info FILE`

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::ensure;
use clap::Args;
use probelight_asset::{BakedInfo, BakedScene, Method};
use serde::Serialize;

use crate::console;
use crate::error_map::{LegendEntry, error_map, legend};
use crate::matrix_figures::MatrixFigures;
use crate::output::{self, PictureFormat};

const EXAMPLES: &str = "\
Examples:
  probelight info room.plight
  probelight info room.plight --json | jq .matrices.bytes_per_receiver.total
  probelight info room.plight --error-map errors.png

The error map shows the lightmap, each texel in the colour of its cluster's relative error: teal
is what the bake was asked for, yellow twice as much or more.";

/// Flags of `info`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Also write a picture of where the compression loses light, texel by texel of the lightmap
    #[arg(long, value_name = "OUT.png")]
    error_map: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// What `info --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    info: &'a BakedInfo,
    matrices: MatrixFigures,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_map: Option<ErrorMap<'a>>,
}

/// A picture of errors.
#[derive(Serialize)]
struct ErrorMap<'a> {
    output: &'a Path,
    legend: Vec<LegendEntry>,
}

/// Prints what a baked file says about itself.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    if let Some(path) = &flags.error_map {
        output::check(path, &[&flags.file])?;
        let is_png = PictureFormat::of(path)? == PictureFormat::Png;
        ensure!(is_png, "{} must end in .png: the map's colours stand for errors", path.display());
    }
    let info = BakedScene::read_info(&flags.file)?;
    let baked = BakedScene::read(&flags.file)?;
    let matrices = MatrixFigures::of(&baked);
    let error_map = flags.error_map.as_deref().map(|path| write_error_map(&baked, path)).transpose()?;
    if flags.json {
        return console::print_json(&Report { info: &info, matrices, error_map });
    }
    let mut text = describe(&info, &matrices)?;
    for section in &info.sections {
        writeln!(text, "{:<22}{}", format!("section {}", section.name), megabytes(section.bytes))?;
    }
    if let Some(map) = error_map {
        let entries: Vec<String> = map.legend.iter().map(LegendEntry::describe).collect();
        let shown = map.output.display();
        writeln!(text, "{:<22}{shown}: {} or more, black no receiver", "error map", entries.join(", "))?;
    }
    console::print(text.trim_end())
}

fn write_error_map<'a>(baked: &BakedScene, output: &'a Path) -> anyhow::Result<ErrorMap<'a>> {
    error_map(baked).write_png(output)?;
    Ok(ErrorMap { output, legend: legend(baked.settings.max_cluster_error) })
}

/// The summary as text, a figure a line.
pub(crate) fn describe(info: &BakedInfo, matrices: &MatrixFigures) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let lines = content_lines(info).into_iter().chain(matrices.lines()).chain(error_lines(info));
    for (name, value) in lines {
        writeln!(text, "{name:<22}{value}")?;
    }
    Ok(text)
}

/// What the file holds.
fn content_lines(info: &BakedInfo) -> Vec<(&'static str, String)> {
    let (settings, report) = (&info.settings, &info.report);
    vec![
        ("file", format!("{} (format version {})", megabytes(info.file_bytes), format_version(info))),
        ("scene", format!("{} triangles, hash {:016x}", info.triangles, info.scene_hash)),
        (
            "method",
            format!(
                "{}, compressed in the {} metric, stored as {}",
                name_of(&settings.method),
                name_of(&settings.metric),
                name_of(&settings.storage)
            ),
        ),
        (
            "lightmap",
            format!(
                "{} × {} texels, {} page(s), {} texels per metre",
                info.lightmap_width, info.lightmap_height, info.lightmap_pages, settings.texels_per_meter
            ),
        ),
        ("texels", format!("{} in charts, {} inside geometry", report.chart_texels, report.invalid_texels)),
        ("receivers", format!("{}, {} gather rays each", info.receivers, settings.gather_rays)),
        ("surfels", surfels(info)),
        ("emitters", emitters(info)),
        ("probes", probes(info)),
        (
            "clusters",
            format!(
                "{}, at most {} receivers and rank {}",
                info.clusters, settings.receivers_per_cluster, settings.max_rank
            ),
        ),
    ]
}

fn format_version(info: &BakedInfo) -> String {
    format!("{}.{}", info.format_version, info.format_minor_version)
}

fn surfels(info: &BakedInfo) -> String {
    let counts = format!("{}, {} light samples", info.surfels, info.light_samples);
    match info.settings.method {
        Method::Paper => format!("{counts}: one for each relight ray that meets a surface"),
        Method::Hybrid => {
            format!("{counts}, {:.2} m wide, {} groups", info.settings.surfel_size, info.surfel_groups)
        }
    }
}

fn emitters(info: &BakedInfo) -> String {
    match info.settings.method {
        Method::Paper => "none: probes see them".into(),
        Method::Hybrid => format!("{} with signals of their own", info.emitters),
    }
}

fn probes(info: &BakedInfo) -> String {
    let settings = &info.settings;
    if info.probes == 0 {
        return "none: surfels serve all distances".into();
    }
    let from = settings.near_radius.map_or(String::new(), |radius| format!(" for light beyond {radius} m"));
    format!(
        "{}{from}, {:.2} m apart, degree {}, {} relight rays each, up to {} to a cluster (twice as many where \
         rays end unseen)",
        info.probes,
        settings.probe_spacing,
        settings.sh_degree,
        settings.relight_rays,
        settings.probes_per_cluster
    )
}

/// What the bake lost.
fn error_lines(info: &BakedInfo) -> Vec<(&'static str, String)> {
    let (settings, report) = (&info.settings, &info.report);
    let compression = format!(
        "mean {}, largest {}, wanted {} at a byte's price of {:.2}",
        percent(report.mean_cluster_error),
        percent(report.max_cluster_error),
        percent(f64::from(settings.max_cluster_error)),
        settings.byte_price
    );
    let unseen = format!(
        "{} approximated, {} lost",
        percent(report.approximated_fraction),
        percent(report.uncovered_fraction)
    );
    let mut lines = vec![("compression error", compression), ("rays nothing answers", unseen)];
    lines.extend(report.warnings.iter().map(|warning| ("warning:", warning.clone())));
    lines
}

/// The name of a setting's value, as in the file and on the command line.
fn name_of(value: &impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|v| Some(v.as_str()?.to_owned())).unwrap_or_default()
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
