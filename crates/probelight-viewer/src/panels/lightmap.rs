//! The lightmap as a picture.

use eframe::egui::{
    Color32, ColorImage, Context, ScrollArea, Sense, TextureHandle, TextureOptions, Ui, Vec2, vec2,
};
use probelight_math::glam::Vec3;
use probelight_render::ToneMap;

use super::Actions;
use crate::state::{Action, Request};

/// A lightmap that was read from the GPU.
pub struct LightmapPage {
    size: [usize; 2],
    irradiance: Vec<Vec3>,
    texture: TextureHandle,
}

impl LightmapPage {
    /// Of texels in W/m², rows from the top, shown at an exposure.
    pub fn new(context: &Context, width: usize, irradiance: Vec<Vec3>, ev: f32) -> Self {
        let tone_map = ToneMap::of_ev(ev - std::f32::consts::PI.log2());
        let color = |irradiance: &Vec3| {
            let shown = tone_map.display_from_radiance(*irradiance);
            let [r, g, b] = probelight_math::color::srgb8_from_linear(shown);
            Color32::from_rgb(r, g, b)
        };
        let size = [width, irradiance.len() / width.max(1)];
        let image = ColorImage::new(size, irradiance.iter().map(color).collect());
        let texture = context.load_texture("lightmap", image, TextureOptions::NEAREST);
        Self { size, irradiance, texture }
    }
}

/// Shows the page, and what is under the mouse.
pub fn show(ui: &mut Ui, page: Option<&LightmapPage>, zoom: &mut f32, actions: &mut Actions) {
    ui.horizontal(|ui| {
        if ui.button("read again").clicked() {
            actions.push(Action::Request(Request::ReadLightmap));
        }
        ui.add(eframe::egui::Slider::new(zoom, 0.25..=8.0).logarithmic(true).text("zoom"));
    });
    let Some(page) = page else {
        actions.push(Action::Request(Request::ReadLightmap));
        return;
    };
    let size = vec2(page.size[0] as f32, page.size[1] as f32) * *zoom;
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let whole = eframe::egui::Rect::from_min_max(eframe::egui::Pos2::ZERO, eframe::egui::pos2(1.0, 1.0));
        ui.painter().image(page.texture.id(), rect, whole, Color32::WHITE);
        if let Some(at) = response.hover_pos() {
            let texel: Vec2 = (at - rect.min) / *zoom;
            let [x, y] = [texel.x as usize, texel.y as usize];
            if let Some(irradiance) = page.irradiance.get(y * page.size[0] + x) {
                let v = irradiance;
                response.on_hover_text(format!("texel {x}, {y}: {:.4} {:.4} {:.4} W/m²", v.x, v.y, v.z));
            }
        }
    });
}
