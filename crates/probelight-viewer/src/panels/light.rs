//! Properties of a light.

use std::f32::consts::PI;

use eframe::egui::{ComboBox, DragValue, Grid, Slider, Ui};
use probelight_math::color::blackbody;
use probelight_math::glam::Vec3;
use probelight_scene::{Light, LightMotion, sun_at};

use super::{Actions, color_and_strength, vector};
use crate::state::document::LightEntry;
use crate::state::{Action, Edit};

/// A temperature that is chosen is remembered while the panel is open; colours do not tell theirs.
const FIRST_TEMPERATURE: f32 = 4000.0;

/// Shows a light.
pub fn show(ui: &mut Ui, entry: &LightEntry, time: f32, diagonal: f32, actions: &mut Actions) {
    let mut light = entry.light.clone();
    let mut changed = false;
    let mut name = entry.name.clone();
    if ui.text_edit_singleline(&mut name).changed() {
        actions.push(Action::Edit(Edit::NameLight(entry.item, name)));
    }
    Grid::new("light").num_columns(2).show(ui, |ui| {
        changed |= kind(ui, &mut light, diagonal);
        changed |= brightness(ui, &mut light);
        changed |= place(ui, &mut light, diagonal);
        changed |= shape(ui, &mut light, diagonal);
    });
    if changed && light.validate().is_ok() {
        actions.push(Action::Edit(Edit::SetLight(entry.item, light)));
    }
    motion(ui, entry, time, diagonal, actions);
}

fn kind(ui: &mut Ui, light: &mut Light, diagonal: f32) -> bool {
    let mut kind = match light {
        Light::Point { .. } => 0,
        Light::Spot { .. } => 1,
        Light::Directional { .. } => 2,
    };
    let before = kind;
    ui.label("kind");
    let names = ["lamp", "spot", "sun"];
    ComboBox::from_id_salt("kind of light").selected_text(names[kind]).show_ui(ui, |ui| {
        for (number, name) in names.into_iter().enumerate() {
            ui.selectable_value(&mut kind, number, name);
        }
    });
    ui.end_row();
    if kind != before {
        *light = converted(light, kind, diagonal);
    }
    kind != before
}

/// A light of another kind that looks alike where it can. A sun is about as bright as a lamp a quarter of the scene away.
fn converted(light: &Light, kind: usize, diagonal: f32) -> Light {
    let far = (0.25 * diagonal).powi(2).max(f32::MIN_POSITIVE);
    let (position, direction, intensity, range) = match light.clone() {
        Light::Point { position, intensity, range } => (position, Vec3::NEG_Y, intensity, range),
        Light::Spot { position, direction, intensity, range, .. } => (position, direction, intensity, range),
        Light::Directional { direction, irradiance } => (Vec3::ZERO, direction, irradiance * far, None),
    };
    match kind {
        0 => Light::Point { position, intensity, range },
        1 => Light::Spot { position, direction, intensity, inner_angle: 0.35, outer_angle: 0.5, range },
        _ => Light::Directional { direction, irradiance: intensity / far },
    }
}

fn brightness(ui: &mut Ui, light: &mut Light) -> bool {
    let unit = if matches!(light, Light::Directional { .. }) { "W/m²" } else { "W/sr" };
    ui.label("brightness");
    let mut changed = color_and_strength(ui, light.strength_mut(), unit);
    ui.end_row();

    ui.label("temperature");
    let id = ui.id().with("temperature");
    let mut kelvins = ui.data(|data| data.get_temp(id)).unwrap_or(FIRST_TEMPERATURE);
    if ui.add(Slider::new(&mut kelvins, 1700.0..=12_000.0).logarithmic(true).suffix(" K")).changed() {
        ui.data_mut(|data| data.insert_temp(id, kelvins));
        let strength = light.strength_mut();
        *strength = blackbody(kelvins) * strength.max_element();
        changed = true;
    }
    ui.end_row();

    if let Some(watts) = power(light) {
        ui.label("power in all");
        ui.label(format!("{watts:.4} W"));
        ui.end_row();
    }
    changed
}

/// What a lamp sends out in all directions, by its largest channel; W.
fn power(light: &Light) -> Option<f32> {
    match light {
        Light::Point { intensity, .. } => Some(4.0 * PI * intensity.max_element()),
        Light::Spot { intensity, inner_angle, outer_angle, .. } => {
            // Full within the inner cone; between the cones the square of what falls evenly with the cosine.
            let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
            Some(2.0 * PI * intensity.max_element() * ((1.0 - inner) + (inner - outer) / 3.0))
        }
        Light::Directional { .. } => None,
    }
}

fn place(ui: &mut Ui, light: &mut Light, diagonal: f32) -> bool {
    let mut changed = false;
    if let Light::Point { position, .. } | Light::Spot { position, .. } = light {
        ui.label("position");
        changed |= vector(ui, position, 1e-3 * diagonal);
        ui.end_row();
    }
    let is_sun = matches!(light, Light::Directional { .. });
    if let Light::Spot { direction, .. } | Light::Directional { direction, .. } = light {
        changed |= angles(ui, direction, is_sun);
    }
    changed
}

/// A direction by where it comes from (of a sun) or goes to (of a spot): turn about the vertical from +Z, and height.
fn angles(ui: &mut Ui, direction: &mut Vec3, is_sun: bool) -> bool {
    let towards = if is_sun { -*direction } else { *direction };
    let mut azimuth = towards.x.atan2(towards.z).to_degrees();
    let mut height = towards.y.clamp(-1.0, 1.0).asin().to_degrees();
    ui.label("azimuth");
    let mut changed = ui.add(Slider::new(&mut azimuth, -180.0..=180.0).suffix("°")).changed();
    ui.end_row();
    ui.label("height");
    changed |= ui.add(Slider::new(&mut height, -89.9..=89.9).suffix("°")).changed();
    ui.end_row();
    if changed {
        let (sin, cos) = height.to_radians().sin_cos();
        let (x, z) = azimuth.to_radians().sin_cos();
        let towards = Vec3::new(x * cos, sin, z * cos);
        *direction = if is_sun { -towards } else { towards }.normalize();
    }
    if is_sun {
        ui.label("time of day");
        let id = ui.id().with("hour");
        let mut hour = ui.data(|data| data.get_temp(id)).unwrap_or(12.0f32);
        if ui.add(Slider::new(&mut hour, 0.0..=24.0).suffix(" h")).changed() {
            ui.data_mut(|data| data.insert_temp(id, hour));
            *direction = -sun_at(hour).0;
            changed = true;
        }
        ui.end_row();
    }
    changed
}

fn shape(ui: &mut Ui, light: &mut Light, diagonal: f32) -> bool {
    let mut changed = false;
    if let Light::Spot { inner_angle, outer_angle, .. } = light {
        let mut degrees = [inner_angle.to_degrees(), outer_angle.to_degrees()];
        ui.label("outer cone");
        changed |= ui.add(Slider::new(&mut degrees[1], 0.5..=90.0).suffix("°")).changed();
        ui.end_row();
        ui.label("inner cone");
        changed |= ui.add(Slider::new(&mut degrees[0], 0.0..=90.0).suffix("°")).changed();
        ui.end_row();
        if changed {
            *outer_angle = degrees[1].to_radians();
            *inner_angle = degrees[0].to_radians().min(*outer_angle);
        }
    }
    if let Light::Point { range, .. } | Light::Spot { range, .. } = light {
        ui.label("range");
        ui.horizontal(|ui| {
            let mut ends = range.is_some();
            if ui.checkbox(&mut ends, "ends").changed() {
                *range = ends.then_some(0.5 * diagonal);
                changed = true;
            }
            if let Some(range) = range {
                let drag = DragValue::new(range).speed(1e-3 * diagonal).range(1e-3..=1e6).suffix(" m");
                changed |= ui.add(drag).changed();
            }
        });
        ui.end_row();
    }
    changed
}

fn motion(ui: &mut Ui, entry: &LightEntry, time: f32, diagonal: f32, actions: &mut Actions) {
    let mut motion = entry.motion.clone();
    let circle = LightMotion::Circle { radius: 0.05 * diagonal, period: 12.0 };
    let mut choices = vec![("stands still", LightMotion::Still), ("circles", circle)];
    if matches!(entry.light, Light::Directional { .. }) {
        choices.push(("day and night", LightMotion::Day { period: 40.0 }));
    }
    choices.push(("flickers", LightMotion::Flicker { strength: 0.4 }));
    choices.push(("keyframes", LightMotion::Keyframes(vec![(0.0, entry.light.clone())])));
    let is_same = |a: &LightMotion, b: &LightMotion| std::mem::discriminant(a) == std::mem::discriminant(b);
    let name = choices.iter().find(|(_, choice)| is_same(choice, &motion)).map_or("", |(name, _)| name);
    ui.horizontal(|ui| {
        ui.label("motion");
        ComboBox::from_id_salt("motion").selected_text(name).show_ui(ui, |ui| {
            for (name, choice) in choices {
                if ui.selectable_label(is_same(&choice, &motion), name).clicked() {
                    motion = choice;
                }
            }
        });
    });
    Grid::new("motion").num_columns(2).show(ui, |ui| match &mut motion {
        LightMotion::Still => {}
        LightMotion::Circle { radius, period } => {
            ui.label("radius");
            ui.add(DragValue::new(radius).speed(1e-3 * diagonal).range(0.0..=1e5).suffix(" m"));
            ui.end_row();
            seconds(ui, "one turn", period);
        }
        LightMotion::Day { period } => seconds(ui, "one day", period),
        LightMotion::Flicker { strength } => {
            ui.label("strength");
            ui.add(Slider::new(strength, 0.0..=1.0));
            ui.end_row();
        }
        LightMotion::Keyframes(keys) => {
            ui.label(format!("{} keyframes", keys.len()));
            if ui.button("keep the light at this time").clicked() {
                keys.retain(|(key, _)| *key != time);
                let next = keys.partition_point(|(key, _)| *key < time);
                keys.insert(next, (time, entry.light.clone()));
            }
            ui.end_row();
        }
    });
    if motion != entry.motion {
        actions.push(Action::Edit(Edit::SetMotion(entry.item, motion)));
    }
}

fn seconds(ui: &mut Ui, name: &str, period: &mut f32) {
    ui.label(name);
    ui.add(DragValue::new(period).speed(0.1).range(0.5..=3600.0).suffix(" s"));
    ui.end_row();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_is_the_integral_of_the_intensity() {
        let (inner_angle, outer_angle) = (0.3f32, 0.6f32);
        let spot = Light::Spot {
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            intensity: Vec3::splat(2.0),
            inner_angle,
            outer_angle,
            range: None,
        };
        let steps = 20_000;
        let sum: f64 = (0..steps)
            .map(|step| {
                let angle = (step as f32 + 0.5) / steps as f32 * PI;
                let at = Vec3::new(angle.sin(), -angle.cos(), 0.0);
                let arriving = spot.illuminate(at).map_or(0.0, |light| light.irradiance.x);
                f64::from(arriving * 2.0 * PI * angle.sin() * PI / steps as f32)
            })
            .sum();
        assert!((f64::from(power(&spot).unwrap()) / sum - 1.0).abs() < 1e-3, "{sum}");
        let lamp = converted(&spot, 0, 10.0);
        assert!((power(&lamp).unwrap() - 8.0 * PI).abs() < 1e-4);
    }

    #[test]
    fn kinds_become_each_other_without_a_leap() {
        let lamp = Light::Point { position: Vec3::ONE, intensity: Vec3::splat(3.0), range: Some(4.0) };
        for kind in 0..3 {
            assert_eq!(converted(&lamp, kind, 20.0).validate(), Ok(()));
        }
        let sun = converted(&lamp, 2, 20.0);
        let Light::Point { intensity, .. } = converted(&sun, 0, 20.0) else { unreachable!() };
        assert!(intensity.abs_diff_eq(Vec3::splat(3.0), 1e-5));
    }
}
