//! Irradiance in free space, between the vertices of the grid (\[SED\] §4).

use probelight_asset::{BakedScene, GridLayout, MAX_GRID_LEVELS, MAX_GRID_ROWS};
use probelight_math::glam::{IVec3, UVec3, Vec3};

use crate::grid_places::places_of_blocks;
use crate::{GridLight, GridPlaces};

/// The grid of a baked scene with the light of a frame.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceGrid<'a> {
    baked: &'a BakedScene,
    places: &'a GridPlaces,
    /// Of all receivers.
    values: &'a [Vec3],
}

/// A vertex of the grid and its share of what lies between several.
pub(crate) type WeightedVertex = (u32, f32);

/// The vertices that light a place: up to eight of each level.
pub(crate) type WeightedVertices = [WeightedVertex; 8 * MAX_GRID_LEVELS as usize];

impl<'a> IrradianceGrid<'a> {
    /// From the places of the scene's grid, and the irradiance of all of its receivers, as both runtimes give it.
    pub fn new(baked: &'a BakedScene, places: &'a GridPlaces, receivers: &'a [Vec3]) -> Self {
        Self { baked, places, values: receivers }
    }

    /// Irradiance (W/m²) of a surface at a world position that faces along `normal` (unit), never negative. `None` if the
    /// scene was baked without a grid.
    pub fn irradiance(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        Some(self.light(position, normal)?.irradiance(normal))
    }

    /// Light around a point of a surface that faces along `normal` (unit). `None` if the scene was baked without a grid.
    pub fn light(&self, position: Vec3, normal: Vec3) -> Option<GridLight> {
        self.baked.has_grid().then(|| self.between(&self.vertices_lighting(position, normal)))
    }

    /// The vertices that light a point of a surface that faces along `normal` (unit); the weights sum to one. None has any
    /// without a grid, and where walls cut the point off from all of them.
    pub(crate) fn vertices_lighting(&self, position: Vec3, normal: Vec3) -> WeightedVertices {
        if !self.baked.has_grid() {
            return NO_VERTICES;
        }
        let off_surface = position + normal * (OFF_SURFACE * self.baked.grid.spacing.min_element());
        let vertices = self.vertices_around(position).or_else(|| self.vertices_around(off_surface));
        vertices.or_else(|| self.nearest_if_outside(position)).unwrap_or(NO_VERTICES)
    }

    /// Light between some vertices.
    pub(crate) fn between(&self, vertices: &[WeightedVertex]) -> GridLight {
        let mut rows = [Vec3::ZERO; MAX_GRID_ROWS];
        for (vertex, weight) in vertices.iter().filter(|(_, weight)| *weight > 0.0) {
            for (row, receiver) in rows.iter_mut().zip(self.baked.vertex_receivers(*vertex)) {
                *row += *weight * self.values[*receiver as usize];
            }
        }
        GridLight::new(self.baked.settings.grid_basis, rows)
    }

    /// The corners of the cells that a position lies in, as far as they light it: trilinear weights, and walls between.
    /// Where a cell has corners in coarser blocks, their share comes from the cell of the next level.
    fn vertices_around(&self, position: Vec3) -> Option<WeightedVertices> {
        let grid = &self.baked.grid;
        let mut vertices = NO_VERTICES;
        let mut rest = 1.0;
        for (level, found) in (0..grid.levels).zip(vertices.as_chunks_mut::<8>().0) {
            let place = CellPlace::of(&grid.at_level(level), position);
            let covered = self.corners_of(level, &place, found);
            // Nothing coarser knows the walls where all corners are there.
            let is_whole = covered > 1.0 - SMALLEST_WEIGHT;
            let share = if is_whole { rest } else { rest * covered };
            if found.iter().any(|(_, weight)| *weight > 0.0) {
                found.iter_mut().for_each(|(_, weight)| *weight *= share);
                rest -= share;
            }
            if is_whole {
                break;
            }
        }
        let total: f32 = vertices.iter().map(|(_, weight)| weight).sum();
        vertices.iter_mut().for_each(|(_, weight)| *weight /= total);
        (total > 0.0).then_some(vertices)
    }

    /// The corners of a cell of a level, with weights that sum to one or, if none lights the position, are zero; and the
    /// trilinear share of those whose blocks are as fine as the level.
    fn corners_of(&self, level: u32, place: &CellPlace, found: &mut [WeightedVertex; 8]) -> f32 {
        let mut sight = self.sight(level, place);
        let mut covered = 0.0;
        for (i, corner) in corners().enumerate() {
            let (at, share) = ((place.cell + corner) << level, place.share(corner));
            let is_covered = is_covered(self.baked, at, level);
            covered += if is_covered { share } else { 0.0 };
            match self.baked.grid_vertex(at).filter(|_| is_covered) {
                Some(vertex) => found[i] = (vertex, share),
                None => sight[i] = 0.0,
            }
        }
        let total: f32 = found.iter().zip(&sight).map(|((_, share), sight)| share * sight).sum();
        let seen: f32 = sight.iter().sum();
        for ((_, share), sight) in found.iter_mut().zip(sight) {
            *share = if total > SMALLEST_WEIGHT {
                *share * sight / total
            } else {
                sight / seen.max(f32::MIN_POSITIVE)
            };
        }
        covered
    }

    /// How far walls let each corner light the position, from 0 to 1. The walls of the position's own cell do so sharply;
    /// those of the next cells fade in over half of it, so that nothing jumps where a wall ends.
    fn sight(&self, level: u32, place: &CellPlace) -> [f32; 8] {
        let is_lower = place.within.cmplt(Vec3::splat(0.5));
        // From the middle of the cell to the next one along each axis.
        let nearness = (2.0 * (place.within - 0.5)).abs();
        let mut sight = [1.0; 8];
        for step in corners() {
            let way = IVec3::select(is_lower, -step.as_ivec3(), step.as_ivec3());
            let low = place.cell.as_ivec3() + way;
            if low.cmplt(IVec3::ZERO).any() || low.cmpge(place.counts.as_ivec3()).any() {
                continue;
            }
            let Some(cell) = self.baked.grid_cell_number(level, low.as_uvec3()) else { continue };
            let share = Vec3::select(step.cmpeq(UVec3::ONE), nearness, Vec3::ONE).element_product();
            let lighting = self.baked.corners_lighting(&self.baked.grid_cells[cell as usize], place.position);
            let blocked = corners_from_next(!lighting, way);
            let hidden = sight.iter_mut().enumerate().filter(|(corner, _)| blocked >> corner & 1 == 1);
            hidden.for_each(|(_, sight)| *sight *= 1.0 - share);
        }
        sight
    }

    /// Outside the grid, and where cells have no vertices, the nearest ones to the first places of the blocks around.
    fn nearest_if_outside(&self, position: Vec3) -> Option<WeightedVertices> {
        let grid = &self.baked.grid;
        let is_empty = (0..grid.levels).all(|level| {
            is_empty_cell(self.baked, level, CellPlace::of(&grid.at_level(level), position).cell)
        });
        let is_outside = CellPlace::of(grid, position).position != position;
        let place = CellPlace::of(&places_of_blocks(grid), position);
        let mut vertices = NO_VERTICES;
        for (vertex, corner) in vertices.iter_mut().zip(corners()) {
            *vertex = (self.places.nearest_vertex(place.cell + corner), place.share(corner));
        }
        (is_empty || is_outside).then_some(vertices)
    }
}

const NO_VERTICES: WeightedVertices = [(0, 0.0); _];

/// A point that nothing lights is looked at so many spacings off its surface, too: it may just lie in a wall.
pub(crate) const OFF_SURFACE: f32 = 0.02;

/// Where so little weight is left, the corners that light a place count the same.
pub(crate) const SMALLEST_WEIGHT: f32 = 1e-4;

/// Corners of a cell, x first.
fn corners() -> impl Iterator<Item = UVec3> {
    (0..8).map(corner)
}

fn corner(i: u32) -> UVec3 {
    UVec3::new(i & 1, i >> 1 & 1, i >> 2)
}

/// The corners of a cell, a bit each, that are those of a cell `way` next to it; of those, the bits that are set there.
fn corners_from_next(next: u8, way: IVec3) -> u8 {
    // Of each axis, the corners on its lower side, and how far the upper ones' bits lie from theirs.
    let axes = [(0x55, 1), (0x33, 2), (0x0F, 4)];
    axes.into_iter().zip(way.to_array()).fold(next, |bits, ((lower, shift), way)| match way.signum() {
        1 => (bits & lower) << shift,
        -1 => (bits & !lower) >> shift,
        _ => bits,
    })
}

/// Whether none of the corners of a cell of a level has light.
pub(crate) fn is_empty_cell(baked: &BakedScene, level: u32, cell: UVec3) -> bool {
    corners().all(|corner| {
        let at = (cell + corner) << level;
        !is_covered(baked, at, level) || baked.grid_vertex(at).is_none()
    })
}

fn is_covered(baked: &BakedScene, place: UVec3, level: u32) -> bool {
    baked.grid.is_covered(&baked.grid_blocks, place, level)
}

/// Where a position lies between the places of a grid.
struct CellPlace {
    /// The position, or the nearest one within the grid.
    position: Vec3,
    /// The lowest corner of the cell that it lies in.
    cell: UVec3,
    /// Where in it, from 0 to 1.
    within: Vec3,
    /// Places along each axis.
    counts: UVec3,
}

impl CellPlace {
    fn of(grid: &GridLayout, position: Vec3) -> Self {
        // `max` before `min` turns NaN into the first place.
        let position = position.max(grid.origin).min(grid.position(grid.counts - 1));
        let last = (grid.counts - 1).as_vec3();
        let at = ((position - grid.origin) / grid.spacing).min(last);
        let cell = at.floor().min(last - 1.0).max(Vec3::ZERO);
        Self { position, cell: cell.as_uvec3(), within: at - cell, counts: grid.counts }
    }

    /// Trilinear weight of a corner.
    fn share(&self, corner: UVec3) -> f32 {
        Vec3::select(corner.cmpeq(UVec3::ONE), self.within, 1.0 - self.within).element_product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_next_cell_are_those_on_the_shared_side() {
        let bit = |x: i32, y: i32, z: i32| 1u8 << (x + 2 * y + 4 * z);
        for (way, next, own) in [
            (IVec3::ZERO, bit(1, 0, 1), bit(1, 0, 1)),
            (IVec3::X, bit(0, 1, 1), bit(1, 1, 1)),
            (IVec3::X, bit(1, 1, 1), 0),
            (IVec3::NEG_Y, bit(1, 1, 0), bit(1, 0, 0)),
            (IVec3::new(1, -1, 1), bit(0, 1, 0), bit(1, 0, 1)),
            (IVec3::NEG_Z, bit(0, 0, 0), 0),
        ] {
            assert_eq!(corners_from_next(next, way), own, "{way} {next:08b}");
        }
    }
}
