//! What is shown, and how.

use eframe::egui::{ComboBox, Grid, Slider, Ui};
use egui_plot::{Bar, BarChart, Plot, VLine};
use probelight_render::gpu::{Coloring, GpuView, Shading};

use super::Actions;
use crate::picture::meter::{Reading, STOPS};
use crate::state::view_state::{Compare, ExposureMode, TexelColors, ViewState};
use crate::state::{Action, State};

/// Exposure of middle grey, which the curve shows as such, as a power of two.
const MIDDLE_GREY: f32 = -1.9;

/// Shows what the picture is.
pub fn show(
    ui: &mut Ui,
    state: &State,
    reading: Option<&Reading>,
    passes: Option<u32>,
    actions: &mut Actions,
) {
    let mut view = state.view.clone();
    Grid::new("look").num_columns(2).show(ui, |ui| {
        picture(ui, &mut view);
        sources(ui, &mut view);
        overlays(ui, &mut view);
    });
    ui.separator();
    comparison(ui, &mut view, passes);
    ui.separator();
    exposure(ui, &mut view, state.shown_ev);
    if let Some(reading) = reading {
        histogram(ui, reading, state.shown_ev);
    }
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
}

fn picture(ui: &mut Ui, view: &mut ViewState) {
    ui.label("picture");
    let options = &mut view.options;
    ComboBox::from_id_salt("picture").width(150.0).selected_text(options.view.name()).show_ui(ui, |ui| {
        for choice in GpuView::ALL {
            ui.selectable_value(&mut options.view, choice, choice.name()).on_hover_text(choice.description());
        }
    });
    ui.end_row();
    if options.view == GpuView::Clusters {
        ui.label("colours");
        ComboBox::from_id_salt("colours").width(150.0).selected_text(view.texel_colors.name()).show_ui(
            ui,
            |ui| {
                for choice in TexelColors::ALL {
                    ui.selectable_value(&mut view.texel_colors, choice, choice.name());
                }
            },
        );
        ui.end_row();
    }
    ui.label("resolution");
    ui.add(Slider::new(&mut view.resolution, 0.25..=1.0).fixed_decimals(2));
    ui.end_row();
    ui.label("surfaces");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut view.options.shading, Shading::Diffuse, "diffuse");
        ui.selectable_value(&mut view.options.shading, Shading::Physical, "as in glTF");
    });
    ui.end_row();
}

fn sources(ui: &mut Ui, view: &mut ViewState) {
    ui.label("light of");
    ui.horizontal(|ui| {
        let mut sky = !view.muted.sky;
        let mut emission = !view.muted.emission;
        let mut bounces = !view.muted.bounces;
        ui.checkbox(&mut sky, "sky");
        ui.checkbox(&mut emission, "emission");
        ui.checkbox(&mut bounces, "bounces").on_hover_text("what surfaces pass on of the light they receive");
        (view.muted.sky, view.muted.emission, view.muted.bounces) = (!sky, !emission, !bounces);
    });
    ui.end_row();
}

fn overlays(ui: &mut Ui, view: &mut ViewState) {
    ui.label("over it");
    ui.horizontal(|ui| {
        ui.checkbox(&mut view.overlays.lights, "lights");
        ui.checkbox(&mut view.overlays.probes, "probes").on_hover_text("that serve the picked place");
        ui.checkbox(&mut view.overlays.grid, "grid")
            .on_hover_text("light in free space, near the picked place");
    });
    ui.end_row();
}

fn comparison(ui: &mut Ui, view: &mut ViewState, passes: Option<u32>) {
    ui.horizontal(|ui| {
        ui.label("left");
        ui.selectable_value(&mut view.compare, Compare::Nothing, "same");
        ui.selectable_value(&mut view.compare, Compare::WithoutIndirect, "without GI");
        ui.selectable_value(&mut view.compare, Compare::Reference, "reference");
    });
    if view.compare == Compare::Reference {
        ui.small(match passes {
            Some(passes) => format!("{passes} paths a pixel, growing while nothing changes"),
            None => "begins when nothing changes".into(),
        });
    }
    ui.horizontal(|ui| {
        ui.label("colours");
        ui.selectable_value(&mut view.coloring, Coloring::Natural, "natural");
        ui.selectable_value(&mut view.coloring, Coloring::Stops, "stops");
        let difference = ui.selectable_value(&mut view.coloring, Coloring::Difference, "difference");
        difference.on_hover_text("from what is left: red is brighter, blue darker, full at 50 %");
    });
    match view.coloring {
        Coloring::Natural => {}
        Coloring::Stops => _ = ui.small("−6 blue · green · grey: middle · yellow · red +6 stops"),
        Coloring::Difference if view.compare == Compare::Nothing => {
            ui.small("choose above what it differs from");
        }
        Coloring::Difference => _ = ui.small("−50 % blue · black: same · red +50 %"),
    }
    ui.checkbox(&mut view.marks, "mark broken and clipped pixels");
}

fn exposure(ui: &mut Ui, view: &mut ViewState, shown: f32) {
    let mut is_automatic = view.exposure == ExposureMode::Automatic;
    let mut ev = shown;
    ui.horizontal(|ui| {
        ui.label("exposure");
        ui.checkbox(&mut is_automatic, "automatic");
    });
    let changed = ui.add(Slider::new(&mut ev, -16.0..=16.0).suffix(" EV")).changed();
    view.exposure = match (is_automatic && !changed, view.exposure) {
        (true, _) => ExposureMode::Automatic,
        (false, ExposureMode::Fixed(fixed)) if !changed => ExposureMode::Fixed(fixed),
        (false, _) => ExposureMode::Fixed(ev),
    };
}

fn histogram(ui: &mut Ui, reading: &Reading, ev: f32) {
    let total = reading.histogram.iter().sum::<u32>().max(1) as f64;
    let bar = |(number, count): (usize, &u32)| {
        let stop = f64::from(STOPS.start) + 0.5 * number as f64 + 0.25;
        Bar::new(stop + f64::from(ev), f64::from(*count) / total).width(0.5)
    };
    let bars = reading.histogram.iter().enumerate().map(bar).collect();
    Plot::new("histogram")
        .height(70.0)
        .show_axes([true, false])
        .show_grid(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .include_x(-10.0)
        .include_x(6.0)
        .show(ui, |plot| {
            plot.bar_chart(BarChart::new("pixels", bars));
            plot.vline(VLine::new("middle grey", f64::from(MIDDLE_GREY)));
        });
    ui.small("exposed stops; the line is middle grey");
    if reading.broken > 0.0 {
        ui.colored_label(
            ui.visuals().warn_fg_color,
            format!("{:.2} % of pixels are broken", reading.broken * 100.0),
        );
    }
}
