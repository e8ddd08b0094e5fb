//! Keys.

use eframe::egui::{Grid, ScrollArea, Ui};

use crate::state::keys::{HELD, bindings};

/// Shows what keys and the mouse do.
pub fn show(ui: &mut Ui) {
    ScrollArea::vertical().show(ui, |ui| {
        Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for (held, what) in HELD {
                ui.monospace(held);
                ui.label(what);
                ui.end_row();
            }
            for binding in bindings() {
                ui.monospace(ui.ctx().format_shortcut(&binding.shortcut));
                ui.label(binding.description);
                ui.end_row();
            }
        });
    });
}
