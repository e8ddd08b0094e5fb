//! Tables of the results page, as Markdown.

use std::collections::BTreeSet;

use anyhow::bail;

use crate::figures::{Bake, Errors, Figures, SyntheticScene, is_sampled};
use crate::lookup::{NOT_MEASURED, grouped, milliseconds, percent, signed_percent};
use crate::variants::{ACCURACY_AGAINST_BYTES, ERROR_BUDGET, Variant};

/// The columns that tables of variants show of the varied scene's sets.
const VARIED_SETS: [&str; 3] = ["cornell_point", "cornell_spot", "cornell_area"];

/// A table with its header.
pub(crate) struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows. Columns whose name ends in `:` are right-aligned.
    pub(crate) fn new<const N: usize>(header: [&str; N]) -> Self {
        Self { header: header.map(String::from).into(), rows: Vec::new() }
    }

    /// Adds a row, a cell for each column.
    pub(crate) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.into());
    }

    /// As Markdown.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let names: Vec<String> = self.header.iter().map(|name| name.trim_end_matches(':').into()).collect();
        let rules: Vec<String> =
            self.header.iter().map(|name| if name.ends_with(':') { "---:" } else { "---" }.into()).collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        line(&names) + &line(&rules) + &rows
    }
}

/// The table that a document asks for.
pub(crate) fn by_name(figures: &Figures, name: &str) -> anyhow::Result<String> {
    let table = match name {
        "errors" => errors(figures),
        "bakes" => bakes(figures),
        "random lights" => random_lights(figures),
        "small triangles" => small_triangles(figures),
        "seams" => seams(figures),
        "accuracy against bytes" => variants(figures, &ACCURACY_AGAINST_BYTES),
        "error budget" => variants(figures, &ERROR_BUDGET),
        "gpu errors" => gpu_errors(figures),
        "scaling" => scaling(figures),
        "rays" => rays(figures),
        _ => bail!("there is no table \"{name}\""),
    };
    Ok(table.markdown())
}

/// What was not measured.
fn or_dash(cell: Option<String>) -> String {
    cell.unwrap_or_else(|| NOT_MEASURED.into())
}

/// Bakes with default settings, by scene.
fn default_bakes(figures: &Figures) -> impl Iterator<Item = (&str, &Bake)> {
    let bakes = figures.bakes.iter().map(|(name, bake)| (name.as_str(), bake));
    bakes.filter(|(name, _)| !name.contains(' '))
}

/// The sets of bakes with default settings: those that the path tracer of this project sampled, or the others.
fn default_sets(figures: &Figures, are_sampled: bool) -> impl Iterator<Item = (&str, &Errors)> {
    default_bakes(figures)
        .flat_map(|(_, bake)| bake.sets.iter().map(|(name, errors)| (name.as_str(), errors)))
        .filter(move |(name, _)| is_sampled(name) == are_sampled)
}

fn errors(figures: &Figures) -> Table {
    let mut table = Table::new([
        "points",
        "relative RMSE:",
        "ideal lightmap's:",
        "above it:",
        "mean bias:",
        "median:",
        "95th percentile:",
        "wanted",
    ]);
    for (set, errors) in default_sets(figures, false) {
        table.row([
            set.into(),
            percent(errors.relative_rmse),
            or_dash(errors.floor.and_then(|floor| floor.floor).map(percent)),
            or_dash(errors.floor.and_then(|floor| floor.above_floor).map(percent)),
            or_dash(errors.mean_bias.map(signed_percent)),
            or_dash(errors.median_relative_error.map(percent)),
            or_dash(errors.p95_relative_error.map(percent)),
            or_dash(figures.wanted.get(set).map(|wanted| verdict(errors.relative_rmse, *wanted))),
        ]);
    }
    table
}

fn verdict(error: f64, wanted: f64) -> String {
    // As printed, so that the table does not contradict itself.
    let missed = if (1e4 * error).round() > (1e4 * wanted).round() { " (missed)" } else { "" };
    format!("≤ {:.0} %{missed}", 100.0 * wanted)
}

fn bakes(figures: &Figures) -> Table {
    let mut table = Table::new([
        "scene",
        "receivers:",
        "probes:",
        "bytes per receiver:",
        "file:",
        "compression error, mean:",
        "time:",
        "memory:",
        "frame, lights still:",
        "frame, lights moving:",
    ]);
    for (scene, bake) in default_bakes(figures) {
        table.row([
            scene.into(),
            or_dash(bake.receivers.map(grouped)),
            or_dash(bake.probes.map(grouped)),
            format!("{:.0}", bake.bytes_per_receiver),
            or_dash(bake.file_bytes.map(|bytes| format!("{:.1} MB", bytes as f64 * 1e-6))),
            or_dash(bake.compression_error.map(|error| format!("{:.1} %", 100.0 * error))),
            or_dash(bake.seconds.map(|seconds| format!("{seconds:.0} s"))),
            or_dash(bake.peak_mib.map(|mib| format!("{mib:.0} MiB"))),
            or_dash(bake.still_ms.map(milliseconds)),
            or_dash(bake.moving_ms.map(milliseconds)),
        ]);
    }
    table
}

fn random_lights(figures: &Figures) -> Table {
    let mut table =
        Table::new(["scene", "lights:", "relative RMSE, median:", "largest:", "mean of the biases' sizes:"]);
    for (scene, bake) in default_bakes(figures) {
        let Some(lights) = bake.random_lights else { continue };
        table.row([
            scene.into(),
            lights.lights.to_string(),
            percent(lights.median),
            or_dash(lights.largest.map(percent)),
            or_dash(lights.mean_bias_size.map(percent)),
        ]);
    }
    table
}

fn small_triangles(figures: &Figures) -> Table {
    let mut table = Table::new([
        "set",
        "relative RMSE:",
        "median:",
        "black:",
        "small triangles, relative RMSE:",
        "median:",
        "black:",
    ]);
    for (set, errors) in default_sets(figures, true) {
        let small = errors.small_triangles;
        table.row([
            set.into(),
            percent(errors.relative_rmse),
            or_dash(errors.median_relative_error.map(percent)),
            or_dash(errors.black_share.map(fine_percent)),
            or_dash(small.and_then(|small| small.relative_rmse).map(percent)),
            or_dash(small.and_then(|small| small.median_relative_error).map(percent)),
            or_dash(small.map(|small| fine_percent(small.black_share))),
        ]);
    }
    table
}

/// A share of which a thousandth of a per cent counts.
fn fine_percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

fn seams(figures: &Figures) -> Table {
    let mut table = Table::new(["set", "median:", "inside:", "99th percentile:", "inside:"]);
    for (set, errors) in default_sets(figures, false) {
        let Some(jumps) = errors.border_jumps else { continue };
        let cells = [jumps.median, jumps.median_inside, jumps.p99, jumps.p99_inside];
        let [median, median_inside, p99, p99_inside] = cells.map(|jump| or_dash(jump.map(percent)));
        table.row([set.into(), median, median_inside, p99, p99_inside]);
    }
    table
}

fn variants(figures: &Figures, variants: &[Variant]) -> Table {
    let [point, spot, area] = VARIED_SETS.map(|set| format!("{set}, bias:"));
    let mut table =
        Table::new(["part", "options", "bytes:", &point, &spot, &area, "random lights:", "frame:"]);
    for variant in variants {
        let Some(bake) = figures.bakes.get(&variant.bake()) else { continue };
        let error = |set| {
            let errors: Option<&Errors> = bake.sets.get(set);
            or_dash(errors.map(rmse_and_bias))
        };
        let [point, spot, area] = VARIED_SETS.map(error);
        table.row([
            variant.part.into(),
            if variant.options.is_empty() { String::new() } else { format!("`{}`", variant.options) },
            format!("{:.0}", bake.bytes_per_receiver),
            point,
            spot,
            area,
            or_dash(bake.random_lights.map(|lights| format!("{:.1}", 100.0 * lights.median))),
            or_dash(bake.still_ms.map(milliseconds)),
        ]);
    }
    table
}

/// Both in per cent.
fn rmse_and_bias(errors: &Errors) -> String {
    let bias = errors.mean_bias.map_or(String::new(), |bias| format!(" ({:+.1})", 100.0 * bias));
    format!("{:.2}{bias}", 100.0 * errors.relative_rmse)
}

fn gpu_errors(figures: &Figures) -> Table {
    let mut table = Table::new(["points", "CPU:", "GPU:"]);
    for (set, errors) in default_sets(figures, false) {
        let Some(gpu) = errors.gpu_relative_rmse else { continue };
        table.row([set.into(), percent(errors.relative_rmse), percent(gpu)]);
    }
    table
}

fn scaling(figures: &Figures) -> Table {
    let mut table =
        Table::new(["receivers:", "MB, CPU:", "CPU:", "of copy:", "MB, GPU:", "GPU:", "of copy:"]);
    let scenes = |backend| figures.scaling.get(backend).map_or(&[][..], |scaling| &scaling.scenes[..]);
    let [cpu, gpu] = ["cpu", "gpu"].map(scenes);
    let receivers: BTreeSet<u64> = cpu.iter().chain(gpu).map(|scene| scene.receivers).collect();
    for count in receivers {
        let cells = |scenes: &[SyntheticScene]| {
            let scene = scenes.iter().find(|scene| scene.receivers == count);
            [
                or_dash(scene.map(|scene| format!("{:.0}", scene.megabytes))),
                or_dash(scene.map(|scene| milliseconds(scene.shortest_ms))),
                or_dash(scene.map(|scene| format!("{:.1} %", 100.0 * scene.of_copy))),
            ]
        };
        let ([cpu_mb, cpu_ms, cpu_copy], [gpu_mb, gpu_ms, gpu_copy]) = (cells(cpu), cells(gpu));
        table.row([grouped(count), cpu_mb, cpu_ms, cpu_copy, gpu_mb, gpu_ms, gpu_copy]);
    }
    table
}

fn rays(figures: &Figures) -> Table {
    let mut table = Table::new(["scene", "closest hit:", "occlusion:"]);
    let pair = |[ours, embree]: [f64; 2]| format!("{ours:.2} / {embree:.2} = {:.2}", ours / embree);
    for (scene, rays) in &figures.rays {
        table.row([scene.clone(), pair(rays.closest_hit), pair(rays.occlusion)]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Scaling;

    #[test]
    fn missed_targets_are_said_as_they_are_printed() {
        assert_eq!(verdict(0.03, 0.03), "≤ 3 %");
        assert_eq!(verdict(0.030_04, 0.03), "≤ 3 %");
        assert_eq!(verdict(0.0301, 0.03), "≤ 3 % (missed)");
    }

    #[test]
    fn bakes_with_other_options_are_not_taken_for_defaults() {
        let errors = |relative_rmse| Errors { relative_rmse, ..Errors::default() };
        let bake = |rmse| Bake { sets: [("cornell_point".into(), errors(rmse))].into(), ..Bake::default() };
        let bakes = [("cornell".into(), bake(0.02)), ("cornell --rays 4096".into(), bake(0.5))];
        let figures = Figures { bakes: bakes.into(), ..Figures::default() };
        let table = by_name(&figures, "errors").unwrap();
        assert_eq!(table.lines().nth(2), Some("| cornell_point | 2.00 % | – | – | – | – | – | – |"));
        assert_eq!(table.lines().count(), 3);
        let budget = by_name(&figures, "error budget").unwrap();
        assert!(budget.contains("`--rays 4096`") && budget.contains("| 50.00 |"), "{budget}");
        assert!(by_name(&figures, "nonsense").is_err());
    }

    #[test]
    fn scaling_lists_sizes_of_either_backend() {
        let scaling = |receivers| Scaling {
            device: "d".into(),
            copy_gb_per_s: 10.0,
            scenes: vec![SyntheticScene { receivers, megabytes: 8.0, shortest_ms: 0.64, of_copy: 0.6 }],
        };
        let scaling = [("cpu".into(), scaling(50_176)), ("gpu".into(), scaling(100_096))];
        let figures = Figures { scaling: scaling.into(), ..Figures::default() };
        let table = by_name(&figures, "scaling").unwrap();
        assert!(table.contains("| 50,176 | 8 | 0.64 ms | 60.0 % | – | – | – |"), "{table}");
        assert!(table.contains("| 100,096 | – | – | – | 8 | 0.64 ms | 60.0 % |"), "{table}");
    }
}
