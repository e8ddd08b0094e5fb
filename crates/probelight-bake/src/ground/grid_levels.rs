//! How fine the grid in free space is where: finer in rooms than in the open, as fine as the wanted number of vertices
//! allows.
//!
//! What is interpolated over a distance h errs by about h² D, D being the second derivative of the light. Light changes
//! over distances as large as the space around, so that D is 1 / extent²; around emitters it is what they send over
//! distance squared, if all of what they send is as much as the rest. The mean square of h² D is least for a given
//! number of vertices, the integral of h⁻³, where h is proportional to D^(-2/7); here it has only the few values that
//! there are. Beside a coarser block a finer one gains less, as cells between them are the coarser one's, too: of all
//! finest spacings the one is chosen that errs least with that in mind, which mostly leaves whole rooms at one level.

use probelight_asset::{BLOCK_EDGE, GridLayout, MAX_GRID_LEVELS, index_of, places_of};
use probelight_math::glam::{UVec3, Vec3};
use probelight_scene::Bounds;
use probelight_trace::Progress;
use rayon::prelude::*;

use crate::BakeError;
use crate::air::{Air, LitSides, Surroundings};
use crate::ground::grid::lattice;
use crate::options::even_spacing;
use crate::steps::for_each_in_parallel;

/// Distance between the places whose surroundings are looked at, as a share of an even grid's spacing.
const SURVEY_SPACING: f32 = 0.6;

/// Finest spacings that are tried, each so much finer than the last; the first is that of an even grid with as many vertices.
const SPACINGS_TRIED: i32 = 16;
const SPACING_STEP: f32 = 0.87;

/// Spaces count as no larger than this, as a share of the scene's diagonal.
const LARGEST_EXTENT: f32 = 0.25;

/// How h follows from the extent.
const EXPONENT: f32 = 4.0 / 7.0;

/// Parts of a block along each edge that are looked at.
const PARTS: u32 = 2;

/// Where the vertices of a grid may lie, and what its levels follow from.
#[derive(Clone, Debug)]
pub(crate) struct GridPlan {
    pub(crate) layout: GridLayout,
    /// The level of each block.
    pub(crate) levels: Vec<u32>,
    blocks: Vec<Block>,
}

/// What a block of the grid sees.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// Mean of D² where light is, 1/m⁴.
    change: f32,
    /// Places that it has at the finest level, if light is at any; vertices inside solids move out if they can.
    vertices: f32,
}

/// Places spread evenly over the scene's bounds, in the middle of a lattice's cells.
pub(crate) struct Survey {
    bounds: Bounds,
    lattice: GridLayout,
    /// D² at each, 1/m⁴, if light is there.
    changes: Vec<Option<f32>>,
}

impl GridPlan {
    /// All blocks have all vertices.
    pub(crate) fn even(layout: GridLayout) -> Self {
        let levels = vec![0; layout.blocks().element_product() as usize];
        Self { layout, levels, blocks: Vec::new() }
    }

    /// The one with which light is likely to be read best from about so many vertices.
    pub(crate) fn best(survey: &Survey, vertices: f32) -> Self {
        let even = even_spacing(&survey.bounds, vertices);
        let with_spacing = |step: i32| {
            let plan = Self::with_finest(survey, even * SPACING_STEP.powi(step), vertices);
            let fits = plan.total_vertices(&plan.levels) <= vertices;
            fits.then(|| (plan.error(), plan))
        };
        let tried: Vec<Option<(f32, Self)>> = (0..SPACINGS_TRIED).into_par_iter().map(with_spacing).collect();
        let best = tried.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(|| Self::even(lattice(&survey.bounds, even, 1)), |(_, plan)| plan)
    }

    /// With a finest spacing (metres), and levels for about so many vertices: none is two levels coarser than one beside it.
    fn with_finest(survey: &Survey, spacing: f32, vertices: f32) -> Self {
        let layout = lattice(&survey.bounds, spacing, MAX_GRID_LEVELS);
        let blocks = places_of(layout.blocks()).map(|block| survey.look_at_block(&layout, block)).collect();
        let mut plan = Self { layout, blocks, levels: Vec::new() };
        let (mut fine, mut coarse) = (1e-6f32, 1e6f32);
        for _ in 0..40 {
            let middle = (fine * coarse).sqrt();
            if plan.total_vertices(&plan.levels_at(middle)) > vertices {
                fine = middle;
            } else {
                coarse = middle;
            }
        }
        plan.levels = plan.levels_at(coarse);
        plan
    }

    /// The levels where h is `scale` if D is 1: the coarsest whose vertices are no farther apart than h.
    fn levels_at(&self, scale: f32) -> Vec<u32> {
        let finest = self.layout.spacing.max_element();
        let level = |block: &Block| {
            let coarser = (scale * block.change.powf(-0.25 * EXPONENT) / finest).log2().floor();
            coarser.clamp(0.0, (MAX_GRID_LEVELS - 1) as f32) as u32
        };
        let mut levels: Vec<u32> = self.blocks.iter().map(level).collect();
        for finer in 0..MAX_GRID_LEVELS - 1 {
            let before = levels.clone();
            let is_beside = |at| self.blocks_around(at).any(|beside| before[beside] == finer);
            for (level, at) in levels.iter_mut().zip(places_of(self.layout.blocks())) {
                if *level > finer + 1 && is_beside(at) {
                    *level = finer + 1;
                }
            }
        }
        levels
    }

    fn total_vertices(&self, levels: &[u32]) -> f32 {
        let count = |(block, level): (&Block, &u32)| block.vertices / (1u32 << (3 * level)) as f32;
        self.blocks.iter().zip(levels).map(count).sum()
    }

    /// Sum of the squared errors.
    fn error(&self) -> f32 {
        let finest = self.layout.spacing.max_element();
        let error = |(block, at): (&Block, UVec3)| {
            let around: Vec<usize> = self.blocks_around(at).collect();
            let spacing = |block: &usize| finest * (1 << self.levels[*block]) as f32;
            let mean = around.iter().map(|beside| spacing(beside).powi(4)).sum::<f32>() / around.len() as f32;
            block.vertices * block.change * mean
        };
        let volume_each = self.layout.spacing.element_product();
        volume_each * self.blocks.iter().zip(places_of(self.layout.blocks())).map(error).sum::<f32>()
    }

    /// A block and those beside it.
    fn blocks_around(&self, block: UVec3) -> impl Iterator<Item = usize> {
        let size = self.layout.blocks();
        let beside = places_of(UVec3::splat(3)).map(move |step| (block + step).wrapping_sub(UVec3::ONE));
        beside.filter(move |at| at.cmplt(size).all()).map(move |at| index_of(size, at))
    }
}

impl Survey {
    /// Looks at a scene's air for a grid of about so many vertices.
    pub(crate) fn of(
        air: &Air<'_>,
        lit_sides: &LitSides,
        vertices: u32,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let bounds = air.tracer().scene().bounds();
        let spacing = SURVEY_SPACING * even_spacing(&bounds, vertices as f32);
        let lattice = lattice(&bounds, spacing, 1);
        let places: Vec<UVec3> = places_of(lattice.counts - 1).collect();
        let nearest = 0.5 * lattice.spacing.max_element();
        let look = |place: UVec3| {
            air.surroundings(lattice.position(place) + 0.5 * lattice.spacing, lit_sides, nearest)
        };
        let seen = for_each_in_parallel("surveying the grid", places.into_par_iter(), progress, look)?;
        let lit = seen.iter().flatten();
        let emission = lit.clone().map(|place| place.emission).sum::<f32>() / lit.count().max(1) as f32;
        let farthest = LARGEST_EXTENT * bounds.diagonal();
        let change = |place: &Surroundings| {
            let of_emitters = if emission > 0.0 { place.emission_change / emission } else { 0.0 };
            (place.extent.min(farthest).powi(-2) + of_emitters).powi(2)
        };
        Ok(Self { bounds, lattice, changes: seen.iter().map(|place| place.as_ref().map(change)).collect() })
    }

    /// D² at the nearest place to a position.
    fn change_at(&self, position: Vec3) -> Option<f32> {
        let cells = self.lattice.counts - 1;
        let cell = ((position - self.lattice.origin) / self.lattice.spacing).max(Vec3::ZERO).as_uvec3();
        self.changes[index_of(cells, cell.min(cells - 1))]
    }

    fn look_at_block(&self, layout: &GridLayout, block: UVec3) -> Block {
        let edge = BLOCK_EDGE / PARTS;
        let first = block * BLOCK_EDGE;
        let parts = places_of(UVec3::splat(PARTS)).map(|part| first + edge * part);
        // The grid may end in the block.
        let parts = parts.filter(|part| part.cmplt(layout.counts).all());
        let middle = |part: UVec3| {
            let places = (layout.counts - part).min(UVec3::splat(edge));
            layout.position(part) + 0.5 * (places - 1).as_vec3() * layout.spacing
        };
        let changes: Vec<f32> = parts.filter_map(|part| self.change_at(middle(part))).collect();
        if changes.is_empty() {
            return Block::default();
        }
        let places = (layout.counts - first).min(UVec3::splat(BLOCK_EDGE));
        Block {
            change: changes.iter().sum::<f32>() / changes.len() as f32,
            vertices: places.as_vec3().element_product(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A land 60 m wide, with D² by the distance from one corner.
    fn land(change: impl Fn(f32) -> f32) -> Survey {
        let bounds = Bounds { min: Vec3::ZERO, max: Vec3::new(60.0, 4.0, 60.0) };
        let lattice = lattice(&bounds, 0.5, 1);
        let change = |place: UVec3| Some(change(lattice.position(place).max_element()));
        Survey { changes: places_of(lattice.counts - 1).map(change).collect(), bounds, lattice }
    }

    /// With rooms of some width in that corner.
    fn land_with_rooms(room: f32, change_outside: f32) -> Survey {
        land(|distance| if distance < room { 1.0 } else { change_outside })
    }

    #[test]
    fn as_many_vertices_as_wanted_lie_where_light_changes_most() {
        let survey = land(|distance| (1.0 + distance).powi(-4));
        for wanted in [5000.0, 20_000.0] {
            let plan = GridPlan::with_finest(&survey, 0.5, wanted);
            let count = plan.total_vertices(&plan.levels);
            assert!(count <= wanted && count > 0.8 * wanted, "{count} of {wanted}");
            let mean = |is_inside: bool| {
                let blocks = places_of(plan.layout.blocks()).zip(&plan.levels);
                let levels: Vec<u32> = blocks
                    .filter(|(at, _)| (plan.layout.position(*at * 4 + 2).max_element() < 12.0) == is_inside)
                    .map(|(_, level)| *level)
                    .collect();
                levels.iter().sum::<u32>() as f32 / levels.len() as f32
            };
            assert!(mean(true) < mean(false) - 0.5, "{} and {}", mean(true), mean(false));
        }
        // All as coarse, or as fine, as they can be.
        assert!(
            GridPlan::with_finest(&survey, 0.5, 1.0).levels.iter().all(|level| *level == MAX_GRID_LEVELS - 1)
        );
        assert!(GridPlan::with_finest(&survey, 0.5, 1e9).levels.iter().all(|level| *level == 0));
    }

    #[test]
    fn the_best_plan_has_rooms_finer_than_an_even_grid_and_the_land_coarser() {
        let survey = land_with_rooms(12.0, 1e-3);
        let best = GridPlan::best(&survey, 8000.0);
        let spacing_at = |place: Vec3| {
            let (block, _) = best.layout.place((place / best.layout.spacing).as_uvec3());
            best.layout.at_level(best.levels[block]).spacing.max_element()
        };
        let even = even_spacing(&survey.bounds, 8000.0);
        assert!(spacing_at(Vec3::new(5.0, 1.0, 5.0)) < 0.8 * even);
        assert!(spacing_at(Vec3::new(40.0, 1.0, 40.0)) > 1.1 * even);
        // Negative control: where light changes alike everywhere, no place gains.
        let alike = GridPlan::best(&land_with_rooms(60.0, 1.0), 8000.0);
        assert!(alike.levels.iter().all(|level| *level == alike.levels[0]));
    }

    #[test]
    fn levels_of_blocks_beside_each_other_differ_by_one_at_most() {
        let plan = GridPlan::with_finest(&land_with_rooms(5.0, 1e-8), 0.4, 9000.0);
        let is_even = |at| {
            let own = plan.levels[index_of(plan.layout.blocks(), at)];
            plan.blocks_around(at).all(|beside| plan.levels[beside].abs_diff(own) <= 1)
        };
        assert!((0..3).all(|level| plan.levels.contains(&level)));
        assert!(places_of(plan.layout.blocks()).all(is_even));
    }

    #[test]
    fn a_finer_block_beside_coarser_ones_errs_as_a_mean_of_them() {
        let all_fine = GridPlan::with_finest(&land_with_rooms(60.0, 1.0), 0.5, 1e9);
        let error = |levels: Vec<u32>| GridPlan { levels, ..all_fine.clone() }.error();
        let blocks = all_fine.blocks.len();
        let mut one_fine = vec![1; blocks];
        one_fine[blocks / 2] = 0;
        let [fine, coarse] = [0, 1].map(|level| error(vec![level; blocks]));
        assert!((coarse / fine - 16.0).abs() < 1e-3);
        assert!(error(one_fine.clone()) < coarse && error(one_fine) > 0.99 * coarse);
    }

    #[test]
    fn blocks_that_the_grid_ends_in_have_fewer_vertices() {
        let layout = GridLayout { counts: UVec3::new(5, 8, 9), spacing: Vec3::ONE, ..GridLayout::default() };
        let cells = layout.counts - 1;
        let lattice = GridLayout { levels: 1, ..layout };
        let bounds = Bounds { min: Vec3::ZERO, max: cells.as_vec3() };
        let all_lit = Survey { bounds, lattice, changes: vec![Some(3.0); cells.element_product() as usize] };
        let whole = all_lit.look_at_block(&layout, UVec3::ZERO);
        assert_eq!((whole.vertices, whole.change), (64.0, 3.0));
        let is_low = |place: UVec3| (place.y < 2).then_some(1.0);
        let low = Survey { bounds, lattice, changes: places_of(cells).map(is_low).collect() };
        let corner = low.look_at_block(&layout, UVec3::new(1, 0, 2));
        assert_eq!((corner.vertices, corner.change), (4.0, 1.0));
        assert_eq!(low.look_at_block(&layout, UVec3::new(0, 1, 0)).vertices, 0.0);
    }
}
