//! Panels, windows and the picture.

use std::path::PathBuf;

use eframe::egui::{self, Align2, Color32, Panel, Pos2, Rect, Sense, Ui};

use super::{Tab, Viewer};
use crate::handles::{self, Frame};
use crate::mouse;
use crate::overlays;
use crate::panels::{self, Actions};
use crate::scene::pick::Picked;
use crate::scene::reference_picture::ReferencePicture;
use crate::state::Action;
use crate::state::view_state::Compare;

impl Viewer {
    pub(super) fn panels(&mut self, ui: &mut Ui, actions: &mut Actions) {
        let panels = self.state.view.panels;
        let Self { state, live, times, work, picked, bake, meter, .. } = self;
        let status = panels::menu::Status {
            title: &title(&self.scene_file),
            recent: &self.settings.recent,
            is_recording: self.recording.is_some(),
            work: match bake {
                Some(bake) => Some(bake.standing().to_string()),
                None => (self.loader.pending > 0).then(|| "reading…".into()),
            },
        };
        Panel::top("menu").show(ui, |ui| panels::menu::show(ui, state, &status, actions));
        if panels.timing {
            let memory = self.memory.1;
            Panel::bottom("times").exact_size(170.0).show(ui, |ui| {
                panels::timing::show(ui, state, times, work, memory, actions);
            });
        }
        let Some(live) = live else { return };
        if panels.scene {
            let panel = Panel::left("scene").resizable(true).default_size(330.0).min_size(220.0);
            panel.show(ui, |ui| panels::scene::show(ui, state, live.scene(), &live.models, actions));
        }
        if panels.settings {
            let panel = Panel::right("settings").resizable(true).default_size(290.0).min_size(260.0);
            let held = panels::detail::Held {
                by_time: self.governor.as_ref().map(|(_, governor)| governor.scale()),
                by_similarity: self.held.scale,
            };
            let passes = self.reference.as_ref().map(ReferencePicture::passes);
            let standing = bake.as_ref().map(|bake| bake.standing());
            panel.show(ui, |ui| {
                ui.horizontal(|ui| {
                    for (tab, name) in [
                        (Tab::Look, "View"),
                        (Tab::Detail, "Detail"),
                        (Tab::Bake, "Bake"),
                        (Tab::Picked, "Picked"),
                    ] {
                        ui.selectable_value(&mut self.tab, tab, name);
                    }
                });
                ui.separator();
                match self.tab {
                    Tab::Look => panels::look::show(ui, state, meter.reading.as_ref(), passes, actions),
                    Tab::Detail => panels::detail::show(ui, state, &live.baked, work, held, actions),
                    Tab::Bake => {
                        panels::bake::show(ui, state, &live.baked, live.is_baked, standing.as_ref(), actions);
                    }
                    Tab::Picked => panels::picked::show(ui, state, picked.as_ref(), actions),
                }
            });
        }
    }

    pub(super) fn windows(&mut self, actions: &mut Actions) {
        let mut panels = self.state.view.panels;
        let before = panels;
        let context = self.context.clone();
        egui::Window::new("Keys")
            .open(&mut panels.help)
            .default_height(500.0)
            .show(&context, panels::help::show);
        egui::Window::new("Lightmap").open(&mut panels.lightmap).default_size([520.0, 480.0]).show(
            &context,
            |ui| {
                panels::lightmap::show(ui, &self.state, self.lightmap.as_ref(), &mut self.zoom, actions);
            },
        );
        if panels != before {
            let mut view = self.state.view.clone();
            view.panels = panels;
            actions.push(Action::View(Box::new(view)));
        }
        self.messages.show(&context);
        self.show_dialogs();
    }

    /// The picture, and what the mouse does in it.
    pub(super) fn picture(&mut self, ui: &mut Ui, actions: &mut Actions) {
        let rect = ui.available_rect_before_wrap();
        self.rect = rect;
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        let scale = scale * self.state.view.resolution;
        let [width, height] =
            [rect.width(), rect.height()].map(|side| (side * scale).round().max(1.0) as u32);
        let was_resized = match self.screen.resize(width, height) {
            Ok(was_resized) => was_resized,
            Err(error) => {
                self.messages.error(error.to_string());
                false
            }
        };
        let camera = &mut self.state.view.camera;
        (camera.width, camera.height) = self.screen.size();
        let painter = ui.painter_at(rect);
        let texture = self.screen.texture(&self.window, was_resized);
        if self.live.is_none() {
            let text = if self.loader.pending > 0 {
                "reading…"
            } else {
                "drop a .glb or .plight here, or File › Open"
            };
            overlays::caption(&painter, rect.center(), Align2::CENTER_CENTER, text);
            return;
        }
        painter.image(texture, rect, Rect::from_min_max(Pos2::ZERO, egui::pos2(1.0, 1.0)), Color32::WHITE);
        let is_divided = self.is_divided();
        self.paint_overlays(&painter, rect, is_divided);
        let camera = self.state.view.camera.clone();
        let frame = Frame { rect, camera: &camera };
        actions.extend(mouse::mouse(
            &mut self.grip,
            &response,
            &frame,
            &self.state,
            self.live.as_ref(),
            is_divided,
        ));
    }

    fn is_divided(&self) -> bool {
        let is_there = match self.state.view.compare {
            Compare::Nothing => false,
            Compare::WithoutIndirect => true,
            Compare::Reference => self.reference.as_ref().is_some_and(|reference| reference.passes() > 0),
        };
        is_there && self.state.view.coloring != probelight_render::gpu::Coloring::Difference
    }

    fn paint_overlays(&self, painter: &egui::Painter, rect: Rect, is_divided: bool) {
        let view = &self.state.view;
        let frame = Frame { rect, camera: &view.camera };
        if view.overlays.lights {
            handles::paint(painter, &frame, &self.state.document, view, self.state.selection);
        }
        if is_divided {
            let x = rect.min.x + view.divider * rect.width();
            painter.vline(x, rect.y_range(), egui::Stroke::new(2.0, Color32::WHITE));
            let left =
                if view.compare == Compare::Reference { "path traced" } else { "without indirect light" };
            overlays::caption(painter, egui::pos2(x - 8.0, rect.min.y + 12.0), Align2::RIGHT_TOP, left);
            overlays::caption(
                painter,
                egui::pos2(x + 8.0, rect.min.y + 12.0),
                Align2::LEFT_TOP,
                "Probelight",
            );
        }
        if let Some(live) = self.live.as_ref().filter(|live| !live.is_baked) {
            let has_headlight = live.has_headlight(&self.state.document);
            let text = if has_headlight {
                "not baked yet: a lamp at the camera"
            } else {
                "not baked yet: direct light only"
            };
            overlays::caption(
                painter,
                rect.left_bottom() + egui::vec2(10.0, -10.0),
                Align2::LEFT_BOTTOM,
                text,
            );
        }
        let (Some(picked), Some(live)) = (&self.picked, &self.live) else { return };
        overlays::paint_place(painter, &frame, &picked.picked);
        let Picked::Surface(surface) = &picked.picked else { return };
        let receiver = surface.light.as_ref().and_then(|light| light.receiver.as_ref());
        if let Some(receiver) = receiver.filter(|_| view.overlays.probes) {
            overlays::paint_probes(painter, &frame, &live.baked, live.runtime.plan(), receiver);
        }
        if let Some(grid) = self.grid.as_ref().filter(|_| view.overlays.grid) {
            overlays::paint_grid(painter, &frame, grid, surface, self.state.shown_ev);
        }
    }

    /// The panel that says what is at the picked place.
    pub(crate) fn show_picked(&mut self) {
        self.tab = Tab::Picked;
    }
}

fn title(file: &Option<PathBuf>) -> String {
    let name = file.as_ref().and_then(|file| file.file_name());
    name.map_or_else(|| "nothing is open".into(), |name| name.to_string_lossy().into_owned())
}
