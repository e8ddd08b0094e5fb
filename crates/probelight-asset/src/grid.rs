//! Irradiance in free space: a sparse grid of vertices whose values are receivers of the transport, too (\[SED\] §4).
//!
//! The grid's vertices lie `spacing` apart and are stored in blocks of 4³; a block knows which of its vertices have
//! light. Each vertex has the [rows](crate::GridBasis::rows) of the settings' basis.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{UVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::{BakedParts, NONE};

/// Vertices along each edge of a block.
pub const BLOCK_EDGE: u32 = 4;

/// Where the vertices of a grid lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GridLayout {
    /// World position of the first vertex, metres.
    pub origin: Vec3,
    /// Distance between neighbours along each axis, metres.
    pub spacing: Vec3,
    /// Vertices along each axis; zeros without a grid.
    pub counts: UVec3,
}

/// Which of 4 × 4 × 4 places of a grid have something of their own. Place (x, y, z) of a block is bit `x + 4 y + 16 z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridBlock {
    /// Which places: two halves of 64 bits, the lower first.
    pub present: [u32; 2],
    /// Number of the first of them; the others follow in the order of their bits.
    pub first: u32,
}

/// Walls in a cell of a grid: which of its corners light which part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridCell {
    /// Planes that divide the cell, indices into `grid_planes`; [`NONE`](crate::NONE) after the last.
    pub planes: [u32; CELL_PLANES],
    /// The corners that light each part of it: corner (x, y, z) is bit `x + 2 y + 4 z`. Bit i of a part's number tells
    /// whether it lies in front of plane i.
    pub corners: [u8; 1 << CELL_PLANES],
}

/// Most planes that divide a cell of a grid.
pub const CELL_PLANES: usize = 4;

/// A vertex of a grid that has light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridVertex {
    /// How far the place where it measures lies from its own, along each axis: in 255ths of the spacing.
    pub offset: [i8; 4],
}

impl GridLayout {
    /// Blocks along each axis.
    pub fn blocks(&self) -> UVec3 {
        (self.counts + (BLOCK_EDGE - 1)) / BLOCK_EDGE
    }

    /// World position of a vertex of the lattice, metres.
    pub fn position(&self, vertex: UVec3) -> Vec3 {
        self.origin + vertex.as_vec3() * self.spacing
    }

    /// Index of a vertex's block, and its bit there.
    pub fn place(&self, vertex: UVec3) -> (usize, u32) {
        let (block, within) = (vertex / BLOCK_EDGE, vertex % BLOCK_EDGE);
        let blocks = self.blocks();
        let index =
            block.x as usize + blocks.x as usize * (block.y as usize + blocks.y as usize * block.z as usize);
        (index, within.x + BLOCK_EDGE * (within.y + BLOCK_EDGE * within.z))
    }
}

impl GridBlock {
    /// Of the places that `mask` has, `first` being the number of the lowest.
    pub fn new(mask: u64, first: u32) -> Self {
        Self { present: [mask as u32, (mask >> 32) as u32], first }
    }

    /// Which places, as one number.
    pub fn mask(&self) -> u64 {
        u64::from(self.present[0]) | u64::from(self.present[1]) << 32
    }

    /// The number of what is at a place, if anything is.
    pub fn number(&self, bit: u32) -> Option<u32> {
        let mask = self.mask();
        let before = mask & ((1 << bit) - 1);
        (mask >> bit & 1 == 1).then(|| self.first + before.count_ones())
    }
}

impl GridVertex {
    /// Of a vertex that measures at an offset, in spacings; rounded.
    pub fn at(offset: Vec3) -> Self {
        let [x, y, z] = offset.to_array().map(|v| (v * 255.0).round().clamp(-127.0, 127.0) as i8);
        Self { offset: [x, y, z, 0] }
    }

    /// Where it measures from its own place, in spacings.
    pub fn offset(&self) -> Vec3 {
        let [x, y, z, _] = self.offset.map(|v| f32::from(v) / 255.0);
        Vec3::new(x, y, z)
    }
}

impl BakedParts {
    /// Whether there is light in free space.
    pub fn has_grid(&self) -> bool {
        !self.grid_vertices.is_empty()
    }

    /// Number of all receivers: those of the lightmap, and the grid's behind them.
    pub fn receiver_count(&self) -> usize {
        self.receiver_texels.len() + self.grid_receivers.len()
    }

    /// Number of the clusters that the lightmap's receivers lie in; the grid's follow.
    pub fn lightmap_clusters(&self) -> usize {
        self.clusters
            .partition_point(|cluster| (cluster.first_receiver as usize) < self.receiver_texels.len())
    }

    /// The valid vertex at a place of the lattice.
    pub fn grid_vertex(&self, vertex: UVec3) -> Option<u32> {
        let (block, bit) = self.grid.place(vertex);
        self.grid_blocks[block].number(bit)
    }

    /// The walls in the cell between a place of the lattice and the next ones along each axis.
    pub fn grid_cell(&self, cell: UVec3) -> Option<&GridCell> {
        Some(&self.grid_cells[self.grid_cell_number(cell)? as usize])
    }

    /// The index of a cell's walls in `grid_cells`.
    pub fn grid_cell_number(&self, cell: UVec3) -> Option<u32> {
        let (block, bit) = self.grid.place(cell);
        self.grid_cell_blocks.get(block)?.number(bit)
    }

    /// The corners that light a world position by way of a cell, as [`GridCell::corners`] has them.
    pub fn corners_lighting(&self, cell: &GridCell, position: Vec3) -> u8 {
        let planes = cell.planes.iter().take_while(|plane| **plane != NONE);
        let is_in_front = |plane: &u32| position.extend(1.0).dot(self.grid_planes[*plane as usize]) > 0.0;
        let part: usize = planes.enumerate().map(|(i, plane)| usize::from(is_in_front(plane)) << i).sum();
        cell.corners[part]
    }

    /// The receivers that hold a vertex's rows.
    pub fn vertex_receivers(&self, vertex: u32) -> &[u32] {
        let rows = self.settings.grid_basis.rows();
        &self.grid_receivers[vertex as usize * rows..][..rows]
    }
}
