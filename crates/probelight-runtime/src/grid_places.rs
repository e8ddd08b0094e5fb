//! The grid's lattice with a direct answer for each place: tables in place of the file's sparse blocks.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, NONE};
use probelight_math::glam::{IVec3, UVec3, Vec3};

/// What is known at one place of the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GridPlace {
    /// The vertex there, or the nearest one with [`BORROWED`] set.
    pub(crate) vertex: u32,
    /// The walls in the cell from here to the next places, an index into `grid_cells`; [`NONE`] without any.
    pub(crate) cell: u32,
}

/// Set in the number of a vertex that is another place's.
pub(crate) const BORROWED: u32 = 1 << 31;

/// All places of a grid's lattice, x fastest; none without a grid.
#[derive(Clone, Debug)]
pub struct GridPlaces {
    places: Vec<GridPlace>,
    counts: UVec3,
}

impl GridPlaces {
    /// Unpacks the blocks of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        if !baked.has_grid() {
            return Self { places: Vec::new(), counts: UVec3::ZERO };
        }
        let counts = baked.grid.counts;
        let places: Vec<UVec3> = (0..counts.element_product()).map(|index| place(counts, index)).collect();
        let nearest = nearest_vertices(baked, &places);
        let known = |(at, nearest): (&UVec3, u32)| GridPlace {
            vertex: baked.grid_vertex(*at).unwrap_or(nearest | BORROWED),
            cell: baked.grid_cell_number(*at).unwrap_or(NONE),
        };
        Self { places: places.iter().zip(nearest).map(known).collect(), counts }
    }

    /// The vertex at a place, if it has light of its own.
    #[inline]
    pub(crate) fn vertex(&self, at: UVec3) -> Option<u32> {
        Some(self.places[self.index(at)].vertex).filter(|vertex| vertex & BORROWED == 0)
    }

    /// The vertex at a place, or the nearest one.
    #[inline]
    pub(crate) fn nearest_vertex(&self, at: UVec3) -> u32 {
        self.places[self.index(at)].vertex & !BORROWED
    }

    /// The number of the walls in a cell.
    #[inline]
    pub(crate) fn cell(&self, at: UVec3) -> Option<u32> {
        Some(self.places[self.index(at)].cell).filter(|cell| *cell != NONE)
    }

    /// All of them, for shaders.
    #[cfg(feature = "gpu")]
    pub(crate) fn as_slice(&self) -> &[GridPlace] {
        &self.places
    }

    #[inline]
    fn index(&self, at: UVec3) -> usize {
        at.x as usize + self.counts.x as usize * (at.y as usize + self.counts.y as usize * at.z as usize)
    }
}

fn place(counts: UVec3, index: u32) -> UVec3 {
    UVec3::new(index % counts.x, index / counts.x % counts.y, index / counts.x / counts.y)
}

/// The vertex nearest to each place. It spreads from place to place; what a place takes over from its neighbours is the
/// nearest that these know, which is nearly always the nearest there is (Danielsson's distance transform).
fn nearest_vertices(baked: &BakedScene, places: &[UVec3]) -> Vec<u32> {
    let (grid, counts) = (&baked.grid, baked.grid.counts);
    let mut measured = vec![Vec3::INFINITY; baked.grid_vertices.len()];
    for at in places {
        if let Some(vertex) = baked.grid_vertex(*at) {
            let offset = baked.grid_vertices[vertex as usize].offset();
            measured[vertex as usize] = grid.position(*at) + offset * grid.spacing;
        }
    }
    let mut nearest: Vec<u32> = places.iter().map(|at| baked.grid_vertex(*at).unwrap_or(NONE)).collect();
    let mut front: Vec<usize> = (0..places.len()).filter(|index| nearest[*index] != NONE).collect();
    while !front.is_empty() {
        let reached = front.iter().flat_map(|index| neighbors(counts, places[*index]));
        let mut next: Vec<usize> = reached.filter(|index| nearest[*index] == NONE).collect();
        next.sort_unstable();
        next.dedup();
        let chosen = next.iter().map(|index| {
            let known = neighbors(counts, places[*index]).map(|other| nearest[other]);
            let distance =
                |vertex: &u32| measured[*vertex as usize].distance_squared(grid.position(places[*index]));
            let candidates = known.filter(|vertex| *vertex != NONE);
            candidates.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b))).unwrap_or(NONE)
        });
        let chosen: Vec<u32> = chosen.collect();
        next.iter().zip(chosen).for_each(|(index, vertex)| nearest[*index] = vertex);
        front = next;
    }
    nearest
}

/// The places around a place.
fn neighbors(counts: UVec3, at: UVec3) -> impl Iterator<Item = usize> {
    let steps = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1).filter(|step| *step != IVec3::ZERO);
    let places = steps.map(move |step| at.as_ivec3() + step);
    let inside = places.filter(move |at| at.cmpge(IVec3::ZERO).all() && at.cmplt(counts.as_ivec3()).all());
    inside.map(move |at| (at.x + counts.x as i32 * (at.y + counts.y as i32 * at.z)) as usize)
}
