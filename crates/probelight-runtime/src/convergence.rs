//! When light stands still.

use probelight_math::glam::Vec3;

/// How a runtime's `converge` ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Frames computed.
    pub steps: usize,
    /// Relative change of the receivers' irradiance in the last frame (root mean square). Bounces fade
    /// geometrically: where each keeps a share q of the one before, what is still missing is about
    /// `change · q / (1 − q)`.
    pub change: f64,
}

/// Root-mean-square difference relative to the root mean square of `now`; 0 if both are dark.
pub(crate) fn relative_change(before: &[Vec3], now: &[Vec3]) -> f64 {
    let (mut difference, mut total) = (0.0, 0.0);
    for (before, now) in before.iter().zip(now) {
        difference += (*now - *before).as_dvec3().length_squared();
        total += now.as_dvec3().length_squared();
    }
    if difference == 0.0 { 0.0 } else { (difference / total).sqrt() }
}
