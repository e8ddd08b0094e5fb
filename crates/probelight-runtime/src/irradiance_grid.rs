//! Irradiance in free space, between the vertices of the grid (\[SED\] §4).

use probelight_asset::{BakedScene, GridLayout, MAX_GRID_ROWS};
use probelight_math::glam::{UVec3, Vec3};

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
        self.between(&vertices_around(self.baked, position), normal)
    }

    /// Irradiance between some vertices; `None` if there are none.
    pub(crate) fn between(&self, vertices: &[WeightedVertex], normal: Vec3) -> Option<Vec3> {
        let mut rows = [Vec3::ZERO; MAX_GRID_ROWS];
        for (vertex, weight) in vertices {
            for (row, receiver) in rows.iter_mut().zip(self.baked.vertex_receivers(*vertex)) {
                *row += *weight * self.values[*receiver as usize];
            }
        }
        let weights = self.baked.settings.grid_basis.read_weights(normal);
        let sum: Vec3 = rows.iter().zip(weights).map(|(row, weight)| *row * weight).sum();
        (!vertices.is_empty()).then(|| sum.max(Vec3::ZERO))
    }
}

/// The vertices that light a world position; their weights sum to one. None without a grid.
pub(crate) fn vertices_around(baked: &BakedScene, position: Vec3) -> Vec<WeightedVertex> {
    if !baked.has_grid() {
        return Vec::new();
    }
    let (cell, within) = cell_of(&baked.grid, position);
    let corners = (0..8u32).filter_map(|i| {
        let corner = UVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let share = |axis: usize| if corner[axis] == 1 { within[axis] } else { 1.0 - within[axis] };
        let weight = share(0) * share(1) * share(2);
        Some((baked.grid_vertex(cell + corner)?, weight))
    });
    let mut vertices: Vec<WeightedVertex> = corners.filter(|(_, weight)| *weight > 0.0).collect();
    let total: f32 = vertices.iter().map(|(_, weight)| weight).sum();
    if total <= SMALLEST_WEIGHT {
        return nearest_vertex(baked, position).map(|vertex| (vertex, 1.0)).into_iter().collect();
    }
    vertices.iter_mut().for_each(|(_, weight)| *weight /= total);
    vertices
}

/// Where so little weight is left, the nearest vertex takes over.
const SMALLEST_WEIGHT: f32 = 1e-4;

/// The lowest corner of the cell that a position lies in, or is nearest to, and where in it, from 0 to 1.
fn cell_of(grid: &GridLayout, position: Vec3) -> (UVec3, Vec3) {
    let last = (grid.counts - 1).as_vec3();
    // `max` before `min` turns NaN into the first vertex.
    let at = ((position - grid.origin) / grid.spacing).max(Vec3::ZERO).min(last);
    let cell = at.floor().min(last - 1.0).max(Vec3::ZERO);
    (cell.as_uvec3(), at - cell)
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
