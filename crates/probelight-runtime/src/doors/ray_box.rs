//! Boxes of objects, and what crosses them.

use probelight_math::glam::Vec3;
use probelight_scene::{Bounds, Object, Placement};

/// The box of an object's model, where the object is.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedBox {
    bounds: Bounds,
    placement: Placement,
}

impl PlacedBox {
    pub(super) fn of(object: &Object) -> Self {
        Self { bounds: *object.model_bounds(), placement: *object.placement() }
    }

    /// Its middle, world space.
    pub(super) fn center(&self) -> Vec3 {
        self.placement.point(0.5 * (self.bounds.min + self.bounds.max))
    }

    /// Its diagonal, metres.
    pub(super) fn diagonal(&self) -> f32 {
        self.bounds.diagonal() * self.placement.scale
    }

    /// Where the way from one point to another, which counts from 0 to 1, enters the box, and the unit normal of the face there.
    /// `None` if it does not; a way that begins inside enters at once, through no face.
    pub(super) fn entry(&self, from: Vec3, to: Vec3) -> Option<(f32, Vec3)> {
        let origin = self.placement.local_point(from);
        let way = self.placement.local_point(to) - origin;
        let (mut enter, mut leave, mut face) = (0f32, 1f32, Vec3::ZERO);
        for axis in 0..3 {
            let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
            if way[axis].abs() < f32::MIN_POSITIVE {
                if origin[axis] < min || origin[axis] > max {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min - origin[axis]) / way[axis], (max - origin[axis]) / way[axis]);
            if a.min(b) > enter {
                enter = a.min(b);
                face = Vec3::ZERO;
                face[axis] = -way[axis].signum();
            }
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then(|| (enter, self.placement.direction(face)))
    }

    /// Whether the way from one point to another leads through the box.
    pub(super) fn crosses(&self, from: Vec3, to: Vec3) -> bool {
        self.entry(from, to).is_some()
    }
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Quat;

    use super::*;

    fn panel() -> PlacedBox {
        PlacedBox {
            bounds: Bounds { min: Vec3::new(0.0, 0.0, -0.02), max: Vec3::new(0.9, 2.0, 0.02) },
            placement: Placement { rotation: Quat::from_rotation_y(0.5), ..Placement::at(Vec3::X) },
        }
    }

    #[test]
    fn ways_through_a_turned_panel_cross_it() {
        let panel = panel();
        let point = |x: f32, y: f32, z: f32| panel.placement.point(Vec3::new(x, y, z));
        let (at, face) = panel.entry(point(0.4, 1.0, 1.02), point(0.4, 1.0, -0.98)).unwrap();
        assert!((at - 0.5).abs() < 1e-5 && face.abs_diff_eq(panel.placement.direction(Vec3::Z), 1e-5));
        assert!(panel.crosses(point(0.4, 1.0, -1.0), point(0.5, 0.5, 1.0)));
        // Beside it, over it, before it.
        assert!(!panel.crosses(point(1.0, 1.0, -1.0), point(1.0, 1.0, 1.0)));
        assert!(!panel.crosses(point(0.4, 2.1, -1.0), point(0.4, 2.1, 1.0)));
        assert!(!panel.crosses(point(0.4, 1.0, 2.0), point(0.4, 1.0, 1.0)));
        assert!(!panel.crosses(point(1.0, 1.0, 0.0), point(2.0, 1.0, 0.0)));
    }
}
