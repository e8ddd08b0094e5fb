//! How fine the grid in free space is where: as fine as the wanted number of vertices allows, and finest where surfaces,
//! and emitters above all, are near.
//!
//! What is interpolated over a distance h errs by about h² D, D being the second derivative of the light: the mean of
//! what shines over its distance squared, all around. The mean square of h² D is least for a given number of vertices,
//! the integral of h⁻³, where h is proportional to D^(-2/7); here it has only the few values that there are.

use probelight_asset::{BLOCK_EDGE, GridLayout, MAX_GRID_LEVELS, places_of};
use probelight_math::glam::{UVec3, Vec3};
use probelight_math::sampling::Rng;
use probelight_trace::Progress;
use rayon::prelude::*;

use crate::BakeError;
use crate::air::{Air, LightChanges, LitSides};
use crate::ground::grid::lattice;
use crate::steps::for_each_in_parallel;

/// Places that the finest spacing is chosen by.
const SCOUTS: usize = 4096;

/// Finest spacings that are tried: those of an even grid with as many vertices, divided by powers of √2.
const SPACINGS_TRIED: i32 = 7;

/// Surfaces count as no nearer than this, as a share of an even grid's spacing: what they send does not change as fast as
/// they come near, but for the edges of emitters.
const NEAREST: f32 = 1.0;

/// How h follows from D.
const EXPONENT: f32 = -2.0 / 7.0;

/// Parts of a block along each edge that are looked at.
const PARTS: u32 = 2;

/// Where the vertices of a grid may lie, and the level of each block.
#[derive(Clone, Debug)]
pub(crate) struct GridPlan {
    pub(crate) layout: GridLayout,
    pub(crate) levels: Vec<u32>,
}

/// Some of the air, where vertices are equally far apart.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// D there, 1/m²; 0 where no light is.
    change: f32,
    /// Vertices that it has at the finest level.
    vertices: f32,
}

impl GridPlan {
    /// All blocks have all vertices.
    pub(crate) fn even(layout: GridLayout) -> Self {
        Self { layout, levels: vec![0; layout.blocks().element_product() as usize] }
    }
}

/// The levels of blocks with which about as many vertices have light as wanted.
pub(crate) fn plan_levels(
    air: &Air<'_>,
    lit_sides: &LitSides,
    vertices: u32,
    progress: &dyn Progress,
) -> Result<GridPlan, BakeError> {
    let (bounds, vertices) = (air.tracer().scene().bounds(), vertices as f32);
    let volume = bounds.size().element_product();
    if volume == 0.0 {
        return Ok(GridPlan::even(lattice(&bounds, bounds.diagonal() / vertices.sqrt(), 1)));
    }
    let nearest = NEAREST * (volume / vertices).cbrt();
    let mut rng = Rng::new(0, 0);
    let scouts: Vec<Vec3> = (0..SCOUTS)
        .map(|_| bounds.min + Vec3::from_array(std::array::from_fn(|_| rng.next_f32())) * bounds.size())
        .collect();
    let look = |place: Vec3| air.light_changes(place, lit_sides, nearest);
    let scouts = for_each_in_parallel("planning the grid", scouts.into_par_iter(), progress, look)?;
    let seen: Vec<LightChanges> = scouts.into_iter().flatten().collect();
    let emission = seen.iter().map(|changes| changes.emission).sum::<f32>() / seen.len() as f32;
    // All surfaces may be as bright as emitters make them on the whole.
    let change = |changes: &LightChanges| {
        let of_emitters = if emission > 0.0 { changes.of_emitters / emission } else { 0.0 };
        changes.of_surfaces + of_emitters
    };
    let volume_each = volume / SCOUTS as f32;
    let changes: Vec<f32> = seen.iter().map(change).collect();
    let spacing = finest_spacing(&changes, volume_each, vertices);
    let layout = lattice(&bounds, spacing, MAX_GRID_LEVELS);
    let look = |place: Vec3| air.light_changes(place, lit_sides, nearest).as_ref().map(change);
    let blocks: Vec<UVec3> = places_of(layout.blocks()).collect();
    let look = |block: UVec3| look_at_block(&layout, block, look);
    let parts = for_each_in_parallel("surveying the grid", blocks.into_par_iter(), progress, look)?;
    let scale = scale_for(&parts, spacing, vertices);
    let levels = parts.iter().map(|part| part.level(scale, spacing)).collect();
    Ok(GridPlan { layout, levels })
}

/// The finest spacing with which blocks err least, by D at places evenly spread over the air, each for so much of it.
fn finest_spacing(changes: &[f32], volume_each: f32, vertices: f32) -> f32 {
    let even = (volume_each * changes.len() as f32 / vertices).cbrt();
    let rated = (0..SPACINGS_TRIED).filter_map(|step| {
        let spacing = even * 0.5f32.powf(0.5 * step as f32);
        let part = |change: &f32| Part { change: *change, vertices: volume_each / spacing.powi(3) };
        let parts: Vec<Part> = changes.iter().map(part).collect();
        let scale = scale_for(&parts, spacing, vertices);
        let error = |part: &Part| {
            let own = spacing * (1 << part.level(scale, spacing)) as f32;
            (own.powi(2) * part.change).powi(2)
        };
        let fits = total_vertices(&parts, scale, spacing) <= vertices;
        fits.then(|| (parts.iter().map(error).sum::<f32>(), spacing))
    });
    rated.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(even, |(_, spacing)| spacing)
}

/// What h is where D is 1, so that there are as many vertices as wanted.
fn scale_for(parts: &[Part], finest: f32, wanted: f32) -> f32 {
    let (mut fine, mut coarse) = (1e-6f32, 1e6f32);
    for _ in 0..50 {
        let middle = (fine * coarse).sqrt();
        if total_vertices(parts, middle, finest) > wanted { fine = middle } else { coarse = middle }
    }
    coarse
}

fn total_vertices(parts: &[Part], scale: f32, finest: f32) -> f32 {
    parts.iter().map(|part| part.vertices / (1u32 << (3 * part.level(scale, finest))) as f32).sum()
}

impl Part {
    /// The coarsest level whose vertices are no farther apart than h, or the finest.
    fn level(&self, scale: f32, finest: f32) -> u32 {
        let coarser = (scale * self.change.powf(EXPONENT) / finest).log2().floor();
        coarser.clamp(0.0, (MAX_GRID_LEVELS - 1) as f32) as u32
    }
}

/// What the parts of a block see, together. `look` tells D at a place where light is.
fn look_at_block(layout: &GridLayout, block: UVec3, look: impl Fn(Vec3) -> Option<f32>) -> Part {
    let edge = BLOCK_EDGE / PARTS;
    let mut whole = Part { change: 0.0, vertices: 0.0 };
    for part in places_of(UVec3::splat(PARTS)).map(|part| block * BLOCK_EDGE + edge * part) {
        // The grid may end in the block.
        let places = layout.counts.saturating_sub(part).min(UVec3::splat(edge));
        if places.cmpeq(UVec3::ZERO).any() {
            continue;
        }
        let middle = part.as_vec3() + 0.5 * (places - 1).as_vec3();
        if let Some(change) = look(layout.origin + middle * layout.spacing) {
            let vertices = places.as_vec3().element_product();
            whole.change += vertices * change;
            whole.vertices += vertices;
        }
    }
    whole.change /= whole.vertices.max(1.0);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_as_fine_as_their_surroundings_ask_for_and_as_many_vertices_as_wanted() {
        let parts: Vec<Part> =
            (1..=400u16).map(|i| Part { change: 4.0 / f32::from(i).powi(6), vertices: 64.0 }).collect();
        for wanted in [500.0, 3000.0, 12_000.0] {
            let scale = scale_for(&parts, 0.3, wanted);
            assert!(parts.iter().map(|part| part.level(scale, 0.3)).is_sorted());
            let count = total_vertices(&parts, scale, 0.3);
            assert!(count <= wanted && count > wanted - 64.0, "{count} of {wanted}");
        }
        // All as coarse, or as fine, as they can be.
        assert_eq!(total_vertices(&parts, scale_for(&parts, 0.3, 1.0), 0.3), 400.0);
        assert_eq!(total_vertices(&parts, scale_for(&parts, 0.3, 1e9), 0.3), 400.0 * 64.0);
    }

    #[test]
    fn a_room_in_a_wide_land_gets_a_finer_grid_than_an_even_one() {
        let scene =
            |rooms: usize| -> Vec<f32> { (0..1000).map(|i| if i < rooms { 1.0 } else { 1e-4 }).collect() };
        let even = (8000.0f32 / 4000.0).cbrt();
        assert!(finest_spacing(&scene(50), 8.0, 4000.0) < 0.6 * even);
        assert!(finest_spacing(&scene(1000), 8.0, 4000.0) > 0.49 * even);
    }

    #[test]
    fn blocks_that_the_grid_ends_in_have_fewer_vertices() {
        let layout = GridLayout { counts: UVec3::new(5, 8, 9), spacing: Vec3::ONE, ..GridLayout::default() };
        let whole = look_at_block(&layout, UVec3::ZERO, |_| Some(3.0));
        assert_eq!((whole.vertices, whole.change), (64.0, 3.0));
        let corner = look_at_block(&layout, UVec3::new(1, 0, 2), |place| (place.y < 2.0).then_some(1.0));
        assert_eq!((corner.vertices, corner.change), (2.0, 1.0));
    }
}
