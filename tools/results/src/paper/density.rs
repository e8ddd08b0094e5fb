//! Figure 14 and the table beside it: what a grid of more vertices, of other bases and lobes brings and costs.

use std::path::{Path, PathBuf};

use probelight_render::comparison::difference;
use probelight_render::{Image, ToneMap};
use serde_json::Value;

use super::Values;
use super::setups::{Camera, Lights, Object, setup};
use super::sheets::{self, Cut};
use super::workshop::{Shot, Workshop, number};
use crate::lookup::{NOT_MEASURED, as_block, grouped, percent};
use crate::measure::shown;
use crate::tables::Table;

/// Few receivers on surfaces, as the grid does not depend on them, and as many rays in each bake.
const SURFACES: &str = "--receivers 8000 --rays 256";

/// How much differences are amplified in pictures.
const GAIN: f32 = 4.0;

/// What pictures are exposed with and compared by.
const SHOWN: ToneMap = ToneMap { scale: 5.5 };

/// A bake of a scene with some grid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grid {
    scene: &'static str,
    basis: &'static str,
    lobe: &'static str,
    /// Options that say how many vertices there are.
    spacing: &'static str,
}

/// Spacings of the Cornell box that divide it into 6, 11 and 19 cells along each axis: 343, 1,728 and 8,000 places.
const SPACINGS: [&str; 3] = ["--grid-spacing 0.935", "--grid-spacing 0.51", "--grid-spacing 0.295"];

/// The published numbers of receivers for a scene whose ground is far wider than its rooms.
const ROOMS: [&str; 2] = ["--grid-levels 1 --grid 350", "--grid-levels 1 --grid 8000"];

/// Bases with their lobes; those behind the first four are left out where there are most vertices.
const BASES: [(&str, &str); 7] = [
    ("sh2", "cosine"),
    ("axes6", "angle"),
    ("axes6", "cosine"),
    ("axes14", "cosine"),
    ("axes14", "angle"),
    ("axes26", "angle"),
    ("axes26", "cosine"),
];

/// Bases of the densest grid.
const DENSE_BASES: usize = 4;

impl Grid {
    fn options(&self) -> String {
        format!("{SURFACES} {} --grid-basis {} --grid-lobe {}", self.spacing, self.basis, self.lobe)
    }

    /// The grid of the same kind with the most vertices.
    fn densest(self) -> Self {
        Self { spacing: SPACINGS[SPACINGS.len() - 1], ..self }
    }
}

/// All rows of the table, in order.
fn grids() -> Vec<Grid> {
    let cornell = |spacing: usize| {
        let bases = if spacing + 1 < SPACINGS.len() { &BASES[..] } else { &BASES[..DENSE_BASES] };
        let grid = move |(basis, lobe): &(&'static str, &'static str)| Grid {
            scene: "cornell",
            basis,
            lobe,
            spacing: SPACINGS[spacing],
        };
        bases.iter().map(grid)
    };
    let rooms = |spacing: &'static str| {
        BASES[..2].iter().map(move |(basis, lobe)| Grid { scene: "rooms", basis, lobe, spacing })
    };
    (0..SPACINGS.len()).flat_map(cornell).chain(ROOMS.into_iter().flat_map(rooms)).collect()
}

/// Makes figure 14: the published basis and the default one, few and many vertices, and the path tracer's picture.
pub(crate) fn pictures(workshop: &Workshop) -> anyhow::Result<Values> {
    let truth = reference(workshop)?;
    let mut values = Values::new();
    let mut rows = Vec::new();
    for (name, (basis, lobe)) in [("published", BASES[1]), ("default", BASES[0])] {
        let sparse = Grid { scene: "cornell", basis, lobe, spacing: SPACINGS[0] };
        let (few, many) = (picture(workshop, &sparse)?, picture(workshop, &sparse.densest())?);
        let whole = similarity(&few, &many)?;
        let [least, most] = of_objects(&few, &many)?;
        let [few_true, many_true] = [similarity(&few, &truth)?, similarity(&many, &truth)?];
        rows.push((
            format!("{basis}: SSIM {whole:.3}; to the path tracer {few_true:.3} and {many_true:.3}"),
            vec![
                SHOWN.apply(&few),
                SHOWN.apply(&many),
                difference(&few, &many, SHOWN, GAIN),
                SHOWN.apply(&truth),
            ],
        ));
        values.insert(format!("14 {name}"), format!("{whole:.3}"));
        values.insert(format!("14 {name} objects"), format!("{least:.3} to {most:.3}"));
        values.insert(format!("14 {name} truth"), format!("{few_true:.3} and {many_true:.3}"));
    }
    let columns = ["7 x 7 x 7 vertices", "20 x 20 x 20 vertices", "difference, 4 times", "path tracer"];
    sheets::write(&sheets::sheet(&columns, rows), &workshop.image("figure-14.png"))?;
    Ok(values)
}

fn similarity(image: &Image, reference: &Image) -> anyhow::Result<f64> {
    sheets::similarity(image, reference, SHOWN)
}

/// Where the objects are in the picture.
const OBJECTS: [Cut; 3] = [[19, 47, 61, 129], [101, 36, 50, 51], [150, 82, 52, 107]];

/// The least and the greatest similarity of the parts with objects.
fn of_objects(few: &Image, many: &Image) -> anyhow::Result<[f64; 2]> {
    let similarity = |part: &Cut| similarity(&sheets::cut(few, *part), &sheets::cut(many, *part));
    let parts: Vec<f64> = OBJECTS.iter().map(similarity).collect::<anyhow::Result<_>>()?;
    Ok([parts.iter().copied().fold(f64::INFINITY, f64::min), parts.iter().copied().fold(0.0, f64::max)])
}

/// The box with three objects, in the light of its lamp, all of which comes to them from the grid.
fn stage(workshop: &Workshop) -> anyhow::Result<PathBuf> {
    let camera =
        Camera { position: [2.6, 2.3, -3.3], target: [2.6, 1.35, 1.5], vfov_deg: 50.0, size: [208, 196] };
    let objects = [
        Object { name: "flight_helmet", position: [3.8, 0.0, 1.1], scale: 3.4, yaw_deg: 195.0 },
        Object { name: "ball", position: [2.1, 1.65, 1.7], scale: 1.7, yaw_deg: 0.0 },
        Object { name: "water_bottle", position: [1.3, 0.92, 0.2], scale: 7.0, yaw_deg: 180.0 },
    ];
    let objects: anyhow::Result<Vec<Value>> = objects.iter().map(|object| workshop.placed(object)).collect();
    workshop.draft("figure-14.json", &setup(&Lights::Emitters, &camera, &objects?))
}

fn picture(workshop: &Workshop, grid: &Grid) -> anyhow::Result<Image> {
    let (file, setup) = (workshop.bake(grid.scene, &grid.options())?, stage(workshop)?);
    let name = format!("figure-14_{}_{}_{}", grid.basis, grid.lobe, grid.spacing.replace(' ', "_"));
    let flags = "--backend cpu --samples 36";
    sheets::linear(&workshop.render(&Shot { name, file: &file, setup: &setup, flags })?)
}

/// The path tracer's picture.
fn reference(workshop: &Workshop) -> anyhow::Result<Image> {
    let picture = workshop.kept("figure-14_reference.exr");
    let [scene, setup, out] = [&workshop.scene("cornell")?, &stage(workshop)?, &picture].map(shown);
    let arguments =
        ["reference", &scene, "--setup", &setup, "--camera", "figure", "--samples", "1024", "-o", &out];
    workshop.run("figure-14_reference", &arguments.map(String::from), Some(&picture))?;
    sheets::linear(&picture)
}

/// Measures the table of bases, lobes and spacings.
pub(crate) fn bases(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut table = Table::new([
        "scene",
        "basis",
        "lobe",
        "vertices:",
        "spacing:",
        "bytes a vertex:",
        "of the file:",
        "SSIM to path tracer:",
        "error by light",
    ]);
    for grid in grids() {
        table.row(row(workshop, &grid)?);
    }
    Ok(Values::from([("table bases".into(), as_block(&table.markdown()))]))
}

fn row(workshop: &Workshop, grid: &Grid) -> anyhow::Result<[String; 9]> {
    let file = workshop.bake(grid.scene, &grid.options())?;
    let info = workshop.info(&file)?;
    let [vertices, bytes] = ["/grid_vertices", "/grid_bytes"].map(|figure| number(&info, figure));
    let (vertices, bytes) = (vertices?, bytes?);
    let share = bytes / number(&info, "/file_bytes")?;
    Ok([
        grid.scene.into(),
        format!("`{}`", grid.basis),
        if grid.basis == "sh2" { NOT_MEASURED.into() } else { grid.lobe.into() },
        grouped(vertices as u64),
        format!("{:.2} m", number(&info, "/grid/spacing/0")?),
        grouped((bytes / vertices).round() as u64),
        format!("{:.2} MB, {:.0} %", 1e-6 * bytes, 100.0 * share),
        to_reference(workshop, grid)?,
        errors(workshop, grid, &file)?,
    ])
}

/// Similarity of figure 14's picture to that of the path tracer.
fn to_reference(workshop: &Workshop, grid: &Grid) -> anyhow::Result<String> {
    if grid.scene != "cornell" {
        return Ok(NOT_MEASURED.into());
    }
    Ok(format!("{:.3}", similarity(&picture(workshop, grid)?, &reference(workshop)?)?))
}

/// Relative root mean square errors at points in free space, by light.
fn errors(workshop: &Workshop, grid: &Grid, file: &Path) -> anyhow::Result<String> {
    let lights: &[&str] = if grid.scene == "rooms" {
        &["pointA", "sunsky", "sun", "pointC"]
    } else {
        &["area", "point", "spot"]
    };
    let error = |light: &&str| {
        let set = format!("{}_{light}", grid.scene);
        let [file, setup, points] = [file, &workshop.setup(&set)?, &workshop.points(&set)?].map(shown);
        let arguments =
            ["eval", &file, "--setup", &setup, "--points", &points, "--backend", "cpu"].map(String::from);
        let name = format!("eval_{set}_{}", grid.options().replace(' ', "_"));
        let report = workshop.run(&name, &arguments, None)?;
        Ok(format!("{light} {}", percent(number(&report, "/free_space/relative_rmse")?)))
    };
    Ok(lights.iter().map(error).collect::<anyhow::Result<Vec<_>>>()?.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grids_of_the_figure_are_in_the_table() {
        let grids = grids();
        for (basis, lobe) in &BASES[..2] {
            let sparse = Grid { scene: "cornell", basis, lobe, spacing: SPACINGS[0] };
            assert!(grids.contains(&sparse) && grids.contains(&sparse.densest()));
        }
        assert_eq!(grids.len(), 2 * BASES.len() + DENSE_BASES + 2 * ROOMS.len());
    }
}
