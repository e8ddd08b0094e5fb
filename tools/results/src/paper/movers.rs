//! Figures 11 and 12: light and shadow of what moves.

use probelight_render::{DisplayImage, ToneMap};
use serde_json::json;

use super::Values;
use super::setups::{Camera, Lights, Object, lamp, setup};
use super::sheets;
use super::workshop::{Shot, Workshop};
use crate::measure::shown;

/// The scene: a room with a red and a green wall.
const ROOM: &str = "cornell_empty";

/// Where the middle between the objects of figure 11 is along x, how far the bottle is from it, and what that is called.
/// The green wall is at 0, the red one at 5.5 m.
const PLACES: [(f32, f32, &str); 3] = [
    (4.45, 0.55, "beside the red wall"),
    (2.78, 0.55, "in the middle"),
    (1.15, -0.55, "beside the green wall"),
];

/// Exposures, as powers of two, of figures 11 and 12.
const EXPOSURES: [f32; 2] = [2.7, 1.3];

/// Makes figure 11: a bottle and a ball go from wall to wall.
pub(crate) fn bleeding(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut rows = Vec::new();
    for (flags, caption) in [
        ("--shading physical", "normal maps and gloss in the light of the grid"),
        ("--shading diffuse", "the same light, diffuse, by the vertices' normals"),
    ] {
        let pictures: anyhow::Result<Vec<DisplayImage>> =
            PLACES.iter().map(|(x, bottle, _)| beside_walls(workshop, [*x, *bottle], flags)).collect();
        rows.push((caption.to_owned(), pictures?));
    }
    let sheet = sheets::sheet(&PLACES.map(|(.., name)| name), rows);
    sheets::write(&sheet, &workshop.image("figure-11.png"))?;
    Ok(Values::new())
}

fn beside_walls(workshop: &Workshop, [x, bottle]: [f32; 2], flags: &str) -> anyhow::Result<DisplayImage> {
    let camera =
        Camera { position: [x, 1.35, -2.4], target: [x, 1.05, 1.6], vfov_deg: 38.0, size: [240, 240] };
    let objects = [
        Object { name: "water_bottle", position: [x + bottle, 1.05, 1.6], scale: 8.0, yaw_deg: 180.0 },
        Object { name: "ball", position: [x - 1.1 * bottle, 0.0, 1.3], scale: 2.0, yaw_deg: 0.0 },
    ];
    let objects: anyhow::Result<Vec<_>> = objects.iter().map(|object| workshop.placed(object)).collect();
    let name = format!("figure-11_{x}_{}", flags.trim_start_matches("--shading "));
    let setup = workshop.draft(&format!("{name}.json"), &setup(&Lights::Emitters, &camera, &objects?))?;
    let file = workshop.bake(ROOM, "")?;
    let flags = format!("--backend gpu --samples 16 {flags}");
    let picture = workshop.render(&Shot { name, file: &file, setup: &setup, flags: &flags })?;
    Ok(ToneMap::of_ev(EXPOSURES[0]).apply(&sheets::linear(&picture)?))
}

/// Moments of figure 12, seconds.
const MOMENTS: [f32; 3] = [0.0, 0.5, 1.0];

/// Where the lamp of figure 12 hangs, and what that is called.
const LAMPS: [([f32; 3], &str); 2] =
    [([4.6, 3.9, 0.9], "lamp on the left"), ([0.9, 1.5, 1.4], "lamp low on the right")];

/// Makes figure 12: a fox walks, the lamp is moved.
pub(crate) fn shadow(workshop: &Workshop) -> anyhow::Result<Values> {
    let mut rows = Vec::new();
    for (place, caption) in LAMPS {
        rows.push((caption.to_owned(), walk(workshop, place)?));
    }
    let columns = MOMENTS.map(|moment| format!("{moment:.1} s"));
    let sheet = sheets::sheet(&columns.each_ref().map(String::as_str), rows);
    sheets::write(&sheet, &workshop.image("figure-12.png"))?;
    Ok(Values::new())
}

fn walk(workshop: &Workshop, place: [f32; 3]) -> anyhow::Result<Vec<DisplayImage>> {
    let camera =
        Camera { position: [2.78, 2.5, -3.4], target: [2.78, 1.5, 2.8], vfov_deg: 46.0, size: [280, 210] };
    let at =
        |time: f32, x: f32| json!({ "time": time, "position": [x, 0, 2.9], "yaw_deg": -90, "scale": 0.024 });
    let fox = json!({ "file": shown(&workshop.scene("fox")?), "clip": "Walk", "path": [at(0.0, 3.9), at(1.0, 1.9)] });
    let name = format!("figure-12_{}", place[0]);
    let text = setup(&lamp(place, [13.0, 11.5, 9.0]), &camera, &[fox]);
    let setup = workshop.draft(&format!("{name}.json"), &text)?;
    let (file, frames) = (workshop.bake(ROOM, "")?, workshop.kept(&name));
    let exposure = EXPOSURES[1].to_string();
    let arguments = [
        "render",
        &shown(&file),
        "--setup",
        &shown(&setup),
        "--backend",
        "cpu",
        "--samples",
        "64",
        "--animate",
        "1.25",
        "--fps",
        "2",
        "--exposure",
        &exposure,
        "-o",
        &shown(&frames),
    ];
    workshop.run(&name, &arguments.map(String::from), Some(&frames))?;
    (0..MOMENTS.len()).map(|frame| sheets::displayed(&frames.join(format!("frame_{frame:04}.png")))).collect()
}
