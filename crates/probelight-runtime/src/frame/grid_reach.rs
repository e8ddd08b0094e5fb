//! Where light is read from the grid's clusters: objects there need them computed.

use probelight_asset::{BLOCK_EDGE, BakedScene, VertexPlace, index_of, places_of};
use probelight_math::glam::{UVec3, Vec3};
use probelight_scene::Bounds;

use super::plan::ReceiverPlace;
use crate::GridPlaces;
use crate::irradiance_grid::{OFF_SURFACE, is_empty_cell};

/// Farther than anything is, metres.
const OUTSIDE: f32 = 1e30;

/// For each cluster of the grid, a box around all places that its vertices light, metres.
pub(super) fn grid_reach(baked: &BakedScene) -> Vec<Bounds> {
    let first = baked.lightmap_clusters();
    let nothing = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
    let mut reach = vec![nothing; baked.clusters.len() - first];
    let mut reach_from = |vertex: u32, low: Vec3, high: Vec3| {
        for receiver in baked.vertex_receivers(vertex) {
            let cluster = ReceiverPlace::at(&baked.clusters, *receiver).cluster as usize;
            let bounds = &mut reach[cluster - first];
            *bounds = Bounds { min: bounds.min.min(low), max: bounds.max.max(high) };
        }
    };
    let (grid, margin) = (&baked.grid, OFF_SURFACE * baked.grid.spacing);
    for VertexPlace { vertex, level, place, .. } in baked.grid_vertex_places() {
        let (at, around) = (grid.position(place), cells_read_around(baked, level, place) + margin);
        reach_from(vertex, at - around, at + around);
    }
    let places = GridPlaces::new(baked);
    let edge = grid.spacing * BLOCK_EDGE as f32 + margin;
    for block in places_that_borrow(baked) {
        let place = grid.position(block * BLOCK_EDGE);
        reach_from(places.nearest_vertex(block), place - edge, place + edge);
    }
    reach.iter_mut().for_each(|reach| *reach = with_outside(baked, *reach));
    reach
}

/// What lies outside reads the grid at its border.
fn with_outside(baked: &BakedScene, reach: Bounds) -> Bounds {
    let (low, high) = (baked.grid.origin, baked.grid.position(baked.grid.counts - 1));
    let min = Vec3::select(reach.min.cmple(low), Vec3::splat(-OUTSIDE), reach.min);
    let max = Vec3::select(reach.max.cmpge(high), Vec3::splat(OUTSIDE), reach.max);
    Bounds { min, max }
}

/// How far the cells reach that light is read from at a vertex of a block's level, and of coarser ones, metres.
fn cells_read_around(baked: &BakedScene, level: u32, place: UVec3) -> Vec3 {
    let grid = &baked.grid;
    let is_read = |level: u32| {
        let at = place >> level;
        place % (1 << level) == UVec3::ZERO
            && up_to(at).any(|cell| grid.is_read(&baked.grid_blocks, level, cell))
    };
    let coarsest = (level..grid.levels).rev().find(|level| is_read(*level)).unwrap_or(level);
    grid.at_level(coarsest).spacing
}

/// The blocks whose first places take light from the nearest vertex, as cells around them have none, or as they lie at
/// the border.
fn places_that_borrow(baked: &BakedScene) -> impl Iterator<Item = UVec3> {
    let (grid, blocks) = (&baked.grid, baked.grid.blocks());
    let has_empty_cell = |block: UVec3| {
        places_of(UVec3::splat(BLOCK_EDGE)).any(|within| {
            let place = block * BLOCK_EDGE + within;
            let is_cell = (place + 1).cmplt(grid.counts).all();
            is_cell && (0..grid.levels).all(|level| is_empty_cell(baked, level, place >> level))
        })
    };
    let has_empty_cell: Vec<bool> = places_of(blocks).map(has_empty_cell).collect();
    places_of(blocks).filter(move |block| {
        let is_border = block.cmpeq(UVec3::ZERO).any() || block.cmpeq(blocks - 1).any();
        is_border || up_to(*block).any(|block| has_empty_cell[index_of(blocks, block)])
    })
}

/// A place and those one step before it along each axis: where the cells begin that it is a corner of.
fn up_to(place: UVec3) -> impl Iterator<Item = UVec3> {
    places_of(UVec3::splat(2)).filter(move |step| step.cmple(place).all()).map(move |step| place - step)
}
