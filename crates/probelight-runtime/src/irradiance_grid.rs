//! Irradiance in free space, between the vertices of the grid (\[SED\] §4).

use probelight_asset::{BakedScene, GridLayout, MAX_GRID_ROWS};
use probelight_math::glam::{IVec3, UVec3, Vec3};

/// The grid of a baked scene with the light of a frame.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceGrid<'a> {
    baked: &'a BakedScene,
    /// Of all receivers.
    values: &'a [Vec3],
}

/// A vertex of the grid and its share of what lies between several.
pub(crate) type WeightedVertex = (u32, f32);

impl<'a> IrradianceGrid<'a> {
    /// From the irradiance of all of the scene's receivers, as both runtimes give it.
    pub fn new(baked: &'a BakedScene, receivers: &'a [Vec3]) -> Self {
        Self { baked, values: receivers }
    }

    /// Irradiance (W/m²) of a surface at a world position that faces along `normal` (unit), never negative. `None` if the
    /// scene was baked without a grid.
    pub fn irradiance(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        self.between(&vertices_lighting(self.baked, position, normal), normal)
    }

    /// Irradiance between some vertices; `None` without a grid.
    pub(crate) fn between(&self, vertices: &[WeightedVertex], normal: Vec3) -> Option<Vec3> {
        let mut rows = [Vec3::ZERO; MAX_GRID_ROWS];
        for (vertex, weight) in vertices.iter().filter(|(_, weight)| *weight > 0.0) {
            for (row, receiver) in rows.iter_mut().zip(self.baked.vertex_receivers(*vertex)) {
                *row += *weight * self.values[*receiver as usize];
            }
        }
        let weights = self.baked.settings.grid_basis.read_weights(normal);
        let sum: Vec3 = rows.iter().zip(weights).map(|(row, weight)| *row * weight).sum();
        self.baked.has_grid().then(|| sum.max(Vec3::ZERO))
    }
}

/// The vertices that light a point of a surface that faces along `normal` (unit); the weights sum to one. None has any
/// without a grid, and where walls cut the point off from all of them.
pub(crate) fn vertices_lighting(baked: &BakedScene, position: Vec3, normal: Vec3) -> [WeightedVertex; 8] {
    if !baked.has_grid() {
        return NO_VERTICES;
    }
    let off_surface = position + normal * (OFF_SURFACE * baked.grid.spacing.min_element());
    let vertices = vertices_around(baked, position).or_else(|| vertices_around(baked, off_surface));
    vertices.or_else(|| nearest_if_outside(baked, position)).unwrap_or(NO_VERTICES)
}

const NO_VERTICES: [WeightedVertex; 8] = [(0, 0.0); 8];

/// A point that nothing lights is looked at so many spacings off its surface, too: it may just lie in a wall.
const OFF_SURFACE: f32 = 0.02;

/// Where so little weight is left, the corners that light a place count the same.
const SMALLEST_WEIGHT: f32 = 1e-4;

/// The corners of a position's cell, as far as they light it: trilinear weights, and walls between.
fn vertices_around(baked: &BakedScene, position: Vec3) -> Option<[WeightedVertex; 8]> {
    let place = CellPlace::of(&baked.grid, position);
    let mut vertices = NO_VERTICES;
    let mut sight = [0.0; 8];
    for (i, corner) in corners().enumerate() {
        if let Some(vertex) = baked.grid_vertex(place.cell + corner) {
            vertices[i].0 = vertex;
            sight[i] = place.sight(baked, position, corner);
        }
    }
    let trilinear: Vec<f32> = corners().map(|corner| place.share(corner)).collect();
    let total: f32 = trilinear.iter().zip(&sight).map(|(share, sight)| share * sight).sum();
    let seen: f32 = sight.iter().sum();
    for i in 0..8 {
        vertices[i].1 =
            if total > SMALLEST_WEIGHT { trilinear[i] * sight[i] / total } else { sight[i] / seen };
    }
    (seen > 0.0).then_some(vertices)
}

/// Corners of a cell, x first.
fn corners() -> impl Iterator<Item = UVec3> {
    (0..8).map(|i| UVec3::new(i & 1, i >> 1 & 1, i >> 2))
}

/// Where a position lies between the vertices of a grid.
struct CellPlace {
    /// The lowest corner of the cell that the position lies in, or is nearest to.
    cell: UVec3,
    /// Where in it, from 0 to 1.
    within: Vec3,
}

impl CellPlace {
    fn of(grid: &GridLayout, position: Vec3) -> Self {
        let last = (grid.counts - 1).as_vec3();
        // `max` before `min` turns NaN into the first vertex.
        let at = ((position - grid.origin) / grid.spacing).max(Vec3::ZERO).min(last);
        let cell = at.floor().min(last - 1.0).max(Vec3::ZERO);
        Self { cell: cell.as_uvec3(), within: at - cell }
    }

    /// Trilinear weight of a corner.
    fn share(&self, corner: UVec3) -> f32 {
        Vec3::select(corner.cmpeq(UVec3::ONE), self.within, 1.0 - self.within).element_product()
    }

    /// How far walls let a corner light the position, from 0 to 1. The walls of the position's own cell do so sharply;
    /// those of the next cells fade in over half of it, so that nothing jumps where a wall ends.
    fn sight(&self, baked: &BakedScene, position: Vec3, corner: UVec3) -> f32 {
        let is_lower = self.within.cmplt(Vec3::splat(0.5));
        // From the middle of the cell to the next one along each axis.
        let nearness = (2.0 * (self.within - 0.5)).abs();
        let blocked = |step: UVec3| {
            let vertex = self.cell + corner;
            let low =
                (self.cell + step).as_ivec3() - IVec3::select(is_lower, 2 * step.as_ivec3(), IVec3::ZERO);
            let own = vertex.as_ivec3() - low;
            if low.cmplt(IVec3::ZERO).any() || own.cmplt(IVec3::ZERO).any() || own.cmpgt(IVec3::ONE).any() {
                return 0.0;
            }
            let Some(cell) = baked.grid_cell(low.as_uvec3()) else { return 0.0 };
            let bit = own.x + 2 * own.y + 4 * own.z;
            if baked.corners_lighting(cell, position) >> bit & 1 == 1 {
                return 0.0;
            }
            Vec3::select(step.cmpeq(UVec3::ONE), nearness, Vec3::ONE).element_product()
        };
        corners().map(|step| 1.0 - blocked(step)).product()
    }
}

/// Outside the grid, the vertex that is nearest.
fn nearest_if_outside(baked: &BakedScene, position: Vec3) -> Option<[WeightedVertex; 8]> {
    let grid = &baked.grid;
    let place = CellPlace::of(grid, position);
    let has_corner = corners().any(|corner| baked.grid_vertex(place.cell + corner).is_some());
    let last = grid.position(grid.counts - 1);
    let is_inside = position.cmpgt(grid.origin).all() && position.cmplt(last).all();
    if has_corner && is_inside {
        return None;
    }
    let mut vertices = NO_VERTICES;
    vertices[0] = (nearest_vertex(baked, position)?, 1.0);
    Some(vertices)
}

fn nearest_vertex(baked: &BakedScene, position: Vec3) -> Option<u32> {
    let grid = &baked.grid;
    let counts = grid.counts;
    let all = (0..counts.z)
        .flat_map(move |z| (0..counts.y).flat_map(move |y| (0..counts.x).map(move |x| UVec3::new(x, y, z))));
    let valid = all.filter_map(|at| {
        let vertex = baked.grid_vertex(at)?;
        let place = grid.position(at) + baked.grid_vertices[vertex as usize].offset() * grid.spacing;
        Some((place.distance_squared(position), vertex))
    });
    valid.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, vertex)| vertex)
}
