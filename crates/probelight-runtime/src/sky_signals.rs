//! The sky's own signals: spherical-harmonics coefficients of its radiance.

use probelight_asset::BakedScene;
use probelight_math::directions::{spherical_fibonacci, weighted_basis};
use probelight_math::glam::Vec3;
use probelight_scene::Sky;

/// Directions of the quadrature: more than three for each of the 289 constraints that make the projection of
/// degree 8 exact for a sky of degree 8.
const DIRECTIONS: usize = 1024;

/// Projects a sky to the coefficients that are signals.
#[derive(Clone, Debug, Default)]
pub(crate) struct SkyProjection {
    directions: Vec<Vec3>,
    /// Weighted basis values, a direction's in a row.
    table: Vec<f32>,
}

impl SkyProjection {
    /// Tabulates the basis; empty for a scene without sky signals.
    pub(crate) fn new(baked: &BakedScene) -> Self {
        let Some(degree) = baked.settings.sky_degree else { return Self::default() };
        let directions: Vec<Vec3> = (0..DIRECTIONS).map(|i| spherical_fibonacci(i, DIRECTIONS)).collect();
        let table = weighted_basis(&directions, degree as usize);
        Self { directions, table }
    }

    /// Coefficients of the sky's radiance, W·m⁻²·sr⁻¹.
    pub(crate) fn project(&self, sky: &Sky, coefficients: &mut [Vec3]) {
        coefficients.fill(Vec3::ZERO);
        for (direction, row) in self.directions.iter().zip(self.table.chunks_exact(coefficients.len().max(1)))
        {
            let radiance = sky.radiance(*direction);
            for (coefficient, value) in coefficients.iter_mut().zip(row) {
                *coefficient += *value * radiance;
            }
        }
    }
}
