//! Objects on the GPU: the triangles of their models, and where each of them is.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Mat3;
use probelight_scene::{Object, Scene};
use wgpu::BufferUsages;

use super::device::GpuError;
use super::scene_geometry::SceneGeometry;

/// Where an object is: `Placement` in `placements.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PlacementRecord {
    /// Rows of the matrix from the model's space to the world.
    pub(super) rows: [[f32; 4]; 3], // 0
    /// Which of the objects it is.
    pub(super) number: u32, //        48
    /// [`Object::light_offset`].
    pub(super) light_offset: f32, //  52
    /// Fills the record.
    pub(super) unused: [u32; 2], //   56
}

impl PlacementRecord {
    fn new(object: &Object, number: u32) -> Self {
        let placement = object.placement();
        let linear = (Mat3::from_quat(placement.rotation) * placement.scale).transpose();
        let row = |axis: usize| linear.col(axis).extend(placement.translation[axis]).to_array();
        Self { rows: [row(0), row(1), row(2)], number, light_offset: object.light_offset(), unused: [0; 2] }
    }
}

/// A model, and which of the placements are those of its objects.
#[derive(Debug)]
pub struct MovingModel {
    /// What it looks like.
    pub model: Arc<Scene>,
    /// Its triangles, in its own space.
    pub geometry: SceneGeometry,
    /// Its objects.
    pub objects: Range<u32>,
}

/// All objects of a scene in the memory of a GPU.
#[derive(Debug)]
pub struct MovingGeometry {
    /// Models that have objects.
    pub models: Vec<MovingModel>,
    /// Storage buffer: a record for each object, in the order of models; at least one. Another one when objects come.
    pub placements: wgpu::Buffer,
    /// Number of the objects.
    pub count: u32,
}

impl MovingGeometry {
    /// No objects.
    pub fn new(device: &wgpu::Device) -> Self {
        Self { models: Vec::new(), placements: placement_buffer(device, 1), count: 0 }
    }

    /// Takes over the present objects. Objects with models that the device cannot hold are left out.
    ///
    /// # Errors
    /// Why the first of them was left out: [`GpuError::TooLarge`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        objects: &[Object],
    ) -> Result<(), GpuError> {
        let mut known = std::mem::take(&mut self.models);
        let mut records: Vec<PlacementRecord> = Vec::with_capacity(objects.len());
        let mut refused = Ok(());
        let mut left: Vec<(u32, &Object)> = (0..).zip(objects).collect();
        while let Some((_, first)) = left.first() {
            let model = Arc::clone(first.model());
            let (same, others): (Vec<_>, Vec<_>) =
                left.into_iter().partition(|(_, object)| Arc::ptr_eq(object.model(), &model));
            left = others;
            let geometry = match known.iter().position(|known| Arc::ptr_eq(&known.model, &model)) {
                Some(index) => Ok(known.swap_remove(index).geometry),
                None => SceneGeometry::new(device, queue, &model),
            };
            match geometry {
                Ok(geometry) => {
                    let first = records.len() as u32;
                    let record = |(number, object): &(u32, &Object)| PlacementRecord::new(object, *number);
                    records.extend(same.iter().map(record));
                    self.models.push(MovingModel { model, geometry, objects: first..records.len() as u32 });
                }
                Err(error) => refused = refused.and(Err(error)),
            }
        }
        if (self.placements.size() as usize) < size_of_val(&records[..]) {
            self.placements = placement_buffer(device, records.len().next_power_of_two());
        }
        queue.write_buffer(&self.placements, 0, bytemuck::cast_slice(&records));
        self.count = records.len() as u32;
        refused
    }
}

fn placement_buffer(device: &wgpu::Device, objects: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("placements of objects"),
        size: (objects * size_of::<PlacementRecord>()) as u64,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::{Quat, Vec3, Vec4};
    use probelight_scene::Placement;

    use super::*;

    #[test]
    fn records_place_points_as_placements_do() {
        let placement = Placement {
            translation: Vec3::new(1.0, -2.0, 3.0),
            rotation: Quat::from_euler(probelight_math::glam::EulerRot::XYZ, 0.4, 1.3, -0.8),
            scale: 2.5,
        };
        let model = Scene {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Scene::default()
        };
        let object = Object::new(Arc::new(model), placement).unwrap();
        let (point, record) = (Vec3::new(0.3, 0.7, -0.2), PlacementRecord::new(&object, 0));
        let placed = Vec3::from(record.rows.map(|row| Vec4::from(row).dot(point.extend(1.0))));
        assert!(placed.abs_diff_eq(placement.point(point), 1e-5), "{placed}");
    }
}
