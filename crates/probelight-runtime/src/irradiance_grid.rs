//! Irradiance in free space, between the vertices of the grid (\[SED\] §4).

use probelight_asset::BakedScene;
use probelight_math::glam::{IVec3, UVec3, Vec3};

use crate::GridPlaces;

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

impl<'a> IrradianceGrid<'a> {
    /// From the places of the scene's grid, and the irradiance of all of its receivers, as both runtimes give it.
    pub fn new(baked: &'a BakedScene, places: &'a GridPlaces, receivers: &'a [Vec3]) -> Self {
        Self { baked, places, values: receivers }
    }

    /// Irradiance (W/m²) of a surface at a world position that faces along `normal` (unit), never negative. `None` if the
    /// scene was baked without a grid.
    pub fn irradiance(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        self.between(&self.vertices_lighting(position, normal), normal)
    }

    /// The vertices that light a point of a surface that faces along `normal` (unit); the weights sum to one. None has any
    /// without a grid, and where walls cut the point off from all of them.
    pub(crate) fn vertices_lighting(&self, position: Vec3, normal: Vec3) -> [WeightedVertex; 8] {
        if !self.baked.has_grid() {
            return NO_VERTICES;
        }
        let off_surface = position + normal * (OFF_SURFACE * self.baked.grid.spacing.min_element());
        let vertices = self.vertices_around(position).or_else(|| self.vertices_around(off_surface));
        vertices.or_else(|| self.nearest_if_outside(position)).unwrap_or(NO_VERTICES)
    }

    /// Irradiance between some vertices; `None` without a grid.
    pub(crate) fn between(&self, vertices: &[WeightedVertex], normal: Vec3) -> Option<Vec3> {
        let weights = self.baked.settings.grid_basis.read_weights(normal);
        let mut sum = Vec3::ZERO;
        for (vertex, weight) in vertices.iter().filter(|(_, weight)| *weight > 0.0) {
            for (receiver, row) in self.baked.vertex_receivers(*vertex).iter().zip(weights) {
                sum += (*weight * row) * self.values[*receiver as usize];
            }
        }
        self.baked.has_grid().then(|| sum.max(Vec3::ZERO))
    }

    /// The corners of a position's cell, as far as they light it: trilinear weights, and walls between.
    fn vertices_around(&self, position: Vec3) -> Option<[WeightedVertex; 8]> {
        let place = CellPlace::of(self.baked, position);
        let mut sight = self.sight(&place);
        let mut vertices = NO_VERTICES;
        for (i, corner) in corners().enumerate() {
            match self.places.vertex(place.cell + corner) {
                Some(vertex) => vertices[i] = (vertex, place.share(corner)),
                None => sight[i] = 0.0,
            }
        }
        let total: f32 = vertices.iter().zip(&sight).map(|((_, share), sight)| share * sight).sum();
        let seen: f32 = sight.iter().sum();
        for ((_, share), sight) in vertices.iter_mut().zip(sight) {
            *share = if total > SMALLEST_WEIGHT { *share * sight / total } else { sight / seen };
        }
        (seen > 0.0).then_some(vertices)
    }

    /// How far walls let each corner light the position, from 0 to 1. The walls of the position's own cell do so sharply;
    /// those of the next cells fade in over half of it, so that nothing jumps where a wall ends.
    fn sight(&self, place: &CellPlace) -> [f32; 8] {
        let is_lower = place.within.cmplt(Vec3::splat(0.5));
        // From the middle of the cell to the next one along each axis.
        let nearness = (2.0 * (place.within - 0.5)).abs();
        let mut sight = [1.0; 8];
        for step in corners() {
            let way = IVec3::select(is_lower, -step.as_ivec3(), step.as_ivec3());
            let low = place.cell.as_ivec3() + way;
            if low.cmplt(IVec3::ZERO).any() || low.cmpge(self.baked.grid.counts.as_ivec3()).any() {
                continue;
            }
            let Some(cell) = self.places.cell(low.as_uvec3()) else { continue };
            let share = Vec3::select(step.cmpeq(UVec3::ONE), nearness, Vec3::ONE).element_product();
            let lighting = self.baked.corners_lighting(&self.baked.grid_cells[cell as usize], place.position);
            for (corner, sight) in corners().zip(&mut sight) {
                let own = corner.as_ivec3() - way;
                let is_corner = own.cmpge(IVec3::ZERO).all() && own.cmple(IVec3::ONE).all();
                let bit = own.x + 2 * own.y + 4 * own.z;
                if is_corner && lighting >> bit & 1 == 0 {
                    *sight *= 1.0 - share;
                }
            }
        }
        sight
    }

    /// Outside the grid, and where a cell has no vertices, the nearest ones to the cell's corners.
    fn nearest_if_outside(&self, position: Vec3) -> Option<[WeightedVertex; 8]> {
        let place = CellPlace::of(self.baked, position);
        let is_empty = corners().all(|corner| self.places.vertex(place.cell + corner).is_none());
        let corner = |i: u32| {
            let corner = corner(i);
            (self.places.nearest_vertex(place.cell + corner), place.share(corner))
        };
        (is_empty || place.position != position).then(|| std::array::from_fn(|i| corner(i as u32)))
    }
}

const NO_VERTICES: [WeightedVertex; 8] = [(0, 0.0); 8];

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

/// Where a position lies between the vertices of a grid.
struct CellPlace {
    /// The position, or the nearest one within the grid.
    position: Vec3,
    /// The lowest corner of the cell that it lies in.
    cell: UVec3,
    /// Where in it, from 0 to 1.
    within: Vec3,
}

impl CellPlace {
    fn of(baked: &BakedScene, position: Vec3) -> Self {
        let grid = &baked.grid;
        // `max` before `min` turns NaN into the first vertex.
        let position = position.max(grid.origin).min(grid.position(grid.counts - 1));
        let last = (grid.counts - 1).as_vec3();
        let at = ((position - grid.origin) / grid.spacing).min(last);
        let cell = at.floor().min(last - 1.0).max(Vec3::ZERO);
        Self { position, cell: cell.as_uvec3(), within: at - cell }
    }

    /// Trilinear weight of a corner.
    fn share(&self, corner: UVec3) -> f32 {
        Vec3::select(corner.cmpeq(UVec3::ONE), self.within, 1.0 - self.within).element_product()
    }
}
