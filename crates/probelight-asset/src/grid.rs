//! Irradiance in free space: a sparse grid of vertices whose values are receivers of the transport, too (\[SED\] §4).
//!
//! The grid's places lie `spacing` apart, in blocks of 4³. A block has vertices at all of its places (level 0), at every
//! second or at every fourth along each axis (levels 1 and 2), and knows which of those have light. Each vertex has the
//! [rows](crate::GridBasis::rows) of the settings' basis.
//!
//! The cells of a level lie between its vertices, those of finer blocks among them. Where a cell of level 0 has no
//! vertex, as its block is coarser, light comes from the cell of level 1 around it, and so on.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{UVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::{BakedParts, NONE};

/// Places along each edge of a block.
pub const BLOCK_EDGE: u32 = 4;

/// Most levels of a grid.
pub const MAX_GRID_LEVELS: u32 = 3;

/// Where the vertices of a grid may lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GridLayout {
    /// World position of the first place, metres.
    pub origin: Vec3,
    /// Distance between neighbours along each axis, metres.
    pub spacing: Vec3,
    /// Places along each axis; zeros without a grid.
    pub counts: UVec3,
    /// How many levels its blocks have.
    pub levels: u32,
}

/// Which of 4 × 4 × 4 places of a grid have something of their own. Place (x, y, z) of a block is bit `x + 4 y + 16 z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridBlock {
    /// Which places: two halves of 64 bits, the lower first.
    pub present: [u32; 2],
    /// Number of the first of them; the others follow in the order of their bits.
    pub first: u32,
    /// Level of its vertices: they lie at multiples of 2 to the power of it. Of a block of cells, the cells' own.
    pub level: u32,
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

/// Where a vertex of a grid is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexPlace {
    /// Its number.
    pub vertex: u32,
    /// Its block, counted in blocks.
    pub block: UVec3,
    /// That of its block.
    pub level: u32,
    /// Its own place in the grid.
    pub place: UVec3,
    /// Where it measures in the world, metres.
    pub position: Vec3,
}

impl GridLayout {
    /// The places that blocks of a level, or of coarser ones, have: a grid of its own.
    pub fn at_level(&self, level: u32) -> Self {
        let cells = self.counts.saturating_sub(UVec3::ONE);
        let counts = if cells == UVec3::ZERO { self.counts } else { (cells >> level) + 1 };
        Self { spacing: self.spacing * (1 << level) as f32, counts, levels: 1, ..*self }
    }

    /// Blocks along each axis.
    pub fn blocks(&self) -> UVec3 {
        (self.counts + (BLOCK_EDGE - 1)) / BLOCK_EDGE
    }

    /// World position of a place, metres.
    pub fn position(&self, place: UVec3) -> Vec3 {
        self.origin + place.as_vec3() * self.spacing
    }

    /// Index of the block that a place lies in, and the place's bit there.
    pub fn place(&self, place: UVec3) -> (usize, u32) {
        let (block, within) = (place / BLOCK_EDGE, place % BLOCK_EDGE);
        (index_of(self.blocks(), block), index_of(UVec3::splat(BLOCK_EDGE), within) as u32)
    }

    /// Whether the block that a place lies in has vertices at all places of a level, as far as they have light.
    pub fn is_covered(&self, blocks: &[GridBlock], place: UVec3, level: u32) -> bool {
        blocks[self.place(place).0].level <= level
    }

    /// Whether light is read from a cell of a level, given the blocks of vertices: one of its corners is as fine as the
    /// level, and not all of what lies in it is finer. The cell is counted in the level's spacings.
    pub fn is_read(&self, blocks: &[GridBlock], level: u32, cell: UVec3) -> bool {
        let covers = |level: u32, place: UVec3| {
            let place = place << level;
            place.cmplt(self.counts).all() && self.is_covered(blocks, place, level)
        };
        let has_corner = places_of(UVec3::splat(2)).any(|corner| covers(level, cell + corner));
        let is_finer =
            || level > 0 && places_of(UVec3::splat(3)).all(|step| covers(level - 1, 2 * cell + step));
        has_corner && !is_finer()
    }

    /// Index of the first block of a level's cells; after the last level, their number.
    pub fn first_cell_block(&self, level: u32) -> usize {
        (0..level).map(|level| self.at_level(level).blocks().element_product() as usize).sum()
    }
}

/// The places of a grid of some size, x fastest.
pub fn places_of(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z)
        .flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z))))
}

/// The number of a place among [`places_of`] a size.
pub fn index_of(size: UVec3, place: UVec3) -> usize {
    place.x as usize + size.x as usize * (place.y as usize + size.y as usize * place.z as usize)
}

impl GridBlock {
    /// Of the places that `mask` has, `first` being the number of the lowest.
    pub fn new(mask: u64, first: u32, level: u32) -> Self {
        Self { present: [mask as u32, (mask >> 32) as u32], first, level }
    }

    /// Which places, as one number.
    pub fn mask(&self) -> u64 {
        u64::from(self.present[0]) | u64::from(self.present[1]) << 32
    }

    /// The places of blocks of a level, as one number.
    pub fn places(level: u32) -> u64 {
        let is_there = |bit: u32| [bit % 4, bit / 4 % 4, bit / 16].iter().all(|at| at % (1 << level) == 0);
        (0..64).filter(|bit| is_there(*bit)).fold(0, |mask, bit| mask | 1 << bit)
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

    /// The valid vertex at a place of the grid.
    pub fn grid_vertex(&self, place: UVec3) -> Option<u32> {
        let (block, bit) = self.grid.place(place);
        self.grid_blocks[block].number(bit)
    }

    /// The vertices of the grid, in their order.
    pub fn grid_vertex_places(&self) -> impl Iterator<Item = VertexPlace> {
        let within_block = || (0..).zip(places_of(UVec3::splat(BLOCK_EDGE)));
        let blocks = places_of(self.grid.blocks()).zip(&self.grid_blocks);
        blocks.flat_map(move |(at, block)| {
            let spacing = self.grid.at_level(block.level).spacing;
            within_block().filter_map(move |(bit, within)| {
                let (vertex, place) = (block.number(bit)?, at * BLOCK_EDGE + within);
                let offset = self.grid_vertices[vertex as usize].offset() * spacing;
                Some(VertexPlace {
                    vertex,
                    block: at,
                    level: block.level,
                    place,
                    position: self.grid.position(place) + offset,
                })
            })
        })
    }

    /// The walls in the cell between a place of a level and the next ones along each axis; the place is counted in that
    /// level's spacings. An index into `grid_cells`.
    pub fn grid_cell_number(&self, level: u32, cell: UVec3) -> Option<u32> {
        let (block, bit) = self.grid.at_level(level).place(cell);
        self.grid_cell_blocks.get(self.grid.first_cell_block(level) + block)?.number(bit)
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
