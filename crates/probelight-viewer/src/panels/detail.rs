//! Levels of detail: every number of them, while it runs.

use eframe::egui::{ComboBox, DragValue, Grid, Response, ScrollArea, Slider, Ui};
use probelight_asset::BakedScene;
use probelight_runtime::{
    FrameInput, FramePlan, LodLevel, LodPreset, LodSettings, Planner, View, stage_bytes,
};

use super::{Actions, optional, row};
use crate::scene::frame_work::FrameWork;
use crate::state::{Action, State};

/// How near levels begin, as factors on their distances, as they are held.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// By the time of frames.
    pub by_time: Option<f32>,
    /// By the similarity of pictures, once it is found.
    pub by_similarity: Option<f32>,
}

/// What numbers save of a frame's bytes, as the view is. Only asked where the mouse is.
struct Savings<'a> {
    baked: &'a BakedScene,
    view: View,
    /// The settings that are shown.
    lod: &'a LodSettings,
}

impl Savings<'_> {
    /// Bytes that a frame moves in which lights move.
    fn bytes(&self, lod: &LodSettings) -> u64 {
        let input = FrameInput { view: Some(self.view), ..FrameInput::default() };
        let mut plan = FramePlan::full(self.baked);
        Planner::new(self.baked).plan(self.baked, lod, &input, &mut plan);
        stage_bytes(self.baked, &plan, true).values().iter().sum()
    }

    /// What is saved against settings without something.
    fn against(&self, remove: impl FnOnce(&mut LodSettings)) -> String {
        let mut without = self.lod.clone();
        remove(&mut without);
        let [without, with] = [&without, self.lod].map(|lod| self.bytes(lod) as f64);
        let (unit, bytes) = if without < 1e6 { ("kB", 1e3) } else { ("MB", 1e6) };
        format!("saves {:.2} of {:.2} {unit} a frame", (without - with) / bytes, without / bytes)
    }

    /// What a number of a level saves.
    fn of_level(&self, number: usize, remove: impl FnOnce(&mut LodLevel)) -> String {
        self.against(|lod| remove(&mut lod.levels[number]))
    }
}

/// Shows the levels of detail of a baked scene.
pub fn show(
    ui: &mut Ui,
    state: &State,
    baked: &BakedScene,
    work: &FrameWork,
    held: Held,
    actions: &mut Actions,
) {
    let mut view = state.view.clone();
    let savings = Savings { baked, view: View::from(&view.camera), lod: &state.view.lod };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        presets(ui, &mut view.lod);
        let time = Hold {
            name: "hold time",
            hint: "of the light's stages: levels come nearer",
            first: 4.0,
            scale: held.by_time,
        };
        time.show(ui, &mut view.hold_milliseconds, |value| {
            DragValue::new(value).speed(0.05).range(0.1..=200.0).suffix(" ms")
        });
        let similarity = Hold {
            name: "hold SSIM",
            hint: "to the picture without levels; looked for whenever nothing moves",
            first: 0.98,
            scale: held.by_similarity,
        };
        similarity.show(ui, &mut view.hold_similarity, |value| {
            DragValue::new(value).speed(1e-3).range(0.5..=0.999).fixed_decimals(3)
        });
        Grid::new("saved").num_columns(2).show(ui, |ui| {
            let [done, all] = [work.done.receivers, work.all.receivers];
            row(ui, "receivers", format!("{done} of {all} ({:.0} %)", share(done, all)));
            let [done, all] = [work.done.matrix_bytes, work.all.matrix_bytes];
            let [done_mb, all_mb] = [done, all].map(|bytes| bytes as f64 / 1e6);
            row(ui, "matrices", format!("{done_mb:.2} of {all_mb:.2} MB ({:.0} %)", share(done, all)));
            row(ui, "pending clusters", format!("{} of {}", work.done.pending_clusters, work.clusters));
        });
        ui.separator();
        levels(ui, &mut view.lod, &savings);
        general(ui, &mut view.lod);
        if ui.button("copy as JSON").clicked() {
            let json = serde_json::to_string_pretty(&view.lod).unwrap_or_default();
            actions.push(Action::Request(crate::state::Request::CopyText(json)));
        }
    });
    if view != state.view && view.lod.check().is_ok() {
        actions.push(Action::View(Box::new(view)));
    }
}

/// Percent.
fn share(part: u64, all: u64) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

fn presets(ui: &mut Ui, lod: &mut LodSettings) {
    let present = LodPreset::ALL.into_iter().find(|preset| preset.settings() == *lod);
    let everything = *lod == LodSettings::default();
    let name = present.map_or(if everything { "everything" } else { "own" }, LodPreset::name);
    ui.horizontal(|ui| {
        ui.label("preset");
        ComboBox::from_id_salt("preset").selected_text(name).show_ui(ui, |ui| {
            if ui.selectable_label(everything, "everything").clicked() {
                *lod = LodSettings::default();
            }
            for preset in LodPreset::ALL {
                if ui.selectable_label(present == Some(preset), preset.name()).clicked() {
                    *lod = preset.settings();
                }
            }
        });
    });
}

/// Something that levels of detail hold by how near they begin.
struct Hold {
    name: &'static str,
    hint: &'static str,
    /// What is held at first.
    first: f32,
    /// Present factor on distances.
    scale: Option<f32>,
}

impl Hold {
    fn show(self, ui: &mut Ui, held: &mut Option<f32>, drag: impl Fn(&mut f32) -> DragValue<'_>) {
        ui.horizontal(|ui| {
            let mut holds = held.is_some();
            if ui.checkbox(&mut holds, self.name).on_hover_text(self.hint).changed() {
                *held = holds.then_some(self.first);
            }
            if let Some(value) = held {
                ui.add(drag(value));
                ui.label(self.scale.map_or("…".into(), |scale| format!("distances × {scale:.2}")));
            }
        });
    }
}

fn levels(ui: &mut Ui, lod: &mut LodSettings, savings: &Savings<'_>) {
    let mut remove = None;
    let count = lod.levels.len();
    for (number, level) in lod.levels.iter_mut().enumerate() {
        ui.push_id(number, |ui| {
            ui.horizontal(|ui| {
                let name = ui.strong(format!("level {number}"));
                if number > 0 {
                    name.on_hover_ui(|ui| {
                        ui.label(savings.against(|lod| _ = lod.levels.remove(number)));
                    });
                }
                if count > 1 && ui.small_button("✖").on_hover_text("remove this level").clicked() {
                    remove = Some(number);
                }
            });
            Grid::new("level").num_columns(4).show(ui, |ui| level_numbers(ui, level, number, savings));
        });
    }
    if let Some(number) = remove {
        lod.levels.remove(number);
    }
    if ui.button("+ level").clicked() {
        let last = lod.levels.last().copied().unwrap_or_default();
        let farther = |distance: f32| if distance > 0.0 { 2.0 * distance } else { 10.0 };
        lod.levels.push(LodLevel {
            distance: farther(last.distance),
            beside: last.beside.map(farther),
            behind: last.behind.map(farther),
            ..last
        });
    }
}

fn level_numbers(ui: &mut Ui, level: &mut LodLevel, number: usize, savings: &Savings<'_>) {
    fn metres(drag: DragValue<'_>) -> DragValue<'_> {
        drag.speed(0.1).range(0.0..=1e5).suffix(" m").max_decimals(1)
    }
    ui.label("from");
    ui.add(metres(DragValue::new(&mut level.distance)));
    let saves = |of: Response, remove: fn(&mut LodLevel)| {
        of.on_hover_ui(|ui| _ = ui.label(savings.of_level(number, remove)));
    };
    saves(ui.label("lightmap"), |level| level.lightmap_level = 0);
    ui.add(DragValue::new(&mut level.lightmap_level).speed(0.02).range(0..=3));
    ui.end_row();
    optional(ui, "beside", &mut level.beside, level.distance, "all", metres);
    optional(ui, "behind", &mut level.behind, level.distance, "all", metres);
    ui.end_row();
    let rank = optional(ui, "rank", &mut level.rank, 16, "all", |drag| drag.speed(0.1).range(1..=256));
    saves(rank, |level| level.rank = None);
    let degree = optional(ui, "degree", &mut level.degree, 4, "all", |drag| drag.speed(0.05).range(0..=11));
    saves(degree, |level| level.degree = None);
    ui.end_row();
    let rays = optional(ui, "rays", &mut level.rays, 256, "all", |drag| drag.speed(2.0).range(1..=16_384));
    saves(rays, |level| level.rays = None);
    optional(ui, "waits", &mut level.threshold, 0.01, "all", |drag| drag.speed(1e-3).range(0.0..=1.0))
        .on_hover_text("what changes less, as a share of a cluster's light, is computed later");
    ui.end_row();
}

fn general(ui: &mut Ui, lod: &mut LodSettings) {
    Grid::new("general").num_columns(2).show(ui, |ui| {
        let mut slider = |name: &str, hint: &str, slider: Slider<'_>| {
            ui.label(name).on_hover_text(hint);
            ui.add(slider);
            ui.end_row();
        };
        slider("in front above", "cosine with the view", Slider::new(&mut lod.zones.front, -1.0..=1.0));
        slider("behind below", "cosine with the view", Slider::new(&mut lod.zones.behind, -1.0..=1.0));
        slider("zones blend", "width in cosines", Slider::new(&mut lod.zones.band, 0.0..=1.0));
        slider("probes nearer by", "support radii", Slider::new(&mut lod.support_shift, 0.0..=3.0));
        slider("fade", "share of a distance", Slider::new(&mut lod.fade, 0.0..=1.0));
        slider(
            "small changes wait",
            "share of a cluster's light",
            Slider::new(&mut lod.changes.threshold, 0.0..=0.1),
        );
        slider("at most", "frames", Slider::new(&mut lod.changes.longest_wait, 1..=256));
        slider("probes in turns", "frames in which all are relit", Slider::new(&mut lod.probe_turns, 1..=32));
    });
    Grid::new("share").num_columns(2).show(ui, |ui| {
        let share = &mut lod.changes.matrix_share;
        optional(ui, "share a frame", share, 0.25, "all", |drag| drag.speed(1e-3).range(0.01..=1.0))
            .on_hover_text("of the transport matrices that a frame may read; the largest changes go first");
    });
}
