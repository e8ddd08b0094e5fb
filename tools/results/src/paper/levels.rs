//! Figures 3, 15 and 16: pictures with less detail.

use std::path::{Path, PathBuf};

use anyhow::Context;
use probelight_render::DisplayImage;
use serde_json::{Value, json};

use super::Values;
use super::sheets;
use super::workshop::{Workshop, number};
use crate::lookup::{as_block, grouped};
use crate::measure::shown;
use crate::tables::Table;

/// A comparison of levels of detail with none.
pub(crate) struct Comparison<'a> {
    /// Unique among those that are kept.
    pub(crate) name: &'a str,
    /// A baked file.
    pub(crate) file: &'a Path,
    pub(crate) setup: &'a Path,
    pub(crate) camera: &'a str,
    /// Levels, as `--lod` takes them.
    pub(crate) levels: &'a [String],
    /// Further flags of `eval-lod`.
    pub(crate) flags: &'a str,
}

/// What was found.
pub(crate) struct Compared {
    folder: PathBuf,
    /// Of each levels, in their order, as `eval-lod` reports them.
    pub(crate) rows: Vec<Value>,
}

impl Comparison<'_> {
    /// Runs it, or takes what was kept of the same.
    pub(crate) fn run(&self, workshop: &Workshop) -> anyhow::Result<Compared> {
        let folder = workshop.kept(self.name);
        let [file, setup, pictures] = [self.file, self.setup, &folder].map(shown);
        let mut arguments: Vec<String> =
            ["eval-lod", &file, "--setup", &setup, "--camera", self.camera].map(String::from).to_vec();
        arguments.extend(self.flags.split_whitespace().map(String::from));
        arguments.extend(["--pictures".into(), pictures, "--lod".into()]);
        arguments.extend_from_slice(self.levels);
        let report = workshop.run(self.name, &arguments, Some(&folder))?;
        let rows = report["rows"].as_array().context("eval-lod reports no rows")?.clone();
        Ok(Compared { folder, rows })
    }
}

impl Compared {
    /// A picture of a row: `exact`, `lod` or `difference`.
    fn picture(&self, row: &Value, what: &str) -> anyhow::Result<DisplayImage> {
        let text = |field: &str| row[field].as_str().unwrap_or_default().replace('/', "-");
        let name = format!("{}-{}-{what}.png", text("camera"), text("lod"));
        sheets::displayed(&self.folder.join(name))
    }
}

/// Bands of figure 3.
const DEGREES: [u32; 4] = [0, 2, 4, 7];

/// Makes figure 3: all light from probes with fewer bands, by the published method and by the default one.
pub(crate) fn degrees(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut values = Values::new();
    let mut rows = Vec::new();
    for (name, options) in [("paper", "--method paper --grid 0"), ("hybrid", "--grid 0")] {
        let compared = with_degrees(workshop, name, options)?;
        let similarity: Vec<String> = (compared.rows.iter())
            .map(|row| Ok(format!("{:.3}", number(row, "/ssim")?)))
            .collect::<anyhow::Result<_>>()?;
        let pictures: anyhow::Result<Vec<_>> =
            compared.rows.iter().map(|row| compared.picture(row, "lod")).collect();
        rows.push((format!("--method {name}: SSIM to degree 7: {}", similarity.join(", ")), pictures?));
        values.insert(format!("3 {name}"), similarity[..DEGREES.len() - 1].join(", "));
    }
    let columns = DEGREES.map(|degree| format!("degree {degree}"));
    let sheet = sheets::sheet(&columns.each_ref().map(String::as_str), rows);
    sheets::write(&sheet, &workshop.image("figure-3.png"))?;
    Ok(values)
}

fn with_degrees(workshop: &Workshop, name: &str, options: &str) -> anyhow::Result<Compared> {
    let level = |degree: &u32| {
        let text = json!({ "levels": [{ "distance": 0.0, "degree": degree }] }).to_string();
        Ok(shown(&workshop.draft(&format!("degree-{degree}.json"), &text)?))
    };
    let levels: anyhow::Result<Vec<String>> = DEGREES.iter().map(level).collect();
    Comparison {
        name: &format!("figure-3_{name}"),
        file: &workshop.bake("cornell", options)?,
        setup: &workshop.setup("cornell_spot")?,
        camera: "front",
        levels: &levels?,
        flags: "--light still --frames 8 --size 188x188",
    }
    .run(workshop)
}

/// Makes figure 15: pictures without and with the published levels, and with the same nearer.
pub(crate) fn with_and_without(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut table = Table::new(["camera", "levels", "receivers:", "of:", "times fewer bytes:", "SSIM:"]);
    let mut rows = Vec::new();
    for camera in ["court", "upper"] {
        let compared = published(workshop, &format!("figure-15_{camera}"), camera, &[1.0, 0.3])?;
        for row in &compared.rows {
            table.row(table_row(row)?);
            let pictures: anyhow::Result<Vec<_>> =
                ["exact", "lod", "difference"].iter().map(|what| compared.picture(row, what)).collect();
            rows.push((caption(row)?, pictures?));
        }
    }
    // Three rows are enough to see it: the second camera as published only.
    rows.truncate(3);
    let columns = ["no levels of detail", "levels of detail", "difference, 8 times"];
    sheets::write(&sheets::sheet(&columns, rows), &workshop.image("figure-15.png"))?;
    Ok(Values::from([("table levels".into(), as_block(&table.markdown()))]))
}

/// The atrium with the published levels at shares of their distances.
fn published(workshop: &Workshop, name: &str, camera: &str, shares: &[f32]) -> anyhow::Result<Compared> {
    let levels: Vec<String> = shares.iter().map(|share| format!("published@{share}")).collect();
    Comparison {
        name,
        file: &workshop.bake("atrium", "")?,
        setup: &workshop.setup("atrium_sunsky")?,
        camera,
        levels: &levels,
        flags: "--frames 12 --dolly 2 --turn 20 --size 216x162",
    }
    .run(workshop)
}

fn caption(row: &Value) -> anyhow::Result<String> {
    let share = number(row, "/receivers")? / number(row, "/receivers_all")?;
    let [camera, levels] = ["camera", "lod"].map(|field| row[field].as_str().unwrap_or_default());
    Ok(format!(
        "{camera}, {levels}: {:.0} % of the receivers, SSIM {:.3}",
        100.0 * share,
        number(row, "/ssim")?
    ))
}

fn table_row(row: &Value) -> anyhow::Result<[String; 6]> {
    let text = |field: &str| row[field].as_str().unwrap_or_default().to_owned();
    Ok([
        text("camera"),
        format!("`{}`", text("lod")),
        grouped(number(row, "/receivers")?.round() as u64),
        grouped(number(row, "/receivers_all")? as u64),
        format!("{:.2}", number(row, "/bytes_all")? / number(row, "/bytes")?),
        format!("{:.4}", number(row, "/ssim")?),
    ])
}

/// Shares of the published distances in figure 16.
const SHARES: [f32; 4] = [1.0, 0.5, 0.25, 0.1];

/// Makes figure 16: the same levels nearer and nearer.
pub(crate) fn distances(workshop: &Workshop) -> anyhow::Result<Values> {
    let compared = published(workshop, "figure-16", "court", &SHARES)?;
    let mut columns = Vec::new();
    let [mut pictures, mut differences] = [const { Vec::new() }; 2];
    for (row, share) in compared.rows.iter().zip(SHARES) {
        columns.push(format!("{share} of the distances: SSIM {:.3}", number(row, "/ssim")?));
        pictures.push(compared.picture(row, "lod")?);
        differences.push(compared.picture(row, "difference")?);
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let rows =
        vec![("with levels of detail".into(), pictures), ("difference to none, 8 times".into(), differences)];
    sheets::write(&sheets::sheet(&columns, rows), &workshop.image("figure-16.png"))?;
    let similarity: anyhow::Result<Vec<String>> =
        compared.rows.iter().map(|row| Ok(format!("{:.3}", number(row, "/ssim")?))).collect();
    Ok(Values::from([("16".into(), similarity?.join(", "))]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_say_what_was_saved() {
        let row = json!({
            "lod": "published@0.3", "camera": "court", "receivers": 1000.4, "receivers_all": 4000,
            "bytes": 50.0, "bytes_all": 100, "ssim": 0.95678,
        });
        let cells = ["court", "`published@0.3`", "1,000", "4,000", "2.00", "0.9568"];
        assert_eq!(table_row(&row).unwrap(), cells.map(String::from));
        assert_eq!(caption(&row).unwrap(), "court, published@0.3: 25 % of the receivers, SSIM 0.957");
        assert!(caption(&json!({})).is_err());
    }
}
