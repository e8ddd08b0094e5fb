//! What moves through a scene on the GPU.

use super::{GpuError, GpuRuntime, GridTables, MovingGeometry};
use crate::Objects;

impl GpuRuntime {
    /// What moves through the scene.
    pub fn objects(&self) -> &Objects {
        &self.state.objects
    }

    /// What moves through the scene, to change it from the next frame on.
    pub fn objects_mut(&mut self) -> &mut Objects {
        &mut self.state.objects
    }

    /// Copies the present objects to the GPU. Frames do so by themselves, and leave out objects with models that the device
    /// cannot hold.
    ///
    /// # Errors
    /// If there are such objects.
    pub fn upload_objects(&mut self) -> Result<(), GpuError> {
        if !self.state.objects.take_stale() {
            return Ok(());
        }
        self.moved = true;
        let Self { device, queue, state, .. } = self;
        let spheres = self.grid.set_spheres(device, queue, state.objects.spheres());
        self.moving.update(device, queue, state.objects.as_slice()).and(spheres)
    }

    /// The objects on the GPU, for renderers.
    pub fn moving(&self) -> &MovingGeometry {
        &self.moving
    }

    /// The grid in free space, for shaders that light objects.
    pub fn grid(&self) -> &GridTables {
        &self.grid
    }
}
