//! Where something lies as seen from a view.

use probelight_math::glam::Vec3;
use probelight_scene::Bounds;

use super::input::View;

/// Distance and direction of something from a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    /// To its nearest part, metres; 0 for what counts as near.
    pub(super) distance: f32,
    /// Cosine of the angle between the view direction and the part of it that lies nearest to that direction.
    pub(super) cosine: f32,
}

impl Sight {
    /// Of what is as near as anything can be.
    pub(super) const NEAR: Self = Self { distance: 0.0, cosine: 1.0 };

    /// Of a box.
    pub(super) fn of_box(view: View, bounds: &Bounds) -> Self {
        let (center, radius) = (bounds.min.midpoint(bounds.max), 0.5 * bounds.diagonal());
        Self { distance: bounds.distance(view.position), cosine: widened_cosine(view, center, radius) }
    }

    /// Of a ball.
    pub(super) fn of_ball(view: View, center: Vec3, radius: f32) -> Self {
        let distance = ((view.position - center).length() - radius).max(0.0);
        Self { distance, cosine: widened_cosine(view, center, radius) }
    }
}

/// Cosine of the angle between the view direction and the part of a ball that is nearest to that direction. A view
/// without a direction has everything in front.
fn widened_cosine(view: View, center: Vec3, radius: f32) -> f32 {
    let to_center = center - view.position;
    let distance = to_center.length();
    if distance <= radius || view.direction == Vec3::ZERO {
        return 1.0;
    }
    let cosine = (view.direction.dot(to_center) / distance).clamp(-1.0, 1.0);
    let half_sine = radius / distance;
    let half_cosine = (1.0 - half_sine * half_sine).max(0.0).sqrt();
    if cosine >= half_cosine {
        return 1.0;
    }
    // cos(a − b) with the angle a to the centre and half the angle b under which the ball is seen.
    cosine * half_cosine + (1.0 - cosine * cosine).max(0.0).sqrt() * half_sine
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_1_SQRT_2;

    const VIEW: View = View { position: Vec3::X, direction: Vec3::Z };

    #[test]
    fn points_have_their_own_direction() {
        let sight = |x: f32, y, z| Sight::of_ball(VIEW, Vec3::new(1.0 + x, y, z), 0.0);
        assert_eq!(sight(0.0, 0.0, 5.0), Sight { distance: 5.0, cosine: 1.0 });
        assert_eq!(sight(0.0, 5.0, 0.0).cosine, 0.0);
        assert_eq!(sight(0.0, 0.0, -5.0).cosine, -1.0);
        assert!((sight(3.0, 0.0, 3.0).cosine - FRAC_1_SQRT_2).abs() < 1e-6);
    }

    #[test]
    fn balls_reach_from_one_zone_into_another() {
        // Beside the view, as wide as half a right angle on each side.
        let radius = 5.0 * FRAC_1_SQRT_2;
        let beside = Sight::of_ball(VIEW, Vec3::new(6.0, 0.0, 0.0), radius);
        assert!(
            (beside.cosine - FRAC_1_SQRT_2).abs() < 1e-6 && (beside.distance - 5.0 + radius).abs() < 1e-6
        );
        assert_eq!(Sight::of_ball(VIEW, Vec3::new(2.0, 0.0, 0.0), 3.0), Sight::NEAR);
        assert_eq!(Sight::of_ball(VIEW, Vec3::new(1.0, 1.0, 5.0), 1.5).cosine, 1.0);
    }

    #[test]
    fn views_without_a_direction_have_everything_in_front() {
        let view = View { direction: Vec3::ZERO, ..VIEW };
        assert_eq!(Sight::of_ball(view, -Vec3::Z * 9.0, 1.0).cosine, 1.0);
    }
}
