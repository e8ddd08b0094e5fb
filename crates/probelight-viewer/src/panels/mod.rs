//! What lies around the picture. Panels only show a state and say what is asked for.
//!
//! | module | job |
//! | --- | --- |
//! | [`menu`] | the bar above |
//! | [`scene`] | lights, objects, materials, cameras |
//! | [`light`] | properties of a light |
//! | [`look`] | what is shown, and how |
//! | [`detail`] | levels of detail |
//! | [`bake`] | baking, and what was baked |
//! | [`picked`] | what is at a place |
//! | [`timing`] | how long frames take |
//! | [`lightmap`] | the lightmap as a picture |
//! | [`help`] | keys |

use eframe::egui::emath::Numeric;
use eframe::egui::{DragValue, Response, Ui};
use probelight_math::glam::Vec3;

use crate::state::Action;

pub mod bake;
pub mod detail;
pub mod help;
pub mod light;
pub mod lightmap;
pub mod look;
pub mod menu;
pub mod picked;
pub mod scene;
pub mod timing;

/// What panels ask for.
pub type Actions = Vec<Action>;

/// Three numbers in a row. Returns whether one changed.
fn vector(ui: &mut Ui, vector: &mut Vec3, speed: f32) -> bool {
    ui.horizontal(|ui| {
        let mut changed = false;
        for (axis, value) in ["x ", "y ", "z "].into_iter().zip(vector.as_mut()) {
            changed |= ui.add(DragValue::new(value).speed(speed).max_decimals(3).prefix(axis)).changed();
        }
        changed
    })
    .inner
}

/// A number that is not negative, changed by shares of itself.
fn strength(value: &mut f32) -> DragValue<'_> {
    let speed = f64::from(value.abs().max(1e-3)) * 0.01;
    DragValue::new(value).speed(speed).range(0.0..=1e9).max_decimals(4)
}

/// A colour and its brightness: the largest channel. Returns whether one changed.
fn color_and_strength(ui: &mut Ui, color: &mut Vec3, unit: &str) -> bool {
    let mut brightness = color.max_element();
    let hue = if brightness > 0.0 { *color / brightness } else { Vec3::ONE };
    let mut rgb = hue.to_array();
    let changed = ui
        .horizontal(|ui| {
            let hue_changed = ui.color_edit_button_rgb(&mut rgb).changed();
            let changed = ui.add(strength(&mut brightness).suffix(format!(" {unit}"))).changed();
            hue_changed || changed
        })
        .inner;
    if changed {
        let rgb = Vec3::from(rgb);
        *color = rgb / rgb.max_element().max(1e-6) * brightness.max(0.0);
    }
    changed
}

/// A number that may be absent: what stands in its place then. Returns its name's box.
fn optional<T: Numeric>(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<T>,
    first: T,
    absent: &str,
    drag: impl Fn(DragValue<'_>) -> DragValue<'_>,
) -> Response {
    let mut is_some = value.is_some();
    let name = ui.checkbox(&mut is_some, name);
    if name.changed() {
        *value = is_some.then_some(first);
    }
    match value {
        Some(value) => _ = ui.add(drag(DragValue::new(value))),
        None => _ = ui.label(absent),
    }
    name
}

/// A line of text and its value.
fn row(ui: &mut Ui, name: &str, value: impl Into<String>) -> Response {
    ui.label(name);
    let response = ui.label(value.into());
    ui.end_row();
    response
}
