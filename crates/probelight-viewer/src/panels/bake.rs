//! Baking, and what was baked.

use eframe::egui::{Grid, ProgressBar, Ui};
use probelight_asset::BakedScene;

use super::{Actions, optional, row};
use crate::platform::QUALITIES;
use crate::scene::progress::Standing;
use crate::state::view_state::BakeNumbers;
use crate::state::{Action, Request, State};

/// Shows what was baked, and what could be.
pub fn show(
    ui: &mut Ui,
    state: &State,
    baked: &BakedScene,
    is_baked: bool,
    standing: Option<&Standing>,
    actions: &mut Actions,
) {
    match standing {
        Some(standing) => progress(ui, standing, actions),
        None if QUALITIES.is_empty() => _ = ui.label("scenes are baked by `probelight bake`"),
        None => {
            ui.label(if is_baked { "bake this scene again" } else { "this scene is not baked" });
            ui.horizontal(|ui| {
                for (quality, name, hint) in QUALITIES {
                    if ui.button(*name).on_hover_text(*hint).clicked() {
                        actions.push(Action::Request(Request::Bake(*quality)));
                    }
                }
            });
            numbers(ui, state, baked, actions);
        }
    }
    ui.separator();
    if is_baked {
        figures(ui, baked);
        if !QUALITIES.is_empty() && ui.button("save the bake…").clicked() {
            actions.push(Action::Request(Request::SaveBake));
        }
    } else {
        ui.label("Until it is, there is direct light only.");
    }
}

/// What is wanted otherwise than the quality has it, beginning with what the present bake has.
fn numbers(ui: &mut Ui, state: &State, baked: &BakedScene, actions: &mut Actions) {
    let mut view = state.view.clone();
    let BakeNumbers { receivers, gather_rays, error_percent, surfel_size, grid_vertices } =
        &mut view.bake_numbers;
    let (settings, absent) = (&baked.settings, "as the quality has it");
    let receivers_now = baked.receiver_texels.len().max(1000) as u32;
    let vertices_now = baked.grid_vertices.len() as u32;
    let surfel_now = if settings.surfel_size > 0.0 { settings.surfel_size } else { 0.02 * state.diagonal };
    Grid::new("numbers").num_columns(2).show(ui, |ui| {
        optional(ui, "receivers", receivers, receivers_now, absent, |drag| {
            drag.speed(200.0).range(100..=10_000_000)
        })
        .on_hover_text("texels with light of their own");
        ui.end_row();
        optional(ui, "rays", gather_rays, settings.gather_rays.max(64), absent, |drag| {
            drag.speed(2.0).range(1..=65_536)
        })
        .on_hover_text("for each receiver: more of them, less noise, longer bakes");
        ui.end_row();
        optional(ui, "error", error_percent, 3.0, absent, |drag| {
            drag.speed(0.05).range(0.1..=50.0).suffix(" %")
        })
        .on_hover_text("that compression may make: less of it, larger files");
        ui.end_row();
        optional(ui, "surfels", surfel_size, surfel_now, absent, |drag| {
            drag.speed(0.01).range(1e-4..=1e4).suffix(" m")
        })
        .on_hover_text(
            "width of the patches that pass light on: smaller ones keep small bright places sharp",
        );
        ui.end_row();
        optional(ui, "grid", grid_vertices, vertices_now, absent, |drag| {
            drag.speed(20.0).range(0..=10_000_000)
        })
        .on_hover_text("places in free space with light for moving objects; 0 for none");
        ui.end_row();
    });
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
}

/// How far the bake is.
fn progress(ui: &mut Ui, standing: &Standing, actions: &mut Actions) {
    ui.label("baking:");
    ui.add(ProgressBar::new(standing.share).text(standing.to_string()));
    if ui.button("cancel").clicked() {
        actions.push(Action::Request(Request::CancelBake));
    }
}

fn figures(ui: &mut Ui, baked: &BakedScene) {
    let settings = &baked.settings;
    Grid::new("baked").num_columns(2).show(ui, |ui| {
        row(ui, "triangles", baked.scene.triangles.len().to_string());
        row(ui, "receivers", baked.receiver_texels.len().to_string());
        row(ui, "texels per metre", format!("{:.2}", settings.texels_per_meter));
        row(ui, "lightmap", format!("{} × {}", baked.lightmap.width, baked.lightmap.height));
        row(ui, "probes", baked.probes.len().to_string());
        row(ui, "surfels", baked.surfels.len().to_string());
        row(ui, "clusters", baked.clusters.len().to_string());
        row(ui, "grid vertices", baked.grid_vertices.len().to_string());
        let bytes = 4 * (baked.receiver_basis.len() + baked.signal_basis.len());
        row(ui, "matrices", format!("{:.2} MB", bytes as f64 / 1e6));
        row(ui, "mean error", format!("{:.2} %", 100.0 * baked.report.mean_cluster_error));
    });
    for warning in &baked.report.warnings {
        ui.colored_label(ui.visuals().warn_fg_color, warning);
    }
}
