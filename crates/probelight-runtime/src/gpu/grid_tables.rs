//! The grid in free space as shaders read it: `grid.wgsl`.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, CosineReading, GridBasisKind, GridBlock, MAX_GRID_ROWS, NONE};
use probelight_math::glam::UVec3;

use super::bindings::{STORAGE, UNIFORM, bind, layout};
use super::device::GpuError;
use super::storage::Storage;
use crate::emissive_discs::MOST_DISCS;
use crate::irradiance_grid::OFF_SURFACE;
use crate::{EmissiveDisc, GridPlaces, ObjectSphere};

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
    pub(super) sphere_count: u32,               //       60
    pub(super) cell_blocks: [u32; 4],           //       64
    pub(super) polynomial: [f32; 4],            //       80
    pub(super) axes: [[f32; 4]; MAX_GRID_ROWS], //       96
}

/// `GridBlock` in `grid.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GridBlockRecord {
    pub(super) present: [u32; 2], //        0
    pub(super) first: u32,        //        8
    pub(super) level: u32,        //       12
    pub(super) nearest: u32,      //       16
    pub(super) padding: u32,      //       20
}

pub(super) const GRID_SH2: u32 = 0;
pub(super) const GRID_AXES: u32 = 1;
pub(super) const GRID_COSINES: u32 = 2;

/// `EmissiveDiscs` in `object_spheres.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct DiscsRecord {
    pub(super) discs: [EmissiveDisc; MOST_DISCS], //        0
    pub(super) count: u32,                        //      768
    pub(super) padding: [u32; 3],                 //      772
}

/// Where the grid's vertices are and what divides them, the spheres in place of objects, and the discs in place of emissive
/// surfaces; the light itself is that of the receivers.
#[derive(Debug)]
pub struct GridTables {
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    /// In the order of their bindings; spheres and discs last.
    buffers: [wgpu::Buffer; 8],
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
        let buffers = [
            storage.uniform("grid", &grid_record(baked)),
            storage.array("blocks of the grid", &block_records(baked))?,
            storage.array("cells of the grid", &baked.grid_cells)?,
            storage.array("planes of the grid", &baked.grid_planes)?,
            storage.array("receivers of the grid", &baked.grid_receivers)?,
            irradiance.clone(),
            storage.array("spheres of objects", &[] as &[ObjectSphere])?,
            storage.uniform("discs that emit", &DiscsRecord::zeroed()),
        ];
        let stages = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let types = [UNIFORM, STORAGE, STORAGE, STORAGE, STORAGE, STORAGE, STORAGE, UNIFORM];
        let layout = layout(device, "grid", types.map(|ty| (ty, stages)));
        let bind_group = bind_tables(device, &layout, &buffers);
        Ok(Self { layout, bind_group, buffers })
    }

    /// Takes other spheres in place of objects.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if shaders could not bind so many; then they stay as they were.
    pub fn set_spheres(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        spheres: &[ObjectSphere],
    ) -> Result<(), GpuError> {
        let [.., buffer, _discs] = &mut self.buffers;
        let bytes: &[u8] = bytemuck::cast_slice(spheres);
        if buffer.size() < bytes.len() as u64 {
            let most = bytes.len().next_power_of_two() as u64;
            *buffer = Storage::new(device, queue).zeros("spheres of objects", most)?;
            self.bind_group = bind_tables(device, &self.layout, &self.buffers);
        }
        let [grid, .., buffer, _discs] = &self.buffers;
        queue.write_buffer(buffer, 0, bytes);
        let count = spheres.len() as u32;
        queue.write_buffer(grid, offset_of!(GridRecord, sphere_count) as u64, bytemuck::bytes_of(&count));
        Ok(())
    }

    /// Takes emissive surfaces as they shine now.
    pub fn set_discs(&self, queue: &wgpu::Queue, discs: &[EmissiveDisc]) {
        let mut record = DiscsRecord { count: discs.len() as u32, ..DiscsRecord::zeroed() };
        record.discs[..discs.len()].copy_from_slice(discs);
        let [.., buffer] = &self.buffers;
        queue.write_buffer(buffer, 0, bytemuck::bytes_of(&record));
    }

    /// Layout of [`bind_group`](Self::bind_group): group 3 of shaders with [`super::shaders::GRID`] and
    /// [`super::shaders::OBJECT_SPHERES`].
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// What the first six bindings of the [bind group](Self::bind_group) are, in their order, for hosts whose materials have
    /// bind groups of their own: a uniform buffer, then storage buffers that are read. They stay the same for the life of the
    /// tables.
    pub fn grid_buffers(&self) -> &[wgpu::Buffer] {
        let [grid @ .., _spheres, _discs] = &self.buffers;
        grid
    }

    /// The grid for shaders.
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }
}

fn bind_tables(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[wgpu::Buffer],
) -> wgpu::BindGroup {
    bind(device, "grid", layout, buffers.iter().map(wgpu::Buffer::as_entire_binding))
}

/// Blocks of vertices, then those of cells, with as many for a grid without walls.
fn block_records(baked: &BakedScene) -> Vec<GridBlockRecord> {
    let record = |block: &GridBlock, nearest: u32| GridBlockRecord {
        present: block.present,
        first: block.first,
        level: block.level,
        nearest,
        padding: 0,
    };
    let places = GridPlaces::new(baked);
    let of_vertices =
        baked.grid_blocks.iter().zip(places.as_slice()).map(|(block, nearest)| record(block, *nearest));
    let cells = baked.grid.first_cell_block(baked.grid.levels);
    let none = GridBlock::default();
    let of_cells = (0..cells).map(|index| record(baked.grid_cell_blocks.get(index).unwrap_or(&none), NONE));
    of_vertices.chain(of_cells).collect()
}

fn grid_record(baked: &BakedScene) -> GridRecord {
    let (grid, basis) = (&baked.grid, baked.settings.grid_basis);
    if !baked.has_grid() {
        return GridRecord::zeroed();
    }
    let (reading, axes) = (basis.cosine_reading(), basis.light_axes());
    let CosineReading { polynomial: [a, b, c], shares } = reading.unwrap_or_default();
    GridRecord {
        origin: grid.origin.to_array(),
        rows: basis.rows() as u32,
        last: grid.position(grid.counts - UVec3::ONE).to_array(),
        kind: match (basis.kind, reading) {
            (GridBasisKind::Sh2, _) => GRID_SH2,
            (_, Some(_)) => GRID_COSINES,
            (_, None) => GRID_AXES,
        },
        spacing: grid.spacing.to_array(),
        off_surface: OFF_SURFACE * grid.spacing.min_element(),
        counts: grid.counts.to_array(),
        sphere_count: 0,
        cell_blocks: cell_blocks(baked),
        polynomial: [a, b, c, 0.0],
        axes: std::array::from_fn(|row| axes[row].extend(shares[row]).to_array()),
    }
}

/// Where each level's cells begin among the blocks, and the number of levels.
fn cell_blocks(baked: &BakedScene) -> [u32; 4] {
    let [a, b, c] = [0, 1, 2].map(|level| {
        let level = baked.grid.levels.min(level);
        (baked.grid_blocks.len() + baked.grid.first_cell_block(level)) as u32
    });
    [a, b, c, baked.grid.levels]
}
