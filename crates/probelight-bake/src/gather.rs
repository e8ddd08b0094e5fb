//! Gather rays: what each site of a cluster sees.

use probelight_math::glam::Vec3;
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_trace::{Hit, Ray, Tracer};

use crate::site::Place;

/// A gather ray and where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GatherRay {
    /// Start, metres.
    pub(crate) origin: Vec3,
    /// Unit.
    pub(crate) direction: Vec3,
    /// Cosine between the direction and the surface's normal at the start.
    pub(crate) cosine: f32,
    /// The surface it meets, or the sky.
    pub(crate) hit: Option<Hit>,
}

/// Where a gather ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GatherHit {
    /// On a surface; `position` is already moved off it along `normal`, which faces the receiver.
    Surface {
        /// Metres.
        position: Vec3,
        /// Unit.
        normal: Vec3,
    },
    /// In the sky, along the unit vector.
    Sky(Vec3),
}

impl GatherRay {
    /// Its end as probes see it.
    pub(crate) fn end(&self, tracer: &Tracer) -> GatherHit {
        match self.hit {
            Some(hit) => GatherHit::Surface {
                position: self.origin + self.direction * hit.distance + hit.normal * tracer.offset(),
                normal: hit.normal,
            },
            None => GatherHit::Sky(self.direction),
        }
    }
}

/// `count` cosine-distributed rays from the points of a place, those of each point in a row.
///
/// The samples are a scrambled (0,2)-sequence of the site's own: stratified within, independent
/// between sites, so that the compression averages their noise instead of keeping a pattern.
pub(crate) fn gather_rays(
    tracer: &Tracer,
    place: &Place<'_>,
    count: u32,
    seed: u64,
) -> impl Iterator<Item = GatherRay> {
    let sequence = hash_pair(place.site.seed, seed as u32 ^ (seed >> 32) as u32);
    let points = place.points;
    (0..count).map(move |ray| {
        let point = &points[ray as usize * points.len() / count as usize];
        let origin = point.ray_origin(tracer);
        let local = cosine_hemisphere_from_square(sobol_owen(ray, sequence));
        let direction = world_from_tangent(point.normal) * local;
        let cosine = local.z.max(f32::MIN_POSITIVE);
        GatherRay { origin, direction, cosine, hit: tracer.closest_hit(&Ray::new(origin, direction)) }
    })
}
