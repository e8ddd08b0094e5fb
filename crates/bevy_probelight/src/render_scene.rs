//! A scene's runtime on Bevy's device.

use std::sync::Arc;

use bevy::asset::AssetId;
use bevy::ecs::entity::EntityHashMap;
use bevy::image::Image;
use bevy::log::{warn, warn_once};
use bevy::render::render_resource::{Sampler, Texture, TextureView};
use bevy::render::texture::GpuImage;
use probelight_asset::BakedScene;
use probelight_runtime::gpu::frame_buffers::LIGHTMAP_FORMAT;
use probelight_runtime::gpu::{GpuError, GpuOptions, GpuRuntime};
use probelight_runtime::{FrameInput, LodSettings, ObjectId};
use probelight_scene::Object;

use crate::casters::Caster;
use crate::collect::{SceneFrame, SceneLight};
use crate::settings::ProbelightSettings;

/// What is left of bounced light when nothing is computed any more.
const SETTLED: f32 = 1e-4;

/// Bounces in a scene's first frame, so that it need not fade in.
const FIRST_BOUNCES: u32 = 6;

/// The runtime of a scene, and what it has still to do.
pub(crate) struct RenderScene {
    pub(crate) runtime: GpuRuntime,
    pub(crate) lightmap: AssetId<Image>,
    frame: SceneFrame,
    /// The runtime's objects, by their entities.
    objects: EntityHashMap<ObjectId>,
    settings: ProbelightSettings,
    /// The largest base colour.
    albedo: f32,
    /// Frames until light no longer changes.
    remaining: u32,
    /// Frames computed so far.
    pub(crate) computed: u64,
    /// Whether something was refused; said once.
    has_complained: bool,
}

impl RenderScene {
    /// Copies a scene to the device, with darkness in its lightmap.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: &Arc<BakedScene>,
        lightmap: AssetId<Image>,
    ) -> Result<Self, GpuError> {
        // Bevy reads the finest level only.
        let options = GpuOptions { reduces_lightmap: false, ..GpuOptions::default() };
        let runtime = GpuRuntime::new(device, queue, Arc::clone(baked), options)?;
        Ok(Self {
            runtime,
            lightmap,
            frame: SceneFrame::default(),
            objects: EntityHashMap::default(),
            settings: ProbelightSettings::default(),
            albedo: 1.0,
            remaining: 0,
            computed: 0,
            has_complained: false,
        })
    }

    /// Takes other lights and colours.
    pub(crate) fn set_light(&mut self, light: &SceneLight) {
        let SceneLight { lighting, colors } = light;
        let mut result = self.runtime.set_lighting(lighting.clone());
        for (material, colors) in colors.iter().enumerate() {
            let set = self.runtime.set_base_color(material, colors.base_color);
            let set = set.and_then(|()| self.runtime.set_emission(material, colors.emission));
            result = result.and(set);
        }
        self.complain(result);
        self.albedo = colors.iter().map(|c| c.base_color.max_element()).fold(0.0, f32::max);
        self.remaining = frames_to_settle(self.albedo);
    }

    /// Takes another view, and other places of movers and shadow casters.
    pub(crate) fn set_frame(&mut self, frame: &SceneFrame) {
        let (boxes_moved, view_moved) = (frame.boxes != self.frame.boxes, frame.view != self.frame.view);
        let view_counts = self.settings.lod != LodSettings::default() || self.settings.budget.is_some();
        if boxes_moved || (view_moved && view_counts) {
            self.wake();
        }
        if frame.casters != self.frame.casters {
            self.move_objects(&frame.casters);
            self.remaining = frames_to_settle(self.albedo);
        }
        self.frame = frame.clone();
    }

    /// Makes the runtime's objects those that cast shadows now.
    fn move_objects(&mut self, casters: &[Caster]) {
        let Self { runtime, objects, frame, .. } = self;
        for before in &frame.casters {
            let stays =
                casters.iter().any(|c| c.entity == before.entity && Arc::ptr_eq(&c.model, &before.model));
            if let Some(object) = (!stays).then(|| objects.remove(&before.entity)).flatten() {
                // It is known, so it can be taken out.
                let _removed = runtime.objects_mut().remove(object);
            }
        }
        for Caster { entity, model, placement } in casters {
            let moved = match objects.get(entity) {
                Some(object) => runtime.objects_mut().place(*object, *placement).map_err(|e| e.to_string()),
                None => Object::new(Arc::clone(model), *placement).map_err(|e| e.to_string()).map(|object| {
                    objects.insert(*entity, runtime.objects_mut().insert(object));
                }),
            };
            if let Err(reason) = moved {
                warn_once!("{entity} casts no shadow into bounced light: {reason}");
            }
        }
    }

    /// Takes other settings.
    pub(crate) fn set_settings(&mut self, settings: &ProbelightSettings) {
        if self.settings == *settings {
            return;
        }
        if self.settings.lod != settings.lod {
            let result = self.runtime.set_lod(settings.lod.clone());
            self.complain(result);
        }
        self.settings = settings.clone();
        self.wake();
    }

    /// What became visible or near may not have been up to date, and lights the rest.
    fn wake(&mut self) {
        let counts_all = self.settings.lod == LodSettings::default() && self.settings.budget.is_none();
        let frames = if counts_all { 1 } else { frames_to_settle(self.albedo) };
        self.remaining = self.remaining.max(frames);
    }

    /// Computes a frame, if light may still change.
    pub(crate) fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if self.remaining == 0 {
            return;
        }
        self.remaining -= 1;
        self.computed += 1;
        let SceneFrame { view, boxes, .. } = &self.frame;
        let input = FrameInput {
            view: *view,
            active_boxes: boxes,
            budget: self.settings.budget,
            ..FrameInput::default()
        };
        // Where levels of detail let something wait, each frame needs a submission of its own.
        let can_repeat = self.computed == 1 && self.settings == ProbelightSettings::default();
        for _ in 0..if can_repeat { FIRST_BOUNCES } else { 1 } {
            self.runtime.encode(&input, encoder);
        }
    }

    /// Whether [`encode`](Self::encode) would do nothing.
    pub(crate) fn is_settled(&self) -> bool {
        self.remaining == 0
    }

    /// The lightmap as Bevy keeps images.
    pub(crate) fn gpu_image(&self, device: &wgpu::Device) -> GpuImage {
        let buffers = self.runtime.buffers();
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("lightmap"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        GpuImage {
            texture: Texture::from(buffers.lightmap.clone()),
            texture_view: TextureView::from(buffers.lightmap_view.clone()),
            sampler: Sampler::from(sampler),
            texture_descriptor: wgpu::TextureDescriptor {
                label: Some("irradiance lightmap"),
                size: buffers.lightmap.size(),
                mip_level_count: buffers.lightmap.mip_level_count(),
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: LIGHTMAP_FORMAT,
                usage: buffers.lightmap.usage(),
                view_formats: &[],
            },
            texture_view_descriptor: None,
            had_data: true,
        }
    }

    fn complain(&mut self, result: Result<(), GpuError>) {
        if let Err(reason) = result
            && !std::mem::replace(&mut self.has_complained, true)
        {
            warn!("light of a baked scene stays as it was: {reason}");
        }
    }
}

/// Bounces after which nothing is left that could be seen, where surfaces reflect at most that share.
fn frames_to_settle(albedo: f32) -> u32 {
    let albedo = albedo.clamp(0.1, 0.95);
    // One more for the light that is not reflected yet, one for what waits for the frame after.
    (SETTLED.ln() / albedo.ln()).ceil() as u32 + 2
}

/// What shaders of a frame must be able to bind.
const STORAGE_BUFFERS: u32 = 8;

/// Whether a device can run frames at all; says so if not.
pub(crate) fn can_run(device: &wgpu::Device) -> bool {
    let limits = device.limits();
    let can_run = limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
        && limits.max_compute_invocations_per_workgroup >= 256
        && limits.max_bind_groups >= 4;
    if !can_run {
        warn!("baked scenes are not lit: the GPU, or how it was opened, lacks WebGPU's default limits");
    }
    can_run
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brighter_rooms_take_longer_to_settle() {
        let [dark, white, beyond] = [0.2, 0.9, 1.5].map(frames_to_settle);
        assert!(dark < white && white < beyond && beyond < 200, "{dark} {white} {beyond}");
        assert!(0.9f32.powi(white as i32) < SETTLED);
    }
}
