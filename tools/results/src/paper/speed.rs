//! Figures 17 and 18: what levels of detail save.

use std::path::Path;

use plotters::prelude::SeriesLabelPosition;
use serde_json::Value;

use super::Values;
use super::chart::{Panel, Series, draw};
use super::levels::Comparison;
use super::workshop::{Workshop, number};
use crate::lookup::{as_block, grouped};
use crate::tables::Table;

/// The fastest of the paper's six settings: SSIM and speed-up.
const FASTEST_PUBLISHED: (f64, f64) = (0.972, 4.34);

/// Levels of figure 17, by their preset.
const PRESETS: [(&str, &[&str]); 2] = [
    ("published", &["published", "published@0.5", "published@0.3", "published@0.2", "published@0.1"]),
    ("low", &["high", "medium", "low", "low@0.5", "low@0.25", "low@0.1"]),
];

/// Makes figure 17: bytes, time and speed-up against similarity.
pub(crate) fn against_similarity(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut table = Table::new(["levels", "SSIM:", "bytes:", "times fewer bytes:", "time:", "times faster:"]);
    let mut curves = Curves::default();
    for (name, levels) in PRESETS {
        let rows = compare(workshop, &format!("figure-17_{name}"), "atrium", "", levels, "")?;
        for row in &rows {
            table.row(speed_row(row)?);
        }
        let shown = if name == "low" { "high, medium, low and nearer" } else { "published and nearer" };
        curves.add(shown, &rows, "/ssim")?;
    }
    curves.savings.push(Series::new("[SED], fastest, time", vec![FASTEST_PUBLISHED]));
    let legends = [SeriesLabelPosition::LowerLeft, SeriesLabelPosition::UpperLeft];
    curves.draw("SSIM to no levels of detail", legends, &workshop.image("figure-17.svg"))?;
    Ok(Values::from([("table speed".into(), as_block(&table.markdown()))]))
}

/// What levels of detail read and save, against something.
#[derive(Default)]
struct Curves {
    /// Megabytes.
    bytes: Vec<Series>,
    /// Times fewer bytes, and times faster.
    savings: Vec<Series>,
}

impl Curves {
    /// Adds rows of `eval-lod`; `x` is the field that they are set against.
    fn add(&mut self, name: &str, rows: &[Value], x: &str) -> anyhow::Result<()> {
        self.bytes.push(series(name, rows, x, |row| Ok(1e-6 * number(row, "/bytes")?))?);
        self.savings.push(series(name, rows, x, fewer_bytes)?);
        let time = |row: &Value| number(row, "/speedup");
        self.savings.push(series(&format!("{name}, time"), rows, x, time)?.dotted());
        Ok(())
    }

    /// Draws both side by side.
    fn draw(self, x: &str, legends: [SeriesLabelPosition; 2], path: &Path) -> anyhow::Result<()> {
        let [of_bytes, of_savings] = legends;
        let panels = [
            Panel { x, y: "MB of matrices a frame", series: self.bytes, legend: of_bytes },
            Panel {
                x,
                y: "times fewer bytes; times faster (open)",
                series: self.savings,
                legend: of_savings,
            },
        ];
        draw(&panels, path)
    }
}

/// Numbers of receivers of figure 18, as options of the bake.
const DENSITIES: [&str; 4] =
    ["--grid 0 --receivers 50000", "--grid 0 --receivers 100000", "--grid 0 --receivers 200000", ""];

/// Makes figure 18: scenes with more and more receivers, the levels held at an SSIM of 0.9.
pub(crate) fn against_receivers(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut table = Table::new([
        "receivers:",
        "bytes without:",
        "levels",
        "SSIM:",
        "receivers with:",
        "bytes with:",
        "times fewer bytes:",
        "times faster:",
    ]);
    let mut of_levels = vec![Vec::new(), Vec::new()];
    for (number, options) in DENSITIES.iter().enumerate() {
        let name = format!("figure-18_{number}");
        let rows = compare(workshop, &name, "atrium", options, &["published", "low"], "--hold-ssim 0.9")?;
        for (row, rows) in rows.into_iter().zip(&mut of_levels) {
            table.row(density_row(&row)?);
            rows.push(row);
        }
    }
    let mut curves = Curves::default();
    for (name, rows) in ["published levels", "low"].into_iter().zip(&of_levels) {
        curves.add(name, rows, "/receivers_all")?;
    }
    // Last, so that the others have the same colours in both charts.
    let all = |row: &Value| Ok(1e-6 * number(row, "/bytes_all")?);
    curves.bytes.push(series("no levels of detail", &of_levels[0], "/receivers_all", all)?);
    let legends = [SeriesLabelPosition::UpperLeft, SeriesLabelPosition::UpperRight];
    curves.draw("receivers", legends, &workshop.image("figure-18.svg"))?;
    Ok(Values::from([("table receivers".into(), as_block(&table.markdown()))]))
}

/// Compares levels with none while the camera moves through a scene.
fn compare(
    workshop: &Workshop,
    name: &str,
    scene: &str,
    options: &str,
    levels: &[&str],
    flags: &str,
) -> anyhow::Result<Vec<Value>> {
    let levels: Vec<String> = levels.iter().map(ToString::to_string).collect();
    let compared = Comparison {
        name,
        file: &workshop.bake(scene, options)?,
        setup: &workshop.setup("atrium_sunsky")?,
        camera: "court",
        levels: &levels,
        flags: &format!("--frames 12 --dolly 2 --turn 20 {flags}"),
    }
    .run(workshop)?;
    Ok(compared.rows)
}

fn fewer_bytes(row: &Value) -> anyhow::Result<f64> {
    Ok(number(row, "/bytes_all")? / number(row, "/bytes")?)
}

/// A series of rows.
fn series(
    name: &str,
    rows: &[Value],
    x: &str,
    y: impl Fn(&Value) -> anyhow::Result<f64>,
) -> anyhow::Result<Series> {
    let points = rows.iter().map(|row| Ok((number(row, x)?, y(row)?)));
    Ok(Series::new(name, points.collect::<anyhow::Result<_>>()?))
}

fn speed_row(row: &Value) -> anyhow::Result<[String; 6]> {
    Ok([
        format!("`{}`", row["lod"].as_str().unwrap_or_default()),
        format!("{:.4}", number(row, "/ssim")?),
        format!("{:.1} MB", 1e-6 * number(row, "/bytes")?),
        format!("{:.2}", fewer_bytes(row)?),
        format!("{:.1} ms", number(row, "/ms")?),
        format!("{:.2}", number(row, "/speedup")?),
    ])
}

fn density_row(row: &Value) -> anyhow::Result<[String; 8]> {
    let megabytes = |field| Ok::<_, anyhow::Error>(format!("{:.1} MB", 1e-6 * number(row, field)?));
    Ok([
        grouped(number(row, "/receivers_all")? as u64),
        megabytes("/bytes_all")?,
        format!("`{}`", row["lod"].as_str().unwrap_or_default()),
        format!("{:.3}", number(row, "/ssim")?),
        grouped(number(row, "/receivers")?.round() as u64),
        megabytes("/bytes")?,
        format!("{:.2}", fewer_bytes(row)?),
        format!("{:.2}", number(row, "/speedup")?),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_have_bytes_and_times() {
        let row = json!({
            "lod": "low", "ssim": 0.9, "bytes": 5e6, "bytes_all": 20_000_000, "ms": 2.0, "speedup": 3.0,
            "receivers": 500.0, "receivers_all": 1000,
        });
        assert_eq!(speed_row(&row).unwrap(), ["`low`", "0.9000", "5.0 MB", "4.00", "2.0 ms", "3.00"]);
        assert_eq!(density_row(&row).unwrap()[..3], ["1,000", "20.0 MB", "`low`"]);
        assert!(speed_row(&json!({ "lod": "low" })).is_err());
    }
}
