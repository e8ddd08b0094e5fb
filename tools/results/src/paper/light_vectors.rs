//! Figure 4: directional irradiance at the grid's vertices around a point, and the light vector that follows.

use std::fmt::Write;

use anyhow::{Context, ensure};
use probelight_math::color::luminance;
use probelight_math::glam::{Vec2, Vec3};
use probelight_render::{DisplayImage, ToneMap};
use serde_json::Value;

use super::Values;
use super::setups::{self, Camera, Lights, Object};
use super::sheets;
use super::strokes::{arrow, line, seen};
use super::workshop::{Shot, Workshop, number};
use crate::measure::shown;

/// A coarse grid as published: six directions, weighted by the angle.
const OPTIONS: &str = "--grid-spacing 0.935 --grid-basis axes6 --grid-lobe angle";

const CAMERA: Camera =
    Camera { position: [2.75, 2.35, -0.7], target: [4.12, 1.4, 2.33], vfov_deg: 36.0, size: [512, 400] };

/// The ball: the middle of its lowest point, and its size; its file's has a radius of 0.3 m.
const BALL: Object<'_> = Object { name: "ball", position: [4.28, 0.69, 2.65], scale: 1.4, yaw_deg: 0.0 };

/// Towards the fragment from the ball's middle.
const NORMAL: Vec3 = Vec3::new(-0.25, 0.62, -0.74);

/// The directions that a vertex measures.
const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Length of the longest arrow over the spacing.
const LONGEST: f32 = 0.62;

const MEASURED: [u8; 3] = [70, 210, 90];
const BETWEEN: [u8; 3] = [70, 130, 255];
const NORMAL_COLOR: [u8; 3] = [235, 50, 50];
const LIGHT_VECTOR: [u8; 3] = [255, 215, 60];

/// How bright the scene behind the arrows is.
const EXPOSURE: f32 = 1.2;

/// Makes figure 4.
pub(crate) fn draw(workshop: &Workshop) -> anyhow::Result<Values> {
    let file = workshop.bake("cornell_empty", OPTIONS)?;
    let text = setups::setup(&Lights::Emitters, &CAMERA, &[workshop.placed(&BALL)?]);
    let setup = workshop.draft("figure-4.json", &text)?;
    let flags = "--backend cpu --samples 64";
    let shot = Shot { name: "figure-4".into(), file: &file, setup: &setup, flags };
    let mut picture = ToneMap::of_ev(EXPOSURE).apply(&sheets::linear(&workshop.render(&shot)?)?);
    let grid = workshop.info(&file)?["grid"].take();
    let fragment = fragment();
    let mut places = corners(&grid, fragment)?;
    places.push(fragment);
    // Without the ball: what it hides of the light around it does not count on its own surface.
    let alone = workshop.draft("figure-4-alone.json", &setups::setup(&Lights::Emitters, &CAMERA, &[]))?;
    let light = irradiance(workshop, &file, &alone, &places)?;
    let longest = light.iter().flatten().copied().fold(0.0, f32::max);
    ensure!(longest > 0.0, "no light arrives at the vertices of figure 4");
    let spacing = number(&grid, "/spacing/0")? as f32;
    arrows(&mut picture, &places, &light, LONGEST * spacing / longest);
    let caption = "green: measured; blue: between the vertices; red: normal; yellow: light vector";
    sheets::write(
        &sheets::sheet(&[caption], vec![(String::new(), vec![picture])]),
        &workshop.image("figure-4.png"),
    )?;
    Ok(Values::new())
}

/// A point of the ball's surface.
fn fragment() -> Vec3 {
    let radius = 0.3 * BALL.scale;
    Vec3::from(BALL.position) + radius * (Vec3::Y + NORMAL.normalize())
}

/// The vertices of the cell that a point lies in, metres.
fn corners(grid: &Value, point: Vec3) -> anyhow::Result<Vec<Vec3>> {
    let vector = |name: &str| -> anyhow::Result<Vec3> {
        let of_axis = |axis: usize| number(grid, &format!("/{name}/{axis}"));
        Ok(Vec3::new(of_axis(0)? as f32, of_axis(1)? as f32, of_axis(2)? as f32))
    };
    let (origin, spacing) = (vector("origin")?, vector("spacing")?);
    let low = ((point - origin) / spacing).floor();
    let corner =
        |i: u32| origin + (low + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)) * spacing;
    Ok((0..8).map(corner).collect())
}

/// Luminance of the irradiance from each of the axes at places in free space.
fn irradiance(
    workshop: &Workshop,
    file: &std::path::Path,
    setup: &std::path::Path,
    places: &[Vec3],
) -> anyhow::Result<Vec<[f32; 6]>> {
    let points = workshop.draft("figure-4-points.csv", &table(places)?)?;
    let predictions = workshop.kept("figure-4-irradiance.csv");
    let [file, setup, points, out] = [file, setup, &points, &predictions].map(shown);
    let arguments =
        ["eval", &file, "--setup", &setup, "--points", &points, "--backend", "cpu", "--predictions", &out];
    workshop.run("figure-4_irradiance", &arguments.map(String::from), Some(&predictions))?;
    let text = std::fs::read_to_string(&predictions).with_context(|| format!("cannot read {out}"))?;
    let rows = luminances(&text).with_context(|| format!("{out} holds no predictions"))?;
    ensure!(rows.len() == AXES.len() * places.len() + 1, "{out} does not answer for each point");
    Ok(rows[1..].as_chunks().0.to_vec())
}

/// What a table of reference points has behind positions and normals, three columns each.
const COLORS: [&str; 9] =
    ["albedo", "E_delta", "E_area", "E_sky", "E_direct", "E_indirect", "se_area", "se_sky", "se_indirect"];

/// A point of the floor, without which `eval` has nothing to compare.
const FLOOR: Vec3 = Vec3::new(2.78, 0.0, 2.8);

/// A point of the floor, then points in free space, each with the six axes as normals, as `eval` reads them; there is no
/// reference.
fn table(places: &[Vec3]) -> anyhow::Result<String> {
    let mut text = String::from("kind");
    for name in ["position", "normal"] {
        write!(text, ",{name}_x,{name}_y,{name}_z")?;
    }
    for name in COLORS {
        write!(text, ",{name}_r,{name}_g,{name}_b")?;
    }
    let floor = std::iter::once((0, FLOOR, Vec3::Y));
    let in_air = places.iter().flat_map(|place| AXES.map(|axis| (1, *place, axis)));
    for (kind, position, normal) in floor.chain(in_air) {
        write!(text, "\n{kind}")?;
        for number in [position, normal].iter().flat_map(|vector| vector.to_array()) {
            write!(text, ",{number}")?;
        }
        text += &",1".repeat(3 * COLORS.len());
    }
    Ok(text + "\n")
}

/// The luminance of each row of predictions; dark where there is no answer.
fn luminances(text: &str) -> Option<Vec<f32>> {
    let of_line = |line: &str| {
        let channels: Vec<f32> =
            line.split(',').map(|value| value.trim().parse().ok()).collect::<Option<_>>()?;
        let color = Vec3::from_slice(channels.get(..3)?);
        Some(if color.is_finite() { luminance(color) } else { 0.0 })
    };
    text.lines().skip(1).map(of_line).collect()
}

/// Draws the vertices' arrows and, at the last place, those of the fragment.
fn arrows(picture: &mut DisplayImage, places: &[Vec3], light: &[[f32; 6]], scale: f32) {
    let Some((fragment, vertices)) = places.split_last() else { return };
    let Some((between, measured)) = light.split_last() else { return };
    let ends = |from: Vec3, way: Vec3| Some([seen(&CAMERA, from)?, seen(&CAMERA, from + way)?]);
    let mut draw = |from: Vec3, way: Vec3, width: f32, color| {
        if let Some(ends) = ends(from, way) {
            arrow(picture, ends, width, color);
        }
    };
    for (vertex, light) in vertices.iter().zip(measured) {
        AXES.iter().zip(light).for_each(|(axis, light)| draw(*vertex, scale * light * *axis, 2.0, MEASURED));
    }
    AXES.iter().zip(between).for_each(|(axis, light)| draw(*fragment, scale * light * *axis, 2.0, BETWEEN));
    draw(*fragment, light_vector(between) * scale, 3.0, LIGHT_VECTOR);
    draw(*fragment, NORMAL.normalize() * 0.5, 3.0, NORMAL_COLOR);
    let mut dot = |place: Vec3, width: f32, color| {
        if let Some(at) = seen(&CAMERA, place) {
            line(picture, [at, at + Vec2::splat(1e-3)], width, color);
        }
    };
    vertices.iter().for_each(|vertex| dot(*vertex, 8.0, MEASURED));
    dot(*fragment, 9.0, [0; 3]);
}

/// The directions that the normal lets count, with their light: \[SED\] figure 4.
fn light_vector(light: &[f32; 6]) -> Vec3 {
    let normal = NORMAL.normalize();
    AXES.iter().zip(light).map(|(axis, light)| *axis * (normal.dot(*axis).max(0.0) * light)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_point_lies_between_its_cells_corners() {
        let grid = json!({ "origin": [1.0, 0.0, 0.0], "spacing": [1.0, 2.0, 0.5] });
        let corners = corners(&grid, Vec3::new(2.5, 1.0, 0.6)).unwrap();
        assert_eq!((corners[0], corners[7]), (Vec3::new(2.0, 0.0, 0.5), Vec3::new(3.0, 2.0, 1.0)));
        assert!(super::corners(&json!({}), Vec3::ZERO).is_err());
    }

    #[test]
    fn predictions_without_an_answer_are_dark() {
        assert_eq!(luminances("E_r,E_g,E_b\n1,1,1\nNaN,NaN,NaN\n").unwrap(), [1.0, 0.0]);
        assert_eq!(luminances("E_r\n1\n"), None);
        let table = table(&[Vec3::ONE]).unwrap();
        let columns: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(columns, [34; 8]);
    }

    #[test]
    fn the_light_vector_leaves_out_what_lies_behind() {
        let vector = light_vector(&[1.0, 0.0, 0.0, 5.0, 1.0, 1.0]);
        assert!(vector.x == 0.0 && vector.y == 0.0 && vector.z < 0.0, "{vector}");
    }
}
