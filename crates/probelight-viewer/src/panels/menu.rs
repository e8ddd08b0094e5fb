//! The bar above.

use std::path::PathBuf;

use eframe::egui::{self, Button, MenuBar, Slider, Ui};

use super::Actions;
use crate::state::keys::shortcut_of;
use crate::state::view_state::Panels;
use crate::state::{Action, Request, State};

/// What the bar shows besides.
pub struct Status<'a> {
    /// What is open.
    pub title: &'a str,
    /// Files that were opened before.
    pub recent: &'a [PathBuf],
    /// Whether all frames are saved.
    pub is_recording: bool,
    /// What is going on.
    pub work: Option<String>,
}

/// Shows the bar.
pub fn show(ui: &mut Ui, state: &State, status: &Status, actions: &mut Actions) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(ui, status.recent, status.is_recording, actions));
        ui.menu_button("Edit", |ui| edit(ui, state, actions));
        ui.menu_button("Window", |ui| window(ui, state, actions));
        item(ui, "Help", &Action::ToggleHelp, actions);
        ui.separator();
        time(ui, state, actions);
        ui.separator();
        let star = if state.is_changed { "*" } else { "" };
        ui.label(format!("{}{star}", status.title));
        if let Some(work) = &status.work {
            ui.spinner();
            ui.label(work);
        }
    });
}

fn item(ui: &mut Ui, text: &str, action: &Action, actions: &mut Actions) {
    let mut button = Button::new(text);
    if let Some(shortcut) = shortcut_of(action) {
        button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
    }
    if ui.add(button).clicked() {
        actions.push(action.clone());
        ui.close();
    }
}

fn file(ui: &mut Ui, recent: &[PathBuf], is_recording: bool, actions: &mut Actions) {
    item(ui, "Open…", &Action::Request(Request::ChooseFile), actions);
    if cfg!(target_arch = "wasm32") {
        return item(ui, "Save setup", &Action::Request(Request::Save), actions);
    }
    ui.menu_button("Open recent", |ui| {
        for path in recent {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if ui.button(name).on_hover_text(path.to_string_lossy()).clicked() {
                actions.push(Action::Request(Request::Open(path.clone())));
                ui.close();
            }
        }
        if recent.is_empty() {
            ui.label("nothing yet");
        }
    });
    ui.separator();
    item(ui, "Save setup", &Action::Request(Request::Save), actions);
    item(ui, "Save setup as…", &Action::Request(Request::SaveAs), actions);
    item(ui, "Save bake as…", &Action::Request(Request::SaveBake), actions);
    item(ui, "Save picture", &Action::Request(Request::Screenshot), actions);
    let record = if is_recording { "Stop saving frames" } else { "Save all frames" };
    item(ui, record, &Action::Request(Request::ToggleRecording), actions);
    ui.separator();
    item(ui, "Quit", &Action::Request(Request::Quit), actions);
}

fn edit(ui: &mut Ui, state: &State, actions: &mut Actions) {
    let named = |verb: &str, what: Option<&str>| what.map_or(verb.into(), |what| format!("{verb}: {what}"));
    let undo = named("Undo", state.history.undoes());
    let redo = named("Redo", state.history.redoes());
    item(ui, &undo, &Action::Undo, actions);
    item(ui, &redo, &Action::Redo, actions);
    ui.separator();
    item(ui, "Copy", &Action::CopySelected, actions);
    item(ui, "Remove", &Action::RemoveSelected, actions);
    item(ui, "Look at", &Action::FocusSelected, actions);
}

fn window(ui: &mut Ui, state: &State, actions: &mut Actions) {
    let mut view = state.view.clone();
    let Panels { scene, settings, timing, lightmap, help } = &mut view.panels;
    for (panel, name) in [
        (scene, "Scene"),
        (settings, "View and bake"),
        (timing, "Times"),
        (lightmap, "Lightmap"),
        (help, "Keys"),
    ] {
        ui.checkbox(panel, name);
    }
    ui.separator();
    ui.checkbox(&mut view.caps_frames, "at most 60 frames a second");
    if !cfg!(target_arch = "wasm32") {
        ui.checkbox(&mut view.vsync, "frames wait for the display");
    }
    egui::widgets::global_theme_preference_buttons(ui);
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
}

/// What moves by itself, and when it is.
fn time(ui: &mut Ui, state: &State, actions: &mut Actions) {
    let mut view = state.view.clone();
    let text = if view.is_playing { "⏸" } else { "▶" };
    if ui.button(text).on_hover_text("stop or go on with all that moves by itself").clicked() {
        view.is_playing = !view.is_playing;
    }
    let end = state.document.end().max(60.0).max(view.time);
    ui.spacing_mut().slider_width = 120.0;
    ui.add(Slider::new(&mut view.time, 0.0..=end).suffix(" s").fixed_decimals(1));
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
}
