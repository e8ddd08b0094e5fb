//! Where light in free space is kept for objects that move: a grid over the scene's bounds (\[SED\] §4).
//!
//! It is even, or finer in rooms than in the open (`grid_levels.rs`). Each vertex measures where it lies, or, if that is
//! inside a solid or next to a surface, at the best place in its neighbourhood. Vertices without such a place have no
//! light and are not stored.

use probelight_asset::{BLOCK_EDGE, BakeSettings, GridBlock, GridLayout, places_of};
use probelight_math::glam::{UVec3, Vec3};
use probelight_scene::Bounds;
use probelight_trace::Progress;
use rayon::prelude::*;

use crate::BakeError;
use crate::air::{Air, LitSides};
use crate::ground::grid_levels::{GridPlan, Survey};
use crate::ground::site::{Outlook, Site};
use crate::options::even_spacing;
use crate::steps::for_each_in_parallel;

/// Gather rays of a vertex as a multiple of a texel's, as they go all around, and the fewest: texels have neighbours that
/// noise evens out with, and there are many more of them.
pub(crate) const RAYS_PER_GATHER_RAY: u32 = 2;
pub(crate) const FEWEST_RAYS: u32 = 4096;

/// Places of a block.
pub(crate) const PLACES_PER_BLOCK: usize = (BLOCK_EDGE * BLOCK_EDGE * BLOCK_EDGE) as usize;

/// Vertices whose transport is compressed together.
pub(crate) const VERTICES_PER_GROUP: usize = 128;

/// What the compression of vertices may lose as a multiple of what that of texels may: of the light read in the air
/// interpolation between them misses several times as much near a lamp.
pub(crate) const ERROR_PER_TEXEL_ERROR: f32 = 3.75;

/// Distances at which a vertex looks for a better place, in spacings (\[SED\] §4).
const SHIFTS: [f32; 4] = [0.1, 0.2, 0.32, 0.45];

/// How far a vertex must be from surfaces, in spacings: nearer, it sees what is next to it and nothing else.
const CLEARANCE: f32 = 0.08;

/// Plans until about as many vertices have light as wanted, and the share that may be missing or too many.
const MOST_PLANS: u32 = 5;
const MOST_MISSED: f32 = 0.08;

/// What a byte of vertices must save, as a share of their wanted error's energy, with so many receivers of the lightmap or
/// more. At four times that price the air of rooms errs by a third more, for half of the bytes.
const BYTE_PRICE: f32 = 0.1;
const FULL_PRICE_RECEIVERS: f32 = 40_000.0;

/// What a byte of vertices must save beside so many receivers: where all is small, there is nothing to save.
pub(crate) fn byte_price(receivers: u32) -> f32 {
    BYTE_PRICE * (receivers as f32 / FULL_PRICE_RECEIVERS).min(1.0)
}

/// A grid as it is baked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    pub(crate) layout: GridLayout,
    /// All of them, x first.
    pub(crate) blocks: Vec<GridBlock>,
    /// Those that have light, block by block.
    pub(crate) vertices: Vec<Vertex>,
}

/// A vertex that has light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Its place in the grid.
    pub(crate) at: UVec3,
    /// Where it measures, metres.
    pub(crate) position: Vec3,
    /// How far that is from its place, in spacings of its block.
    pub(crate) offset: Vec3,
}

impl Grid {
    /// The vertices as sites with the given outlooks, seeded by numbers from `first_seed` on.
    pub(crate) fn sites(&self, outlooks: &[Option<Outlook>], first_seed: u32) -> impl Iterator<Item = Site> {
        self.vertices.iter().zip(outlooks).zip(first_seed..).map(|((vertex, outlook), seed)| Site {
            seed,
            level: (vertex.at.x | vertex.at.y | vertex.at.z).trailing_zeros(),
            position: vertex.position,
            normal: Vec3::ZERO,
            outlook: *outlook,
        })
    }
}

/// Places the grid that the settings ask for.
pub(crate) fn place_grid(
    air: &Air<'_>,
    lit_sides: &LitSides,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Grid, BakeError> {
    let bounds = air.tracer().scene().bounds();
    let even =
        |spacing| place_vertices(air, lit_sides, GridPlan::even(lattice(&bounds, spacing, 1)), progress);
    match (settings.grid_spacing, settings.grid_vertices) {
        (Some(spacing), _) => even(spacing),
        (None, Some(vertices)) if bounds.size().min_element() == 0.0 => {
            even(even_spacing(&bounds, vertices as f32))
        }
        (None, Some(vertices)) => place_wanted(air, lit_sides, vertices, progress),
        (None, None) => Ok(Grid::default()),
    }
}

/// Places about as many vertices as wanted. How many of those planned have light is known when they are placed.
fn place_wanted(
    air: &Air<'_>,
    lit_sides: &LitSides,
    vertices: u32,
    progress: &dyn Progress,
) -> Result<Grid, BakeError> {
    let survey = Survey::of(air, lit_sides, vertices, progress)?;
    let (mut planned, mut best) = (vertices as f32, None::<(f32, Grid)>);
    for _ in 0..MOST_PLANS {
        let grid = place_vertices(air, lit_sides, GridPlan::best(&survey, planned), progress)?;
        let share = grid.vertices.len() as f32 / vertices as f32;
        planned /= share.max(0.1);
        let miss = share.ln().abs();
        if best.as_ref().is_none_or(|(least, _)| miss < *least) {
            best = Some((miss, grid));
        }
        if miss < MOST_MISSED {
            break;
        }
    }
    Ok(best.map_or_else(Grid::default, |(_, grid)| grid))
}

/// Places the vertices of a plan.
fn place_vertices(
    air: &Air<'_>,
    lit_sides: &LitSides,
    plan: GridPlan,
    progress: &dyn Progress,
) -> Result<Grid, BakeError> {
    let GridPlan { layout, levels, .. } = plan;
    let places: Vec<(UVec3, u32)> = places_by_block(&layout)
        .enumerate()
        .map(|(i, place)| (place, levels[i / PLACES_PER_BLOCK]))
        .collect();
    let look = |(at, level): (UVec3, u32)| place_vertex(air, lit_sides, &layout, at, level);
    let found = for_each_in_parallel("placing the grid", places.into_par_iter(), progress, look)?;
    let mut grid = Grid { layout, ..Grid::default() };
    for (block, level) in found.chunks(PLACES_PER_BLOCK).zip(levels) {
        let mask = mask_of(block);
        let first = grid.vertices.len() as u32;
        grid.blocks.push(GridBlock::new(mask, first, level));
        grid.vertices.extend(block.iter().flatten());
    }
    Ok(grid)
}

/// Which places of a block have something.
pub(crate) fn mask_of<T>(block: &[Option<T>]) -> u64 {
    (0..).zip(block).filter(|(_, found)| found.is_some()).fold(0, |mask, (bit, _)| mask | 1 << bit)
}

/// Places over some bounds, with at most the given distance between neighbours, so many that cells of the coarsest level
/// end at the bounds.
pub(crate) fn lattice(bounds: &Bounds, spacing: f32, levels: u32) -> GridLayout {
    let coarsest = (1 << (levels - 1)) as f32;
    let cells = (bounds.size() / (coarsest * spacing)).ceil().max(Vec3::ONE) * coarsest;
    GridLayout {
        origin: bounds.min,
        spacing: (bounds.size() / cells).max(Vec3::splat(f32::MIN_POSITIVE)),
        counts: cells.as_uvec3() + 1,
        levels,
    }
}

/// All places of whole blocks, block by block; some lie beyond the grid.
pub(crate) fn places_by_block(layout: &GridLayout) -> impl Iterator<Item = UVec3> {
    places_of(layout.blocks())
        .flat_map(move |block| places_of(UVec3::splat(BLOCK_EDGE)).map(move |at| block * BLOCK_EDGE + at))
}

/// A vertex where light is, at the nearest such place; of places equally near, the one with most space around it.
fn place_vertex(
    air: &Air<'_>,
    lit_sides: &LitSides,
    layout: &GridLayout,
    at: UVec3,
    level: u32,
) -> Option<Vertex> {
    if at.cmpge(layout.counts).any() || at % (1 << level) != UVec3::ZERO {
        return None;
    }
    let spacing = layout.at_level(level).spacing;
    let clearance = CLEARANCE * spacing.max_element();
    let look = |offset: Vec3| {
        let position = layout.position(at) + offset * spacing;
        let survey = air.place_for_light(position, lit_sides)?;
        (survey.clearance >= clearance).then_some((survey.clearance, Vertex { at, position, offset }))
    };
    if let Some((_, vertex)) = look(Vec3::ZERO) {
        return Some(vertex);
    }
    SHIFTS.into_iter().find_map(|shift| {
        let around = directions_around().map(|direction| look(direction * shift));
        around.flatten().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, vertex)| vertex)
    })
}

/// Unit directions to the faces, edges and corners of a cube.
fn directions_around() -> impl Iterator<Item = Vec3> {
    let axis = |i: u8| f32::from(i % 3) - 1.0;
    let all = (0..27u8).map(move |i| Vec3::new(axis(i), axis(i / 3), axis(i / 9)));
    all.filter(|d| *d != Vec3::ZERO).map(Vec3::normalize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_end_at_the_bounds_and_are_as_fine_as_asked_for() {
        let bounds = Bounds { min: Vec3::new(-1.0, 2.0, 0.5), max: Vec3::new(4.0, 2.0, 3.5) };
        for (levels, counts) in [(1, UVec3::new(9, 2, 6)), (2, UVec3::new(9, 3, 7)), (3, UVec3::new(9, 5, 9))]
        {
            let layout = lattice(&bounds, 0.7, levels);
            assert_eq!(layout.counts, counts);
            assert!(layout.spacing.cmple(Vec3::splat(0.7)).all());
            for level in 0..levels {
                let coarser = layout.at_level(level);
                assert!(coarser.position(coarser.counts - 1).abs_diff_eq(bounds.max, 1e-5));
            }
        }
    }

    #[test]
    fn places_come_in_the_order_of_blocks_and_their_bits() {
        let layout = GridLayout { counts: UVec3::new(9, 2, 6), ..GridLayout::default() };
        let places: Vec<(usize, u32)> = places_by_block(&layout).map(|at| layout.place(at)).collect();
        let expected = (0..layout.blocks().element_product() as usize)
            .flat_map(|block| (0..64).map(move |bit| (block, bit)));
        assert!(places.into_iter().eq(expected));
    }
}
