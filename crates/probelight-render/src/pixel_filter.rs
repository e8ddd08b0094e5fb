//! Where a pixel's samples lie.

use std::f32::consts::TAU;

use probelight_math::glam::Vec2;

/// The reconstruction filter of a pixel. Samples are placed with the filter's density and averaged (Ernst,
/// Stamminger, Greiner 2006, *Filter importance sampling*), so that pixels do not depend on each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// The pixel's own square: what most references use.
    #[default]
    Box,
    /// A Gaussian of standard deviation 0.5 pixels, cut off at 1.5: smoother edges.
    Gaussian,
}

const GAUSSIAN_DEVIATION: f32 = 0.5;
const GAUSSIAN_RADIUS: f32 = 1.5;

impl PixelFilter {
    /// A sample's offset from the pixel's centre, pixels, from a point of the unit square.
    #[inline]
    pub fn offset_from_square(self, u: Vec2) -> Vec2 {
        match self {
            Self::Box => u - 0.5,
            Self::Gaussian => {
                // Inverts the radial distribution 1 − exp(−r²/2σ²), scaled to end at the radius.
                let two_variances = 2.0 * GAUSSIAN_DEVIATION * GAUSSIAN_DEVIATION;
                let inside = 1.0 - (-GAUSSIAN_RADIUS * GAUSSIAN_RADIUS / two_variances).exp();
                let radius = (-two_variances * (1.0 - u.x * inside).ln()).sqrt();
                radius * Vec2::from_angle(TAU * u.y)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::sampling::sobol_owen;

    fn moments(filter: PixelFilter) -> (Vec2, Vec2, f32) {
        let count = 4096;
        let offsets: Vec<Vec2> = (0..count).map(|i| filter.offset_from_square(sobol_owen(i, 1))).collect();
        let mean = offsets.iter().sum::<Vec2>() / count as f32;
        let variance = offsets.iter().map(|o| *o * *o).sum::<Vec2>() / count as f32;
        let farthest = offsets.iter().map(|o| o.length()).fold(0.0, f32::max);
        (mean, variance, farthest)
    }

    #[test]
    fn box_covers_the_pixel_evenly() {
        let (mean, variance, farthest) = moments(PixelFilter::Box);
        assert!(mean.abs().max_element() < 1e-3, "{mean}");
        assert!((variance - 1.0 / 12.0).abs().max_element() < 1e-3);
        assert!(farthest <= 0.5f32.sqrt());
    }

    #[test]
    fn gaussian_has_its_width_and_ends_at_its_radius() {
        let (mean, variance, farthest) = moments(PixelFilter::Gaussian);
        assert!(mean.abs().max_element() < 1e-3, "{mean}");
        // Cutting at 3σ takes σ² · (9/2) · e^(−9/2) / (1 − e^(−9/2)) off each axis' variance.
        let tail = (-4.5f32).exp();
        let expected = 0.25 * (1.0 - 4.5 * tail / (1.0 - tail));
        assert!((variance - expected).abs().max_element() < 2e-3, "{variance}");
        assert!(farthest <= GAUSSIAN_RADIUS);
    }
}
