//! Figure 14 and the table beside it: what a grid of more vertices, of other bases and lobes brings and costs.

use probelight_render::comparison::difference;
use probelight_render::{Exposure, Image, ToneMap};
use serde_json::Value;

use super::Values;
use super::setups::{Camera, Lights, Object, setup};
use super::sheets::{self, Cut};
use super::workshop::{Shot, Workshop, number};
use crate::lookup::{NOT_MEASURED, grouped, percent};
use crate::tables::Table;

/// Few receivers on surfaces, as the grid does not depend on them, and as many rays in each bake.
const SURFACES: &str = "--receivers 8000 --rays 256";

/// How much differences are amplified in pictures.
const GAIN: f32 = 4.0;

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

    fn has_densest(&self) -> bool {
        self.scene == "cornell" && BASES[..DENSE_BASES].contains(&(self.basis, self.lobe))
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

/// Makes figure 14: the published basis and the default one, few and many vertices.
pub(crate) fn pictures(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut values = Values::new();
    let mut rows = Vec::new();
    for (name, (basis, lobe)) in [("published", BASES[1]), ("default", BASES[0])] {
        let sparse = Grid { scene: "cornell", basis, lobe, spacing: SPACINGS[0] };
        let (few, many) = (picture(workshop, &sparse)?, picture(workshop, &sparse.densest())?);
        let tone_map = ToneMap::new(Exposure::Automatic, &many);
        let whole = sheets::similarity(&few, &many, tone_map)?;
        let [least, most] = of_objects(&few, &many, tone_map)?;
        rows.push((
            format!("{basis}, lobes by {lobe}: SSIM {whole:.3}, around the objects {least:.3} to {most:.3}"),
            vec![tone_map.apply(&few), tone_map.apply(&many), difference(&few, &many, tone_map, GAIN)],
        ));
        values.insert(format!("14 {name}"), format!("{whole:.3}"));
        values.insert(format!("14 {name} objects"), format!("{least:.3} to {most:.3}"));
    }
    let columns = ["7 x 7 x 7 vertices", "20 x 20 x 20 vertices", "difference, 4 times"];
    sheets::write(&sheets::sheet(&columns, rows), &workshop.image("figure-14.png"))?;
    Ok(values)
}

/// Where the objects are in the picture.
const OBJECTS: [Cut; 3] = [[24, 60, 78, 164], [128, 46, 64, 64], [190, 104, 66, 136]];

/// The least and the greatest similarity of the parts with objects.
fn of_objects(few: &Image, many: &Image, tone_map: ToneMap) -> anyhow::Result<[f64; 2]> {
    let similarity =
        |part: &Cut| sheets::similarity(&sheets::cut(few, *part), &sheets::cut(many, *part), tone_map);
    let parts: Vec<f64> = OBJECTS.iter().map(similarity).collect::<anyhow::Result<_>>()?;
    Ok([parts.iter().copied().fold(f64::INFINITY, f64::min), parts.iter().copied().fold(0.0, f64::max)])
}

/// The box with three objects, in the light of its lamp, all of which comes to them from the grid.
fn picture(workshop: &Workshop, grid: &Grid) -> anyhow::Result<Image> {
    let camera =
        Camera { position: [2.6, 2.3, -3.3], target: [2.6, 1.35, 1.5], vfov_deg: 50.0, size: [264, 248] };
    let objects = [
        Object { name: "flight_helmet", position: [3.8, 0.0, 1.1], scale: 3.4, yaw_deg: 195.0 },
        Object { name: "ball", position: [2.1, 1.65, 1.7], scale: 1.7, yaw_deg: 0.0 },
        Object { name: "water_bottle", position: [1.3, 0.92, 0.2], scale: 7.0, yaw_deg: 180.0 },
    ];
    let objects: anyhow::Result<Vec<Value>> = objects.iter().map(|object| workshop.placed(object)).collect();
    let setup = workshop.draft("figure-14.json", &setup(&Lights::Emitters, &camera, &objects?))?;
    let file = workshop.bake(grid.scene, &grid.options())?;
    let name = format!("figure-14_{}_{}_{}", grid.basis, grid.lobe, grid.spacing.replace(' ', "_"));
    let flags = "--backend cpu --samples 36";
    sheets::linear(&workshop.render(&Shot { name, file: &file, setup: &setup, flags })?)
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
        "SSIM:",
        "error by light",
    ]);
    for grid in grids() {
        table.row(row(workshop, &grid)?);
    }
    Ok(Values::from([("table bases".into(), format!("\n\n{}\n\n", table.markdown().trim_end()))]))
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
        to_densest(workshop, grid)?,
        errors(workshop, grid, &file)?,
    ])
}

/// Similarity of the picture to that of the densest grid of the same kind.
fn to_densest(workshop: &Workshop, grid: &Grid) -> anyhow::Result<String> {
    if !grid.has_densest() {
        return Ok(NOT_MEASURED.into());
    }
    let (few, many) = (picture(workshop, grid)?, picture(workshop, &grid.densest())?);
    let similarity = sheets::similarity(&few, &many, ToneMap::new(Exposure::Automatic, &many))?;
    Ok(format!("{similarity:.3}"))
}

/// Relative root mean square errors at points in free space, by light.
fn errors(workshop: &Workshop, grid: &Grid, file: &std::path::Path) -> anyhow::Result<String> {
    let lights: &[&str] = if grid.scene == "rooms" {
        &["pointA", "sunsky", "sun", "pointC"]
    } else {
        &["area", "point", "spot"]
    };
    let error = |light: &&str| {
        let set = format!("{}_{light}", grid.scene);
        let [file, setup, points] =
            [file, &workshop.setup(&set)?, &workshop.points(&set)?].map(super::workshop::shown);
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
    fn every_row_with_a_densest_grid_finds_it_in_the_table() {
        let grids = grids();
        assert!(grids.iter().filter(|grid| grid.has_densest()).all(|grid| grids.contains(&grid.densest())));
        assert_eq!(grids.iter().filter(|grid| !grid.has_densest()).count(), 3 * 2 + 4);
    }
}
