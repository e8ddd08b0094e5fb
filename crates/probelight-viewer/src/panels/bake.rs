//! Baking, and what was baked.

use eframe::egui::{Grid, ProgressBar, Ui};
use probelight_asset::BakedScene;

use super::{Actions, row};
use crate::platform::QUALITIES;
use crate::scene::progress::Standing;
use crate::state::{Action, Request};

/// Shows what was baked, and what could be.
pub fn show(
    ui: &mut Ui,
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
