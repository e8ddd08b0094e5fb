//! How long frames take.

use std::time::Duration;

use eframe::egui::epaint::Hsva;
use eframe::egui::{Color32, Grid, ScrollArea, Ui};
use egui_plot::{Corner, HLine, Legend, Line, Plot, PlotPoints};
use probelight_runtime::Stage;

use super::Actions;
use crate::scene::frame_times::{FrameTime, FrameTimes, SHOWN_FRAMES};
use crate::scene::frame_work::FrameWork;
use crate::state::{Action, Request, State};

/// Shows the last frames and the stages of one.
pub fn show(
    ui: &mut Ui,
    state: &State,
    times: &FrameTimes,
    work: &FrameWork,
    memory: u64,
    actions: &mut Actions,
) {
    ui.horizontal_top(|ui| {
        graph(ui, state, times);
        ScrollArea::vertical().id_salt("times").show(ui, |ui| stages(ui, times, work, memory, actions));
    });
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

fn graph(ui: &mut Ui, state: &State, times: &FrameTimes) {
    let first = SHOWN_FRAMES - times.frames().len();
    let points = |value: &dyn Fn(&FrameTime) -> Option<Duration>| -> PlotPoints<'static> {
        let frames = times.frames().enumerate();
        frames.filter_map(|(n, frame)| Some([(first + n) as f64, milliseconds(value(frame)?)])).collect()
    };
    let mut all: Vec<f64> =
        times.frames().map(|frame| milliseconds(frame.interval.max(frame.host))).collect();
    all.sort_by(f64::total_cmp);
    // A few slow frames, such as the first, do not make all others flat.
    let highest = all.get(all.len() * 19 / 20).copied().unwrap_or_default();
    let budget = state.view.hold_milliseconds.map_or(1000.0 / 60.0, f64::from);
    Plot::new("frames")
        .width((ui.available_width() - 430.0).max(200.0))
        .height(ui.available_height())
        .legend(Legend::default().position(Corner::LeftTop))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_axes([false, true])
        .y_axis_label("ms")
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=SHOWN_FRAMES as f64);
            plot.set_plot_bounds_y(0.0..=1.25 * highest.max(budget));
            let frame = |f: &FrameTime| (!f.interval.is_zero()).then_some(f.interval);
            plot.line(Line::new("frame", points(&frame)));
            plot.line(Line::new("window", points(&|f| Some(f.host))));
            plot.line(Line::new("all light", points(&|f| Some(f.light?.frame))));
            for stage in Stage::ALL {
                // Their names stand beside the graph.
                let line = Line::new("", points(&|f| Some(f.light?.stages[stage])));
                plot.line(line.color(color_of(stage)).width(1.0));
            }
            plot.hline(HLine::new("budget", budget).color(Color32::from_gray(140)));
        });
}

/// Colour of a stage's line, and of its name.
fn color_of(stage: Stage) -> Color32 {
    let hue = stage as usize as f32 / Stage::ALL.len() as f32;
    Hsva::new(hue, 0.55, 0.85, 1.0).into()
}

fn stages(ui: &mut Ui, times: &FrameTimes, work: &FrameWork, memory: u64, actions: &mut Actions) {
    let of_light = |stage: Stage| times.last_light().map(|light| light.stages[stage]);
    let text =
        |time: Option<Duration>| time.map_or("–".into(), |time| format!("{:.2} ms", milliseconds(time)));
    let (done, all) = (work.done, work.all);
    let [done_mb, all_mb] = [done, all].map(|work| work.matrix_bytes as f64 / 1e6);
    let beside = [
        ("receivers", format!("{} of {}", done.receivers, all.receivers)),
        ("matrices", format!("{done_mb:.2} of {all_mb:.2} MB")),
        ("pending clusters", format!("{} of {}", done.pending_clusters, work.clusters)),
        ("on the GPU", format!("{:.0} MB", memory as f64 / 1e6)),
        ("first picture", times.first_picture().map_or("–".into(), |t| format!("{:.1} s", t.as_secs_f64()))),
    ];
    let mut beside = beside.into_iter().map(Some).chain([None]);
    let mut more = |ui: &mut Ui| {
        match beside.next() {
            Some(Some((name, value))) => {
                ui.label(name);
                ui.monospace(value);
            }
            Some(None) if ui.button("copy as JSON").clicked() => {
                let json = serde_json::to_string_pretty(&figures(times, work, memory)).unwrap_or_default();
                actions.push(Action::Request(Request::CopyText(json)));
            }
            _ => {}
        }
        ui.end_row();
    };
    Grid::new("stages").num_columns(4).striped(true).show(ui, |ui| {
        ui.label("frame");
        ui.monospace(text(times.mean_interval()));
        more(ui);
        for stage in Stage::ALL {
            ui.colored_label(color_of(stage), stage.name());
            ui.monospace(text(of_light(stage)));
            more(ui);
        }
    });
}

/// The figures as they are copied.
pub fn figures(times: &FrameTimes, work: &FrameWork, memory: u64) -> serde_json::Value {
    let stages: serde_json::Map<String, serde_json::Value> = times
        .last_light()
        .map(|light| {
            Stage::ALL.iter().map(|s| (s.name().into(), milliseconds(light.stages[*s]).into())).collect()
        })
        .unwrap_or_default();
    serde_json::json!({
        "first_picture_seconds": times.first_picture().map(|time| time.as_secs_f64()),
        "frame_milliseconds": times.mean_interval().map(milliseconds),
        "stage_milliseconds": stages,
        "receivers": work.done.receivers,
        "receivers_all": work.all.receivers,
        "matrix_bytes": work.done.matrix_bytes,
        "matrix_bytes_all": work.all.matrix_bytes,
        "pending_clusters": work.done.pending_clusters,
        "clusters": work.clusters,
        "gpu_bytes": memory,
    })
}
