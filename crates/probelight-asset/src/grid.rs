//! Irradiance in free space: a sparse grid of vertices whose values are receivers of the transport, too (\[SED\] §4).
//!
//! The grid's vertices lie `spacing` apart and are stored in blocks of 4³; a block knows which of its vertices have
//! light. Each vertex has the [rows](crate::GridBasis::rows) of the settings' basis.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{UVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::BakedParts;

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

/// 4 × 4 × 4 vertices of a grid. Vertex (x, y, z) of a block is bit `x + 4 y + 16 z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridBlock {
    /// Which of its vertices have light: two halves of 64 bits, the lower first.
    pub valid: [u32; 2],
    /// Number of its first valid vertex; the others follow in the order of their bits.
    pub first_vertex: u32,
}

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
    /// Which vertices have light, as one number.
    pub fn mask(&self) -> u64 {
        u64::from(self.valid[0]) | u64::from(self.valid[1]) << 32
    }

    /// The number of the vertex at a bit, if it has light.
    pub fn vertex(&self, bit: u32) -> Option<u32> {
        let mask = self.mask();
        let before = mask & ((1 << bit) - 1);
        (mask >> bit & 1 == 1).then(|| self.first_vertex + before.count_ones())
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
        self.grid_blocks[block].vertex(bit)
    }

    /// The receivers that hold a vertex's rows.
    pub fn vertex_receivers(&self, vertex: u32) -> &[u32] {
        let rows = self.settings.grid_basis.rows();
        &self.grid_receivers[vertex as usize * rows..][..rows]
    }
}
