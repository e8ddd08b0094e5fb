//! What is in the scene: lights, sky, objects, materials, cameras; and properties of what is selected.

use std::sync::Arc;

use eframe::egui::{Button, CollapsingHeader, ComboBox, DragValue, Grid, ScrollArea, Slider, Ui};
use probelight_math::glam::{EulerRot, Quat, Vec3};
use probelight_scene::{Light, Placement, Scene, Sky};

use super::{Actions, color_and_strength, light, strength, vector};
use crate::scene::live_scene::Models;
use crate::state::document::{Item, ObjectEntry, Selection};
use crate::state::{Action, Edit, Request, State};

/// Shows all of it.
pub fn show(ui: &mut Ui, state: &State, scene: &Arc<Scene>, models: &Models, actions: &mut Actions) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        section(ui, "Lights", |ui| lights(ui, state, actions));
        section(ui, "Sky and emission", |ui| sky(ui, state, actions));
        section(ui, "Objects", |ui| objects(ui, state, models, actions));
        CollapsingHeader::new("Materials").show(ui, |ui| materials(ui, state, scene, actions));
        section(ui, "Cameras", |ui| cameras(ui, state, actions));
    });
}

fn section(ui: &mut Ui, title: &str, show: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(title).default_open(true).show(ui, show);
}

fn lights(ui: &mut Ui, state: &State, actions: &mut Actions) {
    ui.horizontal(|ui| {
        if ui.button("+ lamp").clicked() {
            actions.push(Action::AddLamp);
        }
        if ui.button("+ spot").clicked() {
            actions.push(Action::Edit(Edit::AddLight(new_spot(state))));
        }
        if ui.button("+ sun").clicked() {
            let direction = Vec3::new(0.4, -0.8, -0.45).normalize();
            let irradiance = Vec3::splat(3.0 * (-state.shown_ev).exp2());
            actions.push(Action::Edit(Edit::AddLight(Light::Directional { direction, irradiance })));
        }
    });
    let mut muted = state.view.muted.clone();
    for entry in &state.document.lights {
        let is_selected = state.selection == Selection::Light(entry.item);
        ui.horizontal(|ui| {
            let mut shines = !muted.lights.contains(&entry.item);
            if ui.checkbox(&mut shines, "").on_hover_text("lights the scene; the setup keeps it").changed() {
                if shines {
                    muted.lights.remove(&entry.item)
                } else {
                    muted.lights.insert(entry.item)
                };
            }
            if ui.selectable_label(is_selected, &entry.name).clicked() {
                actions.push(Action::Select(Selection::Light(entry.item)));
            }
        });
        if is_selected {
            ui.indent("light", |ui| {
                light::show(ui, entry, state.view.time, state.diagonal, actions);
                copy_and_remove(ui, actions);
            });
        }
    }
    if muted != state.view.muted {
        let mut view = state.view.clone();
        view.muted = muted;
        actions.push(Action::View(Box::new(view)));
    }
}

fn new_spot(state: &State) -> Light {
    let camera = &state.view.camera;
    let direction = (camera.target - camera.position).normalize_or(Vec3::NEG_Z);
    let brightness = 8.0 * (0.1 * state.diagonal).powi(2) * (-state.shown_ev).exp2();
    Light::Spot {
        position: camera.position + direction * 0.02 * state.diagonal,
        direction,
        intensity: Vec3::splat(brightness),
        inner_angle: 0.25,
        outer_angle: 0.4,
        range: None,
    }
}

fn copy_and_remove(ui: &mut Ui, actions: &mut Actions) {
    ui.horizontal(|ui| {
        if ui.button("look at").clicked() {
            actions.push(Action::FocusSelected);
        }
        if ui.button("copy").clicked() {
            actions.push(Action::CopySelected);
        }
        if ui.button("remove").clicked() {
            actions.push(Action::RemoveSelected);
        }
    });
}

fn sky(ui: &mut Ui, state: &State, actions: &mut Actions) {
    let mut sky = state.document.sky;
    let mut is_gradient = matches!(sky, Sky::Gradient { .. });
    ui.horizontal(|ui| {
        ui.label("sky");
        ComboBox::from_id_salt("sky").selected_text(if is_gradient { "gradient" } else { "even" }).show_ui(
            ui,
            |ui| {
                ui.selectable_value(&mut is_gradient, false, "even");
                ui.selectable_value(&mut is_gradient, true, "gradient");
            },
        );
    });
    sky = match (sky, is_gradient) {
        (Sky::Uniform(radiance), true) => {
            Sky::Gradient { zenith: radiance, horizon: radiance, ground: radiance * 0.3 }
        }
        (Sky::Gradient { horizon, .. }, false) => Sky::Uniform(horizon),
        (sky, _) => sky,
    };
    Grid::new("sky").num_columns(2).show(ui, |ui| {
        let unit = "W/m²/sr";
        let mut color = |name: &str, color: &mut Vec3| {
            ui.label(name);
            color_and_strength(ui, color, unit);
            ui.end_row();
        };
        match &mut sky {
            Sky::Uniform(radiance) => color("radiance", radiance),
            Sky::Gradient { zenith, horizon, ground } => {
                color("zenith", zenith);
                color("horizon", horizon);
                color("ground", ground);
            }
        }
    });
    if sky != state.document.sky {
        actions.push(Action::Edit(Edit::SetSky(sky)));
    }
    let mut scale = state.document.emissive_scale;
    ui.horizontal(|ui| {
        ui.label("emission times");
        ui.add(strength(&mut scale));
    });
    if scale != state.document.emissive_scale {
        actions.push(Action::Edit(Edit::SetEmissiveScale(scale)));
    }
}

fn objects(ui: &mut Ui, state: &State, models: &Models, actions: &mut Actions) {
    ui.horizontal(|ui| {
        if ui.button("+ ball").clicked() {
            actions.push(Action::Request(Request::AddBall));
        }
        if ui.button("+ file…").clicked() {
            actions.push(Action::Request(Request::ChooseObject));
        }
    });
    for entry in &state.document.objects {
        let is_selected = state.selection == Selection::Object(entry.item);
        if ui.selectable_label(is_selected, entry.name()).clicked() {
            actions.push(Action::Select(Selection::Object(entry.item)));
        }
        if is_selected {
            ui.indent("object", |ui| {
                object(ui, state, entry, models, actions);
                copy_and_remove(ui, actions);
            });
        }
    }
}

fn object(ui: &mut Ui, state: &State, entry: &ObjectEntry, models: &Models, actions: &mut Actions) {
    let before = entry.placement(0.0);
    let mut placement = before;
    let (yaw, _, _) = placement.rotation.to_euler(EulerRot::YXZ);
    let mut degrees = yaw.to_degrees();
    Grid::new("object").num_columns(2).show(ui, |ui| {
        ui.label("position");
        vector(ui, &mut placement.translation, 1e-3 * state.diagonal);
        ui.end_row();
        ui.label("turn");
        if ui.add(Slider::new(&mut degrees, -180.0..=180.0).suffix("°")).changed() {
            placement.rotation = Quat::from_rotation_y(degrees.to_radians());
        }
        ui.end_row();
        ui.label("size");
        ui.add(DragValue::new(&mut placement.scale).speed(0.01).range(1e-3..=1e3));
        ui.end_row();
        ui.label("light");
        let mut is_door = entry.path.is_door;
        if ui.checkbox(&mut is_door, "a door: opens and shuts ways for it").changed() {
            actions.push(Action::Edit(Edit::SetDoor(entry.item, is_door)));
        }
        ui.end_row();
        clip(ui, entry, models, actions);
    });
    if placement != before {
        actions.push(Action::Edit(Edit::PlaceObject(entry.item, placement)));
    }
    keyframes(ui, state, entry.item, entry, placement, actions);
}

fn clip(ui: &mut Ui, entry: &ObjectEntry, models: &Models, actions: &mut Actions) {
    let Some(model) = models.get(&entry.path.file).filter(|model| model.clips().len() > 0) else { return };
    ui.label("clip");
    let present = entry.path.clip.clone();
    let name = present.clone().unwrap_or_else(|| "none".into());
    ComboBox::from_id_salt("clip").selected_text(name).show_ui(ui, |ui| {
        let choices = std::iter::once(None).chain(model.clips().map(|clip| Some(clip.to_owned())));
        for choice in choices {
            let name = choice.clone().unwrap_or_else(|| "none".into());
            if ui.selectable_label(choice == present, name).clicked() {
                actions.push(Action::Edit(Edit::SetClip(entry.item, choice)));
            }
        }
    });
    ui.end_row();
}

fn keyframes(
    ui: &mut Ui,
    state: &State,
    item: Item,
    entry: &ObjectEntry,
    placement: Placement,
    actions: &mut Actions,
) {
    ui.horizontal(|ui| {
        ui.label(format!("{} keyframes", entry.path.keyframes.len()));
        if ui.button("keep its place at this time").clicked() {
            actions.push(Action::Edit(Edit::AddObjectKey(item, state.view.time, placement)));
        }
        let has_path = entry.path.keyframes.len() > 1;
        if ui.add_enabled(has_path, Button::new("stop")).clicked() {
            actions.push(Action::Edit(Edit::ClearObjectKeys(item)));
        }
    });
}

fn materials(ui: &mut Ui, state: &State, scene: &Scene, actions: &mut Actions) {
    for (number, (material, colors)) in scene.materials.iter().zip(&state.document.materials).enumerate() {
        let name =
            if material.name.is_empty() { format!("material {number}") } else { material.name.clone() };
        let is_selected = state.selection == Selection::Material(number);
        let mut changed = *colors;
        ui.horizontal(|ui| {
            let mut rgb = colors.base_color.to_array();
            if ui.color_edit_button_rgb(&mut rgb).changed() {
                changed.base_color = Vec3::from(rgb);
            }
            if ui.selectable_label(is_selected, name).clicked() {
                actions.push(Action::Select(Selection::Material(number)));
            }
        });
        if is_selected {
            ui.indent("material", |ui| {
                ui.horizontal(|ui| {
                    ui.label("emits");
                    color_and_strength(ui, &mut changed.emission, "W/m²/sr");
                });
                if !scene.materials[number].emission.max_element().is_normal()
                    && changed.emission != Vec3::ZERO
                {
                    ui.small("It did not emit when it was baked: its light is less accurate.");
                }
            });
        }
        if changed != *colors {
            actions.push(Action::Edit(Edit::SetMaterial(number, changed)));
        }
    }
}

fn cameras(ui: &mut Ui, state: &State, actions: &mut Actions) {
    for (number, camera) in state.document.cameras.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button(&camera.name).on_hover_text("look from there").clicked() {
                actions.push(Action::LookFrom(number));
            }
            if ui.small_button("✖").on_hover_text("remove").clicked() {
                actions.push(Action::Edit(Edit::RemoveCamera(number)));
            }
        });
    }
    ui.horizontal(|ui| {
        if ui.button("keep this view").clicked() {
            actions.push(Action::KeepCamera);
        }
        if ui.button("copy as JSON").clicked() {
            let json = state.view.camera.to_setup_json();
            actions.push(Action::Request(Request::CopyText(json)));
        }
    });
    let mut view = state.view.clone();
    ui.horizontal(|ui| {
        ui.label("speed");
        ui.add(Slider::new(&mut view.speed, 0.05..=20.0).logarithmic(true));
    });
    let mut degrees = view.camera.vertical_fov.to_degrees();
    ui.horizontal(|ui| {
        ui.label("field of view");
        if ui.add(Slider::new(&mut degrees, 10.0..=120.0).suffix("°")).changed() {
            view.camera.vertical_fov = degrees.to_radians();
        }
    });
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
}
