//! The scale of a scene: the one place where lengths come from.
//!
//! Files do not tell whether their numbers are metres or millimetres, and a bake must not depend on it. So every
//! default length is a multiple of one of these: how far light travels between surfaces, what the receivers asked for
//! leave to each, or, where a length is known in metres only, the unit that the scene seems to be built in.

use probelight_math::sampling::{Rng, cosine_hemisphere_from_square, sobol_owen, world_from_tangent};
use probelight_trace::{Ray, Tracer};
use rayon::prelude::*;

use crate::surface_samples::sample_front_faces;

/// Rays that measure free distances.
const RAYS: usize = 4096;

/// The smallest lower quartile of the free distances that a scene built in metres has, metres: the lower quartiles of
/// rooms, streets and halls lie between 0.4 and 2.
const SMALLEST_QUARTILE: f32 = 0.3;

/// And the largest: squares and valleys have some 10 metres.
const LARGEST_QUARTILE: f32 = 30.0;

/// Diagonal from which on a scene is no smaller than a room in metres, however close its surfaces are (a square full
/// of small things), metres.
const LARGE_DIAGONAL: f32 = 30.0;

/// Voxels near surfaces that any scene may have, and those that come on top for each receiver.
const FEWEST_PLACES: f64 = 500_000.0;
const PLACES_PER_RECEIVER: f64 = 10.0;

/// Layers of voxels near each surface.
const LAYERS: f64 = 8.0;

/// What the lengths of a bake follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Median distance that light travels from a surface to the next; a third of the scene's diagonal where no surface
    /// sees another.
    pub(crate) free_distance: f32,
    /// A metre, if the scene is as large as rooms and landscapes are in metres; else the power of ten that makes it as
    /// large as rooms.
    pub(crate) unit: f32,
    /// Area of all triangles.
    pub(crate) area: f64,
}

impl Scale {
    pub(crate) fn of(tracer: &Tracer) -> Self {
        let mut distances = free_distances(tracer);
        if distances.is_empty() {
            distances.push(tracer.scene().bounds().diagonal() / 3.0);
        }
        distances.sort_by(f32::total_cmp);
        let lower_quartile = distances[distances.len() / 4];
        let diagonal = tracer.scene().bounds().diagonal();
        Self {
            free_distance: distances[distances.len() / 2],
            unit: unit_of(lower_quartile, diagonal),
            area: tracer.scene().surface_area(),
        }
    }

    /// Edge of the voxels in which open air is looked for, in a scene of about so many receivers: the one that is
    /// `wanted`, or a larger one, so that the work follows what was asked for, however large the scene is.
    pub(crate) fn voxel_size(&self, wanted: f32, receivers: f64) -> f32 {
        let places = FEWEST_PLACES + PLACES_PER_RECEIVER * receivers;
        wanted.max((LAYERS * self.area / places).sqrt() as f32)
    }
}

/// See [`Scale::unit`].
fn unit_of(lower_quartile: f32, diagonal: f32) -> f32 {
    let size = (lower_quartile / SMALLEST_QUARTILE).max((diagonal / LARGE_DIAGONAL).min(1.0));
    if (1.0..LARGEST_QUARTILE / SMALLEST_QUARTILE).contains(&size) {
        return 1.0;
    }
    10f32.powi(size.log10().floor() as i32)
}

/// How far light travels from random surface points to the front of the next surface.
fn free_distances(tracer: &Tracer) -> Vec<f32> {
    let samples = sample_front_faces(tracer.scene(), RAYS, &mut Rng::new(0, 17));
    samples
        .par_iter()
        .enumerate()
        .filter_map(|(i, sample)| {
            let local = cosine_hemisphere_from_square(sobol_owen(i as u32, 23));
            let ray = Ray::new(
                tracer.off_surface(sample.position, sample.normal),
                world_from_tangent(sample.normal) * local,
            );
            tracer.closest_hit(&ray).filter(|hit| !hit.is_back_face).map(|hit| hit.distance)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use probelight_scene::load_gltf;

    use super::*;

    fn scale_of(name: &str, factor: f32) -> Scale {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name);
        let mut scene = load_gltf(&path).unwrap();
        scene.positions.iter_mut().for_each(|position| *position *= factor);
        Scale::of(&Tracer::new(Arc::new(scene)))
    }

    #[test]
    fn rooms_are_taken_to_be_in_metres_and_the_same_in_other_units() {
        for name in ["cornell.glb", "rooms.glb", "furnace.glb"] {
            let metres = scale_of(name, 1.0);
            assert_eq!(metres.unit, 1.0, "{name}");
            for (factor, power) in [(1e-3, -3), (1e-1, -1), (1e2, 2), (1e3, 3)] {
                let other = scale_of(name, factor);
                assert_eq!(other.unit, 10f32.powi(power), "{name} times {factor}");
                let ratio = other.free_distance / (metres.free_distance * factor);
                assert!((ratio - 1.0).abs() < 1e-2, "{name} times {factor}: {ratio}");
            }
        }
        assert_eq!(scale_of("cornell.glb", 10.0).unit, 1.0, "halls are in metres, too");
    }

    #[test]
    fn small_things_far_apart_do_not_make_a_scene_small() {
        assert_eq!([1.0, 50.0, 5e3].map(|diagonal| unit_of(0.1, diagonal)), [0.1, 1.0, 1.0]);
        assert_eq!([1.0, 29.0, 31.0].map(|quartile| unit_of(quartile, 1e3)), [1.0, 1.0, 100.0]);
    }

    #[test]
    fn voxels_grow_where_there_would_be_too_many() {
        let scale = Scale { free_distance: 3.0, unit: 1.0, area: 1000.0 };
        assert_eq!(scale.voxel_size(0.5, 1000.0), 0.5);
        let vast = Scale { area: 1e8, ..scale };
        let [few, many] = [3e3, 3e5].map(|receivers| vast.voxel_size(0.5, receivers));
        assert!(few > many && many > 0.5);
        let places = LAYERS * vast.area / f64::from(few).powi(2);
        assert!((places / (FEWEST_PLACES + 3e3 * PLACES_PER_RECEIVER) - 1.0).abs() < 1e-3);
    }
}
