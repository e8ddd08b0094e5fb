//! Gather rays: what each site of a cluster sees.

use probelight_math::glam::Vec3;
use probelight_math::sampling::{hash_pair, sobol_owen};
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
    /// Value of the place's lobe along the direction.
    pub(crate) lobe: f32,
    /// Part of the place's lobe that it stands for, steradians; all of an estimate together are all of it.
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
                position: tracer.off_surface(self.origin + self.direction * hit.distance, hit.normal),
                normal: hit.normal,
            },
            None => GatherHit::Sky(self.direction),
        }
    }
}

/// `count` rays of a place, as dense as its lobe, in two halves. Each half starts from all of the place's points, those
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
            let origin = point.origin;
            let (direction, lobe) = point.lobe.draw(sobol_owen(number, sequence));
            GatherRay {
                point: point_index as u32,
                origin,
                direction,
                lobe,
                weight: point.lobe.total() / rays_in_half as f32,
                hit: tracer.closest_hit(&Ray::new(origin, direction)),
            }
        };
        half.enumerate().map(ray).collect()
    })
}
