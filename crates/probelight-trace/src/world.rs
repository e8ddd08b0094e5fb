//! A scene together with what moves through it.

use std::sync::Arc;

use probelight_scene::{Bounds, Object, Placement};

use crate::{Hit, Ray, Tracer};

/// What can stand between a surface and a light.
pub trait Occluder {
    /// Whether anything lies on the ray before its end.
    fn is_occluded(&self, ray: &Ray) -> bool;

    /// How far ray origins are moved off a surface along its normal, metres.
    fn offset(&self) -> f32;
}

impl Occluder for Tracer {
    #[inline]
    fn is_occluded(&self, ray: &Ray) -> bool {
        Tracer::is_occluded(self, ray)
    }

    #[inline]
    fn offset(&self) -> f32 {
        Tracer::offset(self)
    }
}

/// An object prepared for ray queries.
#[derive(Clone)]
pub struct TracedObject {
    tracer: Arc<Tracer>,
    placement: Placement,
    bounds: Bounds,
    light_offset: f32,
}

impl TracedObject {
    /// Prepares an object; `tracer` is one of its model.
    pub fn new(object: &Object, tracer: Arc<Tracer>) -> Self {
        let light_offset = object.light_offset();
        Self { tracer, placement: *object.placement(), bounds: object.bounds(), light_offset }
    }

    /// See [`Object::light_offset`].
    pub fn light_offset(&self) -> f32 {
        self.light_offset
    }

    /// The rays of its model.
    pub fn tracer(&self) -> &Arc<Tracer> {
        &self.tracer
    }

    /// Where it is.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The smallest box around it, metres, world space.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Whether the object lies on a world ray before its end.
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        meets(&self.bounds, ray) && self.tracer.is_occluded(&self.local(ray))
    }

    /// The nearest hit on a world ray: distance and normal in world space.
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if !meets(&self.bounds, ray) {
            return None;
        }
        let hit = self.tracer.closest_hit(&self.local(ray))?;
        let Self { placement, .. } = self;
        Some(Hit { distance: hit.distance * placement.scale, normal: placement.direction(hit.normal), ..hit })
    }

    fn local(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.placement.local_point(ray.origin),
            direction: self.placement.local_direction(ray.direction),
            max_distance: ray.max_distance / self.placement.scale,
        }
    }
}

/// Whether a ray meets a box before its end.
#[inline]
fn meets(bounds: &Bounds, ray: &Ray) -> bool {
    let inverse = ray.direction.recip();
    let (a, b) = ((bounds.min - ray.origin) * inverse, (bounds.max - ray.origin) * inverse);
    // Of a ray within a face's plane 0 · ∞ says nothing, and `min` and `max` leave out what is no number.
    let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    near <= far * (1.0 + 4.0 * f32::EPSILON) && near <= ray.max_distance
}

/// A scene together with what moves through it.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// What stands still.
    pub tracer: &'a Tracer,
    /// What moves.
    pub objects: &'a [TracedObject],
}

impl<'a> From<&'a Tracer> for World<'a> {
    /// A scene in which nothing moves.
    fn from(tracer: &'a Tracer) -> Self {
        Self { tracer, objects: &[] }
    }
}

/// The nearest surface along a ray.
#[derive(Clone, Copy, Debug)]
pub struct WorldHit {
    /// The hit; its triangle is one of the object's model, if there is an object.
    pub hit: Hit,
    /// Which of the objects was met, or `None` for the scene.
    pub object: Option<usize>,
}

impl World<'_> {
    /// The nearest hit along a ray, or `None` if it leaves the scene.
    pub fn closest_hit(&self, ray: &Ray) -> Option<WorldHit> {
        let mut nearest = self.tracer.closest_hit(ray).map(|hit| WorldHit { hit, object: None });
        for (index, object) in self.objects.iter().enumerate() {
            let max_distance = nearest.map_or(ray.max_distance, |nearest| nearest.hit.distance);
            if let Some(hit) = object.closest_hit(&Ray { max_distance, ..*ray }) {
                nearest = Some(WorldHit { hit, object: Some(index) });
            }
        }
        nearest
    }

    /// Whether an object lies on the ray before its end.
    #[inline]
    pub fn is_object_in_the_way(&self, ray: &Ray) -> bool {
        self.objects.iter().any(|object| object.is_occluded(ray))
    }
}

impl Occluder for World<'_> {
    #[inline]
    fn is_occluded(&self, ray: &Ray) -> bool {
        self.is_object_in_the_way(ray) || self.tracer.is_occluded(ray)
    }

    #[inline]
    fn offset(&self) -> f32 {
        self.tracer.offset()
    }
}
