//! What the models of objects look like.

use std::sync::Arc;

use probelight_runtime::SurfaceColors;
use probelight_runtime::gpu::device::checked;
use probelight_runtime::gpu::{GpuError, MovingGeometry, SceneGeometry};
use probelight_scene::Scene;

use super::materials::Materials;
use super::surface_attributes;

/// The looks of all models that were drawn last.
#[derive(Debug, Default)]
pub(super) struct MovingSurfaces {
    models: Vec<ModelSurfaces>,
}

/// The looks of a model.
#[derive(Debug)]
pub(super) struct ModelSurfaces {
    model: Arc<Scene>,
    pub(super) attributes: wgpu::Buffer,
    pub(super) materials: Materials,
}

impl MovingSurfaces {
    /// Copies the looks of models that are new, and forgets those of models that are gone. Models that the device cannot hold
    /// are left out.
    pub(super) fn update(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, moving: &MovingGeometry) {
        let is_needed =
            |known: &ModelSurfaces| moving.models.iter().any(|it| Arc::ptr_eq(&it.model, &known.model));
        self.models.retain(is_needed);
        for model in &moving.models {
            if self.of(&model.model).is_none() {
                self.models.extend(ModelSurfaces::new(device, queue, &model.model, &model.geometry));
            }
        }
    }

    /// The looks of a model.
    pub(super) fn of(&self, model: &Arc<Scene>) -> Option<&ModelSurfaces> {
        self.models.iter().find(|known| Arc::ptr_eq(&known.model, model))
    }
}

impl ModelSurfaces {
    fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        model: &Arc<Scene>,
        geometry: &SceneGeometry,
    ) -> Result<Self, GpuError> {
        checked(device, "the surfaces of an object", || {
            let mut materials = Materials::new(device, queue, model);
            materials.set_colors(queue, model, &SurfaceColors::of(model));
            let attributes = surface_attributes::vertex_buffer(device, model, geometry)?;
            Ok(Self { model: Arc::clone(model), attributes, materials })
        })
    }
}
