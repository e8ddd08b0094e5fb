//! What is drawn over the picture about the picked place: its probes with their rays (\[SED\] figure 5) and reach (figures 6
//! and 7), and light in free space around it (figure 4).

use std::sync::Arc;

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Stroke};
use probelight_asset::{BakedScene, NONE};
use probelight_math::glam::Vec3;
use probelight_runtime::{FramePlan, GridPlaces, IrradianceGrid};

use crate::handles::Frame;
use crate::scene::pick::{Picked, PickedReceiver, PickedSurface};

/// Most rays drawn of a probe.
const RAYS: usize = 160;

/// Most probes drawn.
const PROBES: usize = 24;

/// Cells of the grid drawn around the picked place, along each axis.
const CELLS: i32 = 4;

/// The picked place.
pub fn paint_place(painter: &Painter, frame: &Frame, picked: &Picked) {
    let position = match picked {
        Picked::Nothing => return,
        Picked::Object(_, position) => *position,
        Picked::Surface(surface) => surface.position,
    };
    let Some((at, _)) = frame.project(position) else { return };
    painter.circle_stroke(at, 5.0, Stroke::new(3.0, Color32::BLACK));
    painter.circle_stroke(at, 5.0, Stroke::new(1.5, Color32::WHITE));
}

/// Rays and reach of the probes that serve a place.
pub fn paint_probes(
    painter: &Painter,
    frame: &Frame,
    baked: &BakedScene,
    plan: &FramePlan,
    receiver: &PickedReceiver,
) {
    let nearest = receiver.probes.iter().take(PROBES);
    for (number, probe) in nearest.enumerate() {
        let index = *probe as usize;
        let place = baked.probes[index].position;
        let Some((at, _)) = frame.project(place) else { continue };
        let color =
            if number == 0 { Color32::from_rgb(255, 200, 60) } else { Color32::from_rgb(120, 200, 255) };
        painter.circle(at, 4.0, color, Stroke::new(1.0, Color32::BLACK));
        if number == 0 {
            paint_rays(painter, frame, baked, plan, index);
            paint_reach(painter, frame, baked, index);
        }
    }
}

/// Those relight rays of a probe that its level has.
fn paint_rays(painter: &Painter, frame: &Frame, baked: &BakedScene, plan: &FramePlan, probe: usize) {
    let rays = baked.relight_directions.len();
    let computed = plan.probes()[probe].rays as usize;
    let place = baked.probes[probe].position;
    let step = computed.div_ceil(RAYS).max(1);
    for ray in (0..computed).step_by(step) {
        let surfel = baked.relight_surfels[probe * rays + ray];
        let color =
            if surfel == NONE { Color32::from_rgb(120, 170, 255) } else { Color32::from_rgb(255, 220, 120) };
        let end = if surfel == NONE {
            place + baked.relight_directions[ray] * 0.1 * baked.scene.bounds().diagonal()
        } else {
            let sample = baked.samples_of(&baked.surfels[surfel as usize])[0];
            baked.place_of(&sample).0
        };
        line(painter, frame, place, end, Stroke::new(0.7, color.gamma_multiply(0.6)));
    }
}

/// The circle around a probe within which its receivers lie.
fn paint_reach(painter: &Painter, frame: &Frame, baked: &BakedScene, probe: usize) {
    let probe = &baked.probes[probe];
    for [a, b] in [[Vec3::X, Vec3::Z], [Vec3::X, Vec3::Y]] {
        let point = |step: usize| {
            let (sin, cos) = (step as f32 * std::f32::consts::TAU / 48.0).sin_cos();
            probe.position + probe.support_radius * (a * cos + b * sin)
        };
        for step in 0..48 {
            line(
                painter,
                frame,
                point(step),
                point(step + 1),
                Stroke::new(1.0, Color32::from_rgb(255, 200, 60)),
            );
        }
    }
}

/// Light in free space, as it was read from the GPU.
pub struct GridOfLight {
    /// The scene.
    pub baked: Arc<BakedScene>,
    /// Where its vertices are.
    pub places: GridPlaces,
    /// Irradiance of all receivers, W/m².
    pub receivers: Vec<Vec3>,
    /// Distance between the places that are shown, metres.
    pub spacing: f32,
}

/// Light in free space around a place: a dot in the colour of what arrives, and an arrow to where most of it comes from.
pub fn paint_grid(painter: &Painter, frame: &Frame, grid: &GridOfLight, surface: &PickedSurface, ev: f32) {
    let around = surface.position + surface.normal * grid.spacing;
    let light = IrradianceGrid::new(&grid.baked, &grid.places, &grid.receivers);
    let half = CELLS / 2;
    let columns = (-half..=half).flat_map(|x| (-half..=half).map(move |z| (x, z)));
    let offsets = columns.flat_map(|(x, z)| (0..=half).map(move |y| Vec3::new(x as f32, y as f32, z as f32)));
    for offset in offsets {
        let place = around + offset * grid.spacing;
        let Some(there) = light.light(place, Vec3::Y) else { continue };
        let vector = there.light_vector();
        let mean =
            Vec3::AXES.iter().map(|axis| there.irradiance(*axis) + there.irradiance(-*axis)).sum::<Vec3>()
                / 6.0;
        let Some((at, _)) = frame.project(place) else { continue };
        painter.circle(at, 4.0, shown(mean, ev), Stroke::new(0.5, Color32::BLACK));
        if let Some(towards) = vector.try_normalize() {
            line(
                painter,
                frame,
                place,
                place + towards * 0.5 * grid.spacing,
                Stroke::new(1.5, Color32::WHITE),
            );
        }
    }
}

fn shown(irradiance: Vec3, ev: f32) -> Color32 {
    let radiance = irradiance * std::f32::consts::FRAC_1_PI;
    let linear = probelight_render::ToneMap::of_ev(ev).display_from_radiance(radiance);
    let [r, g, b] = probelight_math::color::srgb8_from_linear(linear);
    Color32::from_rgb(r, g, b)
}

fn line(painter: &Painter, frame: &Frame, from: Vec3, to: Vec3, stroke: Stroke) {
    if let (Some((from, _)), Some((to, _))) = (frame.project(from), frame.project(to)) {
        painter.line_segment([from, to], stroke);
    }
}

/// A line of text with a dark ground, from its top left corner.
pub fn caption(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(13.0), Color32::WHITE);
    let rect = align.anchor_size(at, galley.size()).expand(3.0);
    painter.rect_filled(rect, 3.0, Color32::from_black_alpha(150));
    painter.galley(rect.min + eframe::egui::Vec2::splat(3.0), galley, Color32::WHITE);
}
