//! How long frames take.

use eframe::egui::{Color32, Grid, ScrollArea, Ui};
use egui_plot::{HLine, Legend, Line, Plot, PlotPoints};
use probelight_runtime::Stage;

use super::Actions;
use super::detail::Work;
use crate::scene::frame_times::{FrameTimes, SHOWN_FRAMES};
use crate::state::{Action, Request, State};

/// Shows the last frames and the stages of one.
pub fn show(ui: &mut Ui, state: &State, times: &FrameTimes, work: Work, memory: u64, actions: &mut Actions) {
    ui.horizontal_top(|ui| {
        graph(ui, state, times);
        ScrollArea::vertical().id_salt("times").show(ui, |ui| stages(ui, times, work, memory, actions));
    });
}

fn graph(ui: &mut Ui, state: &State, times: &FrameTimes) {
    let first = SHOWN_FRAMES - times.frames().len();
    let milliseconds = |duration: std::time::Duration| duration.as_secs_f64() * 1e3;
    let points =
        |value: &dyn Fn(&crate::scene::frame_times::FrameTime) -> Option<f64>| -> PlotPoints<'static> {
            let frames = times.frames().enumerate();
            frames.filter_map(|(n, frame)| Some([(first + n) as f64, value(frame)?])).collect()
        };
    let mut all: Vec<f64> =
        times.frames().map(|frame| milliseconds(frame.interval.max(frame.host))).collect();
    all.sort_by(f64::total_cmp);
    // A few slow frames, such as the first, do not make all others flat.
    let highest = all.get(all.len() * 19 / 20).copied().unwrap_or_default();
    let budget = state.view.hold_milliseconds.map_or(1000.0 / 60.0, f64::from);
    Plot::new("frames")
        .width((ui.available_width() - 400.0).max(200.0))
        .height(ui.available_height())
        .legend(Legend::default())
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_axes([false, true])
        .y_axis_label("ms")
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=SHOWN_FRAMES as f64);
            plot.set_plot_bounds_y(0.0..=1.25 * highest.max(budget));
            let frame = |f: &crate::scene::frame_times::FrameTime| {
                (!f.interval.is_zero()).then(|| milliseconds(f.interval))
            };
            plot.line(Line::new("frame", points(&frame)));
            plot.line(Line::new("light", points(&|f| Some(milliseconds(f.light?.frame)))));
            plot.line(Line::new("window", points(&|f| Some(milliseconds(f.host)))));
            plot.hline(HLine::new("budget", budget).color(Color32::from_gray(140)));
        });
}

fn stages(ui: &mut Ui, times: &FrameTimes, work: Work, memory: u64, actions: &mut Actions) {
    let interval = times.mean_interval().map(|interval| interval.as_secs_f64() * 1e3);
    Grid::new("stages").num_columns(4).min_col_width(80.0).striped(true).show(ui, |ui| {
        ui.label("frame");
        ui.monospace(interval.map_or("–".into(), |ms| format!("{ms:.2} ms")));
        ui.label("receivers");
        ui.monospace(work.receivers[0].to_string());
        ui.end_row();
        let stage_time =
            |stage: Stage| times.last_light().map(|light| light.stages[stage].as_secs_f64() * 1e3);
        for (number, stage) in Stage::ALL.into_iter().enumerate() {
            ui.label(stage.name());
            ui.monospace(stage_time(stage).map_or("–".into(), |ms| format!("{ms:.2} ms")));
            match number {
                0 => {
                    ui.label("matrices");
                    ui.monospace(format!("{:.2} MB", work.matrix_bytes[0] as f64 / 1e6));
                }
                1 => {
                    ui.label("on the GPU");
                    ui.monospace(format!("{:.0} MB", memory as f64 / 1e6));
                }
                2 if ui.button("copy as JSON").clicked() => {
                    actions.push(Action::Request(Request::CopyText(json(times, work, memory))));
                }
                _ => {}
            }
            ui.end_row();
        }
    });
}

/// The figures for whoever keeps them.
fn json(times: &FrameTimes, work: Work, memory: u64) -> String {
    serde_json::to_string_pretty(&figures(times, work, memory)).unwrap_or_default()
}

/// The figures as they are copied.
pub fn figures(times: &FrameTimes, work: Work, memory: u64) -> serde_json::Value {
    let milliseconds = |duration: std::time::Duration| duration.as_secs_f64() * 1e3;
    let stages: serde_json::Map<String, serde_json::Value> = times
        .last_light()
        .map(|light| {
            Stage::ALL.iter().map(|s| (s.name().into(), milliseconds(light.stages[*s]).into())).collect()
        })
        .unwrap_or_default();
    serde_json::json!({
        "frame_milliseconds": times.mean_interval().map(milliseconds),
        "stage_milliseconds": stages,
        "receivers": work.receivers[0],
        "receivers_all": work.receivers[1],
        "matrix_bytes": work.matrix_bytes[0],
        "matrix_bytes_all": work.matrix_bytes[1],
        "gpu_bytes": memory,
    })
}
