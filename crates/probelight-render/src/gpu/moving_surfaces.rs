//! What the models of objects look like.

use std::sync::Arc;

use probelight_runtime::SurfaceColors;
use probelight_runtime::gpu::device::checked;
use probelight_runtime::gpu::{GpuError, MovingGeometry, MovingModel, SceneGeometry};
use probelight_scene::{Scene, Texture};

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
    /// Copies the looks of models that are new, and forgets those of models that are gone; poses of one model share its
    /// materials. Models that the device cannot hold are left out.
    pub(super) fn update(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, moving: &MovingGeometry) {
        let is_needed =
            |known: &ModelSurfaces| moving.models.iter().any(|it| Arc::ptr_eq(&it.model, &known.model));
        let (needed, mut left): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.models).into_iter().partition(is_needed);
        self.models = needed;
        for MovingModel { model, geometry, .. } in &moving.models {
            if self.of(model).is_some() {
                continue;
            }
            let materials = left.iter().position(|known| looks_alike(&known.model, model));
            let materials = materials.map(|index| left.swap_remove(index).materials);
            self.models.extend(ModelSurfaces::new(device, queue, model, geometry, materials));
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
        materials: Option<Materials>,
    ) -> Result<Self, GpuError> {
        checked(device, "the surfaces of an object", || {
            let materials = materials.unwrap_or_else(|| {
                let mut materials = Materials::new(device, queue, model);
                materials.set_colors(queue, model, &SurfaceColors::of(model));
                materials
            });
            let attributes = surface_attributes::vertex_buffer(device, model, geometry)?;
            Ok(Self { model: Arc::clone(model), attributes, materials })
        })
    }
}

/// Whether two models have the same materials and images.
fn looks_alike(a: &Scene, b: &Scene) -> bool {
    let same_image = |(a, b): (&Texture, &Texture)| Arc::ptr_eq(&a.rgba8, &b.rgba8);
    a.materials == b.materials
        && a.textures.len() == b.textures.len()
        && a.textures.iter().zip(&b.textures).all(same_image)
}
