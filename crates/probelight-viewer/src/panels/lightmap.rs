//! The lightmap as a picture: its light, its charts, and what computes it.

use std::cell::OnceCell;
use std::sync::Arc;

use eframe::egui::{
    Color32, ColorImage, ComboBox, Context, Pos2, Rect, ScrollArea, Sense, Slider, TextureHandle,
    TextureOptions, Ui, Vec2, pos2, vec2,
};
use probelight_asset::{BakedScene, NONE};
use probelight_math::color::srgb8_from_linear;
use probelight_math::glam::Vec3;
use probelight_render::ToneMap;
use probelight_render::gpu::GpuRenderer;
use probelight_scene::Camera;

use super::Actions;
use crate::picture::charts::charts_of_texels;
use crate::picture::texel_colors::texel_color;
use crate::scene::live_scene::LiveScene;
use crate::scene::pick::{PickedReceiver, receiver_of};
use crate::state::view_state::{PageColors, TexelColors, ViewState};
use crate::state::{Action, State};

/// Where there is nothing.
const NOTHING: Color32 = Color32::from_gray(40);

/// A lightmap that was read from the GPU.
pub struct LightmapPage {
    baked: Arc<BakedScene>,
    /// The receiver of each texel, once somebody asks.
    receivers: OnceCell<Vec<u32>>,
    irradiance: Vec<Vec3>,
    image: Arc<ColorImage>,
    texture: TextureHandle,
}

impl LightmapPage {
    /// Of texels in W/m², rows from the top, in the colours of a view and shown at an exposure.
    pub fn new(
        context: &Context,
        live: &LiveScene,
        irradiance: Vec<Vec3>,
        view: &ViewState,
        ev: f32,
    ) -> Self {
        let size = [live.baked.lightmap.width, live.baked.lightmap.height].map(|side| side as usize);
        let colors = match view.page_colors {
            PageColors::Irradiance => colors_of_light(&irradiance, ev),
            PageColors::Charts => colors_of_charts(&live.baked),
            PageColors::Texels(colors) => colors_of_receivers(live, &view.camera, colors),
        };
        let image = Arc::new(ColorImage::new(size, colors));
        let texture = context.load_texture("lightmap", Arc::clone(&image), TextureOptions::NEAREST);
        Self { baked: Arc::clone(&live.baked), receivers: OnceCell::new(), irradiance, image, texture }
    }

    /// What is shown, rows from the top.
    pub(crate) fn colors(&self) -> &[Color32] {
        &self.image.pixels
    }

    /// What is said of a texel.
    fn note(&self, x: usize, y: usize) -> Option<String> {
        let texel = y * self.baked.lightmap.width as usize + x;
        let light = self.irradiance.get(texel)?;
        let mut note = format!("texel {x}, {y}: {:.4} {:.4} {:.4} W/m²", light.x, light.y, light.z);
        let receiver = self.receivers.get_or_init(|| self.baked.receivers_of_texels())[texel];
        if let Some(receiver) = (receiver != NONE).then(|| receiver_of(&self.baked, receiver)).flatten() {
            let PickedReceiver { cluster, receivers, rank, columns, error, probes, .. } = receiver;
            let probes = probes.len();
            note += &format!("\ncluster {cluster}: {receivers} receivers, {probes} probes");
            note += &format!("\n{rank} singular values of {columns} columns");
            note += &format!("\nerror {error:.2} × the wanted one");
        }
        Some(note)
    }
}

fn colors_of_light(irradiance: &[Vec3], ev: f32) -> Vec<Color32> {
    // As if the surfaces were white.
    let tone_map = ToneMap::of_ev(ev - std::f32::consts::PI.log2());
    irradiance.iter().map(|light| shown(tone_map.display_from_radiance(*light))).collect()
}

fn colors_of_charts(baked: &BakedScene) -> Vec<Color32> {
    let color = |chart: u32| if chart == NONE { NOTHING } else { shown(GpuRenderer::color_of_number(chart)) };
    charts_of_texels(&baked.lightmap).into_iter().map(color).collect()
}

fn colors_of_receivers(live: &LiveScene, camera: &Camera, colors: TexelColors) -> Vec<Color32> {
    let baked = &live.baked;
    let mut shown_colors = vec![NOTHING; (baked.lightmap.width * baked.lightmap.height) as usize];
    let color = texel_color(live, camera, colors);
    for (cluster, receiver, texel) in baked.receivers_with_texels() {
        shown_colors[texel as usize] = shown(color(cluster, receiver));
    }
    shown_colors
}

fn shown(color: Vec3) -> Color32 {
    let [r, g, b] = srgb8_from_linear(color);
    Color32::from_rgb(r, g, b)
}

/// Shows the page, and what is under the mouse.
pub fn show(ui: &mut Ui, state: &State, page: Option<&LightmapPage>, zoom: &mut f32, actions: &mut Actions) {
    ui.horizontal(|ui| {
        let mut colors = state.view.page_colors;
        ComboBox::from_id_salt("page colours").selected_text(colors.name()).show_ui(ui, |ui| {
            for choice in PageColors::all() {
                ui.selectable_value(&mut colors, choice, choice.name());
            }
        });
        if colors != state.view.page_colors {
            let view = ViewState { page_colors: colors, ..state.view.clone() };
            actions.push(Action::View(Box::new(view)));
        }
        ui.add(Slider::new(zoom, 0.25..=8.0).logarithmic(true).text("zoom"));
    });
    let Some(page) = page else { return };
    let size = page.texture.size_vec2() * *zoom;
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        ui.painter().image(page.texture.id(), rect, whole, Color32::WHITE);
        if let Some(at) = response.hover_pos() {
            let texel: Vec2 = ((at - rect.min) / *zoom).max(vec2(0.0, 0.0));
            if let Some(note) = page.note(texel.x as usize, texel.y as usize) {
                response.on_hover_text_at_pointer(note);
            }
        }
    });
}
