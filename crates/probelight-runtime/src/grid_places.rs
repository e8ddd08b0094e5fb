//! Where light comes from outside the grid in free space, and where a cell of it has no vertices.

use probelight_asset::{BLOCK_EDGE, BakedScene, GridLayout, NONE, VertexPlace, index_of, places_of};
use probelight_math::glam::{IVec3, UVec3, Vec3};

/// For each block of a grid, x fastest, the vertex nearest to its first place; none without a grid.
#[derive(Clone, Debug)]
pub struct GridPlaces {
    nearest: Vec<u32>,
    blocks: UVec3,
}

impl GridPlaces {
    /// Of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let blocks = baked.grid.blocks();
        if !baked.has_grid() {
            return Self { nearest: Vec::new(), blocks: UVec3::ZERO };
        }
        Self { nearest: nearest_vertices(baked, blocks), blocks }
    }

    /// The vertex nearest to a block's first place; beyond the grid, to that of the last block.
    #[inline]
    pub(crate) fn nearest_vertex(&self, block: UVec3) -> u32 {
        self.nearest[index_of(self.blocks, block.min(self.blocks - 1))]
    }

    /// All of them, for shaders.
    #[cfg(feature = "gpu")]
    pub(crate) fn as_slice(&self) -> &[u32] {
        &self.nearest
    }
}

/// The first places of blocks, as a grid.
pub(crate) fn places_of_blocks(grid: &GridLayout) -> GridLayout {
    GridLayout { spacing: grid.spacing * BLOCK_EDGE as f32, counts: grid.blocks(), ..*grid }
}

/// The vertex nearest to the first place of each block. It spreads from block to block; what one takes over from its
/// neighbours is the nearest that these know, which is nearly always the nearest there is (Danielsson's distance transform).
fn nearest_vertices(baked: &BakedScene, blocks: UVec3) -> Vec<u32> {
    let grid = &baked.grid;
    let places: Vec<UVec3> = places_of(blocks).collect();
    let measured: Vec<Vec3> = baked.grid_vertex_places().map(|vertex| vertex.position).collect();
    let distance = |vertex: u32, block: UVec3| {
        measured[vertex as usize].distance_squared(grid.position(block * BLOCK_EDGE))
    };
    let mut nearest = vec![NONE; places.len()];
    for VertexPlace { vertex, block, .. } in baked.grid_vertex_places() {
        let known = &mut nearest[index_of(blocks, block)];
        if *known == NONE || distance(vertex, block) < distance(*known, block) {
            *known = vertex;
        }
    }
    let mut front: Vec<usize> = (0..places.len()).filter(|index| nearest[*index] != NONE).collect();
    while !front.is_empty() {
        let reached = front.iter().flat_map(|index| neighbors(blocks, places[*index]));
        let mut next: Vec<usize> = reached.filter(|index| nearest[*index] == NONE).collect();
        next.sort_unstable();
        next.dedup();
        let chosen = next.iter().map(|index| {
            let known = neighbors(blocks, places[*index]).map(|other| nearest[other]);
            let distance = |vertex: &u32| distance(*vertex, places[*index]);
            let candidates = known.filter(|vertex| *vertex != NONE);
            candidates.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b))).unwrap_or(NONE)
        });
        let chosen: Vec<u32> = chosen.collect();
        next.iter().zip(chosen).for_each(|(index, vertex)| nearest[*index] = vertex);
        front = next;
    }
    nearest
}

/// The blocks around a block.
fn neighbors(counts: UVec3, at: UVec3) -> impl Iterator<Item = usize> {
    let steps = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1).filter(|step| *step != IVec3::ZERO);
    let places = steps.map(move |step| at.as_ivec3() + step);
    let inside = places.filter(move |at| at.cmpge(IVec3::ZERO).all() && at.cmplt(counts.as_ivec3()).all());
    inside.map(move |at| index_of(counts, at.as_uvec3()))
}
