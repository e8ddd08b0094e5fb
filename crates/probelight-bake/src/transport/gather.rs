//! Gather rays: what each site of a cluster sees.

use std::f32::consts::PI;

use probelight_math::glam::Vec3;
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_trace::{Hit, Ray, Tracer};

use crate::ground::site::Place;

/// A gather ray and where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GatherRay {
    /// Which of the place's points it starts from.
    pub(crate) point: u32,
    /// Start, metres.
    pub(crate) origin: Vec3,
    /// Unit.
    pub(crate) direction: Vec3,
    /// Cosine between the direction and the surface's normal at the start.
    pub(crate) cosine: f32,
    /// Share of the irradiance that it stands for, steradians; all of an estimate together have π.
    pub(crate) weight: f32,
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

/// `count` cosine-distributed rays of a place, in two halves. Each half starts from all of the place's points, those
/// of each point in a row, so that the halves differ by noise only.
///
/// The samples are a scrambled (0,2)-sequence of the site's own: stratified within, independent
/// between sites, so that the compression averages their noise instead of keeping a pattern.
pub(crate) fn gather_rays(tracer: &Tracer, place: &Place<'_>, count: u32, seed: u64) -> [Vec<GatherRay>; 2] {
    let sequence = hash_pair(place.site.seed, seed as u32 ^ (seed >> 32) as u32);
    let middle = count / 2;
    [0..middle, middle..count].map(|half| {
        let rays_in_half = half.len();
        let ray = |(i, number): (usize, u32)| {
            let point_index = i * place.points.len() / rays_in_half;
            let point = &place.points[point_index];
            let origin = point.ray_origin(tracer);
            let local = cosine_hemisphere_from_square(sobol_owen(number, sequence));
            let direction = world_from_tangent(point.normal) * local;
            GatherRay {
                point: point_index as u32,
                origin,
                direction,
                cosine: local.z.max(f32::MIN_POSITIVE),
                weight: PI / rays_in_half as f32,
                hit: tracer.closest_hit(&Ray::new(origin, direction)),
            }
        };
        half.enumerate().map(ray).collect()
    })
}
