//! What is at the picked place.

use eframe::egui::{Grid, ScrollArea, Ui};
use probelight_math::glam::Vec3;
use probelight_trace::PointIrradiance;

use super::{Actions, row};
use crate::scene::pick::{Picked, PickedSurface};
use crate::state::document::Selection;
use crate::state::{Action, State};

/// What is known of the picked place.
#[derive(Clone, Debug)]
pub struct PickedLight {
    /// What it is.
    pub picked: Picked,
    /// Irradiance of the lights there, W/m², one for each, in the document's order.
    pub direct: Vec<Vec3>,
    /// Irradiance of the lightmap there, W/m².
    pub lightmap: Option<Vec3>,
    /// The path tracer's.
    pub reference: Option<PointIrradiance>,
    /// Whether that is being computed.
    pub is_tracing: bool,
}

/// Shows it.
pub fn show(ui: &mut Ui, state: &State, light: Option<&PickedLight>, actions: &mut Actions) {
    let Some(light) = light else {
        ui.label("Click into the picture to see what is there.");
        return;
    };
    match &light.picked {
        Picked::Nothing => _ = ui.label("the sky"),
        Picked::Object(item, _) => {
            let name = state.document.object(*item).map(crate::state::ObjectEntry::name);
            ui.label(format!("object: {}", name.unwrap_or_default()));
        }
        Picked::Surface(surface) => {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                self::surface(ui, surface, actions);
                irradiance(ui, state, light);
                serving(ui, surface);
            });
        }
    }
}

fn surface(ui: &mut Ui, surface: &PickedSurface, actions: &mut Actions) {
    Grid::new("surface").num_columns(2).show(ui, |ui| {
        row(ui, "node", if surface.node.is_empty() { "(no name)" } else { &surface.node });
        ui.label("material");
        if ui.link(&surface.material_name).on_hover_text("show it").clicked() {
            actions.push(Action::Select(Selection::Material(surface.material)));
        }
        ui.end_row();
        row(ui, "triangle", surface.triangle.to_string());
        row(ui, "position", numbers(surface.position));
        row(ui, "normal", numbers(surface.normal));
    });
}

fn irradiance(ui: &mut Ui, state: &State, light: &PickedLight) {
    ui.separator();
    ui.strong("irradiance, W/m²");
    let direct: Vec3 = light.direct.iter().sum();
    Grid::new("irradiance").num_columns(3).striped(true).show(ui, |ui| {
        for (entry, irradiance) in state.document.lights.iter().zip(&light.direct) {
            if *irradiance != Vec3::ZERO {
                row(ui, &entry.name, numbers(*irradiance));
            }
        }
        row(ui, "all lights", numbers(direct));
        if let Some(lightmap) = light.lightmap {
            row(ui, "lightmap", numbers(lightmap)).on_hover_text("bounced light, the sky, emissive surfaces");
            row(ui, "in all", numbers(direct + lightmap));
        }
    });
    match &light.reference {
        Some(reference) => {
            let soft = reference.area + reference.sky + reference.indirect;
            ui.strong("by the path tracer");
            Grid::new("traced").num_columns(2).striped(true).show(ui, |ui| {
                row(ui, "bounced", numbers(reference.indirect));
                row(ui, "sky", numbers(reference.sky));
                row(ui, "emissive", numbers(reference.area));
                row(ui, "in the lightmap", numbers(soft));
                if let Some(lightmap) = light.lightmap {
                    let error = (lightmap.element_sum() / soft.element_sum().max(1e-9) - 1.0) * 100.0;
                    let noise = (reference.se_area + reference.se_sky + reference.se_indirect).element_sum()
                        / soft.element_sum().max(1e-9)
                        * 100.0;
                    row(ui, "ours differs by", format!("{error:+.1} %, noise {noise:.1} %"));
                }
            });
        }
        None if light.is_tracing => _ = ui.small("the path tracer is at work…"),
        None => {}
    }
}

fn serving(ui: &mut Ui, surface: &PickedSurface) {
    ui.separator();
    let Some(texel) = &surface.light else {
        ui.label("This side has no light of its own: nothing sees it.");
        return;
    };
    Grid::new("serving").num_columns(2).show(ui, |ui| {
        row(ui, "texel", format!("{}, {}", texel.texel[0], texel.texel[1]));
        let Some(receiver) = &texel.receiver else { return };
        row(ui, "receiver", receiver.receiver.to_string());
        row(ui, "cluster", format!("{} ({} receivers)", receiver.cluster, receiver.receivers));
        row(ui, "singular values", format!("{} of {} columns", receiver.rank, receiver.columns));
        row(ui, "error", format!("{:.2} × the wanted one", receiver.error));
        row(ui, "probes", receiver.probes.len().to_string());
    });
}

fn numbers(v: Vec3) -> String {
    format!("{:.4}  {:.4}  {:.4}", v.x, v.y, v.z)
}
