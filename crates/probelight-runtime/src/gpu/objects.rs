//! What moves through a scene on the GPU.

#[cfg(feature = "cpu")]
use std::sync::Arc;

#[cfg(feature = "cpu")]
use probelight_trace::Tracer;

use super::{GpuError, GpuRuntime, GridTables, MovingGeometry};
#[cfg(feature = "cpu")]
use crate::doors::Doors;
use crate::{EmissiveDisc, Objects};

impl GpuRuntime {
    /// What moves through the scene.
    pub fn objects(&self) -> &Objects {
        &self.state.objects
    }

    /// What moves through the scene, to change it from the next frame on.
    pub fn objects_mut(&mut self) -> &mut Objects {
        &mut self.state.objects
    }

    /// As [`Runtime::emissive_discs`](crate::Runtime::emissive_discs).
    pub fn emissive_discs(&self) -> &[EmissiveDisc] {
        self.state.discs.as_slice()
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
        #[cfg(feature = "cpu")]
        self.follow_doors();
        let Self { device, queue, state, .. } = self;
        let spheres = self.grid.set_spheres(device, queue, state.objects.spheres());
        self.moving.update(device, queue, state.objects.as_slice()).and(spheres)
    }

    /// Opens and shuts ways for light where doors are now.
    #[cfg(feature = "cpu")]
    fn follow_doors(&mut self) {
        let Self { queue, baked, state, doors, .. } = self;
        if doors.is_none() && state.objects.doors().next().is_none() {
            return;
        }
        let (tracer, doors) = doors.get_or_insert_with(|| {
            let tracer = Tracer::new(Arc::clone(&baked.scene));
            let doors = Box::new(Doors::new(baked, &tracer));
            (tracer, doors)
        });
        if !doors.follow(baked, tracer, &state.objects) {
            return;
        }
        let (ways, (probes, clusters)) = (doors.ways(), doors.changed());
        self.stages.relight_probes.set_rays(queue, baked, ways, probes);
        for shard in &self.shards {
            shard.set_exponents(queue, baked, ways.column_exponents, clusters);
        }
        self.forget_work();
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
