//! The grid in free space as shaders read it: `grid.wgsl`.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, GridBasisKind, GridLobe, MAX_GRID_ROWS};
use probelight_math::glam::{UVec3, Vec3};

use super::device::GpuError;
use super::storage::Storage;
use crate::GridPlaces;
use crate::irradiance_grid::OFF_SURFACE;

/// `Grid` in `grid.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GridRecord {
    pub(super) origin: [f32; 3],                //        0
    pub(super) rows: u32,                       //       12
    pub(super) last: [f32; 3],                  //       16
    pub(super) kind: u32,                       //       28
    pub(super) spacing: [f32; 3],               //       32
    pub(super) off_surface: f32,                //       44
    pub(super) counts: [u32; 3],                //       48
    pub(super) unused: u32,                     //       60
    pub(super) axes: [[f32; 4]; MAX_GRID_ROWS], //       64
}

pub(super) const GRID_SH2: u32 = 0;
pub(super) const GRID_AXES: u32 = 1;
pub(super) const GRID_SIX_COSINES: u32 = 2;

/// Where the grid's vertices are and what divides them; the light itself is that of the receivers.
#[derive(Debug)]
pub struct GridTables {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
}

impl GridTables {
    /// Copies the grid of a baked scene; without one, the tables of none. `irradiance` is a storage buffer of three `f32` for
    /// each of the scene's receivers, W/m².
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if shaders could not bind the tables.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: &BakedScene,
        irradiance: &wgpu::Buffer,
    ) -> Result<Self, GpuError> {
        let storage = Storage::new(device, queue);
        let places = GridPlaces::new(baked);
        let buffers = [
            storage.uniform("grid", &grid_record(baked)),
            storage.array("places of the grid", places.as_slice())?,
            storage.array("cells of the grid", &baked.grid_cells)?,
            storage.array("planes of the grid", &baked.grid_planes)?,
            storage.array("receivers of the grid", &baked.grid_receivers)?,
            irradiance.clone(),
        ];
        let layout = layout(device);
        let entries: Vec<_> = (0..)
            .zip(&buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("grid"),
            layout: &layout,
            entries: &entries,
        });
        Ok(Self { layout, bind_group })
    }

    /// Layout of [`bind_group`](Self::bind_group): group 3 of shaders with [`super::shaders::GRID`].
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// The grid for shaders.
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }
}

fn grid_record(baked: &BakedScene) -> GridRecord {
    let (grid, basis) = (&baked.grid, baked.settings.grid_basis);
    if !baked.has_grid() {
        return GridRecord::zeroed();
    }
    let mut axes = [[0.0; 4]; MAX_GRID_ROWS];
    match basis.kind {
        GridBasisKind::Sh2 => {
            for (axis, direction) in axes[1..].iter_mut().zip([Vec3::Y, Vec3::Z, Vec3::X]) {
                *axis = direction.extend(0.0).to_array();
            }
        }
        _ => axes.iter_mut().zip(basis.axes()).for_each(|(axis, d)| *axis = d.extend(0.0).to_array()),
    }
    GridRecord {
        origin: grid.origin.to_array(),
        rows: basis.rows() as u32,
        last: grid.position(grid.counts - UVec3::ONE).to_array(),
        kind: match (basis.kind, basis.lobe) {
            (GridBasisKind::Sh2, _) => GRID_SH2,
            (GridBasisKind::Axes6, GridLobe::Cosine) => GRID_SIX_COSINES,
            _ => GRID_AXES,
        },
        spacing: grid.spacing.to_array(),
        off_surface: OFF_SURFACE * grid.spacing.min_element(),
        counts: grid.counts.to_array(),
        unused: 0,
        axes,
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let types = [wgpu::BufferBindingType::Uniform, storage, storage, storage, storage, storage];
    let entries: Vec<_> = (0..).zip(types).map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("grid"), entries: &entries })
}
