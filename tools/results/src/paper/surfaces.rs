//! Figure 13: normal maps and gloss on the static scene.

use probelight_render::{Exposure, ToneMap};

use super::Values;
use super::setups::{Camera, setup, sun_and_sky};
use super::sheets;
use super::workshop::{Shot, Workshop};

/// A wall and a floor that only bounced light and the sky reach.
const CAMERA: Camera =
    Camera { position: [-9.5, 1.5, -6.9], target: [-4.5, 0.7, -8.4], vfov_deg: 55.0, size: [352, 264] };

/// Makes figure 13.
pub(crate) fn draw(workshop: &Workshop) -> anyhow::Result<Values> {
    let file = workshop.bake("atrium", "")?;
    let setup = workshop.draft("figure-13.json", &setup(&sun_and_sky(), &CAMERA, &[]))?;
    let mut rows = Vec::new();
    for (view, caption) in [("full", "all light"), ("irradiance", "irradiance alone")] {
        let mut pictures = Vec::new();
        for shading in ["diffuse", "physical"] {
            let name = format!("figure-13_{view}_{shading}");
            let flags = format!("--backend gpu --view {view} --shading {shading}");
            let shot = Shot { name, file: &file, setup: &setup, flags: &flags };
            pictures.push(sheets::linear(&workshop.render(&shot)?)?);
        }
        // Both as bright, so that they can be compared.
        let tone_map = ToneMap::new(Exposure::Automatic, &pictures[0]);
        rows.push((caption.to_owned(), pictures.iter().map(|picture| tone_map.apply(picture)).collect()));
    }
    let columns = ["without: diffuse, vertices' normals", "with normal maps and gloss"];
    sheets::write(&sheets::sheet(&columns, rows), &workshop.image("figure-13.png"))?;
    Ok(Values::new())
}
