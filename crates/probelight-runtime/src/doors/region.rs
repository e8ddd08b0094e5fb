//! The room around a door.

use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Ray, Tracer};

/// A ball that a door may move in.
pub(super) struct Region<'a> {
    pub(super) tracer: &'a Tracer,
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// How far rays go that meet nothing, metres.
    pub(super) far: f32,
}

impl Region<'_> {
    /// How far a ray from a place (off any surface) goes, with what it meets.
    pub(super) fn trace(&self, origin: Vec3, direction: Vec3) -> (f32, Option<Hit>) {
        let hit = self.tracer.closest_hit(&Ray::new(origin, direction));
        (hit.as_ref().map_or(self.far, |hit| hit.distance), hit)
    }

    /// Whether a ray in a unit direction enters it within a distance.
    pub(super) fn is_entered(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let offset = self.center - origin;
        let along = offset.dot(direction).clamp(0.0, distance);
        (offset - along * direction).length_squared() < self.radius * self.radius
    }

    /// Whether the way from one place to another leads through it.
    pub(super) fn is_between(&self, from: Vec3, to: Vec3) -> bool {
        let distance = from.distance(to);
        self.is_entered(from, (to - from) / distance.max(f32::MIN_POSITIVE), distance)
    }

    /// The cone that it fills as seen from a place: its axis (unit), and the cosine of half its angle; −1 from within.
    pub(super) fn cone_from(&self, origin: Vec3) -> (Vec3, f32) {
        let offset = self.center - origin;
        let sine_squared = self.radius * self.radius / offset.length_squared().max(f32::MIN_POSITIVE);
        let cosine = if sine_squared >= 1.0 { -1.0 } else { (1.0 - sine_squared).sqrt() };
        (offset.normalize_or(Vec3::Y), cosine)
    }
}
