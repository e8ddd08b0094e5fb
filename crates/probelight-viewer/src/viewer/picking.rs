//! What is at a place.

use std::sync::Arc;
use std::sync::mpsc::channel;

use half::f16;
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::gpu::GpuError;
use probelight_runtime::gpu::readback::read_texture_async;
use probelight_trace::direct_irradiance;

use super::{PickAnswers, Viewer};
use crate::panels::lightmap::LightmapPage;
use crate::panels::picked::PickedLight;
use crate::platform;
use crate::scene::live_scene::{LiveScene, audible};
use crate::scene::pending::{Pending, take_ready};
use crate::scene::pick::{Picked, pick, reference_at};
use crate::state::{Action, Selection, State};

impl Viewer {
    pub(super) fn picked_place(&self) -> Option<Vec3> {
        match &self.picked.as_ref()?.picked {
            Picked::Nothing => None,
            Picked::Object(_, place) => Some(*place),
            Picked::Surface(surface) => Some(surface.position),
        }
    }

    /// Finds out what is at a pixel, and asks for its light.
    pub(super) fn pick(&mut self, pixel: Vec2) {
        let Some(live) = &self.live else { return };
        let picked = pick(live, &self.state.view.camera, pixel);
        let view = &self.state.view;
        let lighting = audible(&self.state.document, &view.muted, view.time);
        let mut direct = Vec::new();
        self.pick_answers = PickAnswers::default();
        if let Picked::Surface(surface) = &picked {
            let place = (surface.position, surface.normal);
            let of = |light| {
                direct_irradiance(
                    &*live.tracer,
                    std::slice::from_ref(light),
                    surface.position,
                    surface.normal,
                )
            };
            direct = lighting.lights.iter().map(of).collect();
            let (sender, receiver) = channel();
            let (tracer, colors) = (Arc::clone(&live.tracer), self.state.document.materials.clone());
            let context = self.context.clone();
            platform::spawn(move || async move {
                platform::breathe().await;
                // Nobody listens if another place was picked.
                let _ = sender.send(reference_at(&tracer, &colors, lighting, place));
                context.request_repaint();
            });
            self.pick_answers.reference = Some(receiver);
            if surface.light.is_some() {
                let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
                let texture = live.runtime.buffers().lightmap.clone();
                self.pick_answers.texel =
                    Some(Pending::new(async move { read_texture_async(&device, &queue, &texture).await }));
            }
        }
        if let Picked::Object(item, _) = picked {
            self.state.act(Action::Select(Selection::Object(item)));
        }
        let is_tracing = self.pick_answers.reference.is_some();
        self.picked = Some(PickedLight { picked, direct, lightmap: None, reference: None, is_tracing });
        self.show_picked();
    }

    /// Reads the lightmap for its page if another picture was drawn since.
    pub(super) fn read_lightmap(&mut self) {
        let Some(live) = self.live.as_ref().filter(|_| self.state.view.panels.lightmap) else {
            return self.lightmap = None;
        };
        if self.lightmap_answer.is_some() || (self.lightmap.is_some() && self.lightmap_draws == self.draws) {
            return;
        }
        self.lightmap_draws = self.draws;
        let (device, queue) = (self.gpu.device.clone(), self.gpu.queue.clone());
        let texture = live.runtime.buffers().lightmap.clone();
        let read = async move { read_texture_async(&device, &queue, &texture).await };
        self.lightmap_answer = Some(Pending::new(read));
    }

    /// Takes what the GPU and the path tracer have said meanwhile.
    pub(crate) fn take_answers(&mut self) {
        if let Some(Ok(bytes)) = take_ready(&mut self.lightmap_answer)
            && let Some(live) = &self.live
        {
            let irradiance = bytes.chunks_exact(8).map(texel).collect();
            let State { view, shown_ev, .. } = &self.state;
            self.lightmap = Some(LightmapPage::new(&self.context, live, irradiance, view, *shown_ev));
        }
        let Some(light) = &mut self.picked else { return };
        if let Some(answer) = take_ready(&mut self.pick_answers.texel) {
            light.lightmap = lightmap_at(light, self.live.as_ref(), answer);
        }
        if let Some(Ok(reference)) = self.pick_answers.reference.as_ref().map(|receiver| receiver.try_recv())
        {
            light.reference = reference;
            light.is_tracing = false;
            self.pick_answers.reference = None;
        }
    }
}

/// Irradiance of the lightmap at the picked texel.
fn lightmap_at(
    light: &PickedLight,
    live: Option<&LiveScene>,
    answer: Result<Vec<u8>, GpuError>,
) -> Option<Vec3> {
    let Picked::Surface(surface) = &light.picked else { return None };
    let [x, y] = surface.light.as_ref()?.texel;
    let index = y as usize * live?.baked.lightmap.width as usize + x as usize;
    answer.ok()?.chunks_exact(8).nth(index).map(texel)
}

/// Red, green and blue of a texel of half floats.
fn texel(bytes: &[u8]) -> Vec3 {
    Vec3::from([0, 1, 2].map(|c| f16::from_le_bytes([bytes[2 * c], bytes[2 * c + 1]]).to_f32()))
}
