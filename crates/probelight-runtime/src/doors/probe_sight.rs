//! What a probe sees in the direction of a door.

use probelight_asset::{BakedScene, NONE};
use probelight_math::glam::Vec3;
use probelight_math::sampling::{hash_pair, unit_from_bits};

use super::Shut;
use super::open_ways::OpenWays;
use super::region::Region;

/// Rays that are asked, one after the other, to stand for what a door reflects.
const STAND_INS: u32 = 24;

/// The rays of a probe that reach the room around a door.
#[derive(Debug)]
pub(super) struct ProbeSight {
    probe: u32,
    /// Numbers of the rays, and how far they go, metres.
    rays: Vec<(u32, f32)>,
}

impl ProbeSight {
    pub(super) fn of(baked: &BakedScene, region: &Region<'_>, probe: u32) -> Option<Self> {
        let origin = baked.probes[probe as usize].position;
        let ray = |(number, direction): (u32, &Vec3)| {
            // Most rays point elsewhere.
            let distance = region
                .is_entered(origin, *direction, region.far)
                .then(|| region.trace(origin, *direction).0)?;
            region.is_entered(origin, *direction, distance).then_some((number, distance))
        };
        let rays: Vec<_> = (0..).zip(&baked.relight_directions).filter_map(ray).collect();
        (!rays.is_empty()).then_some(Self { probe, rays })
    }

    /// Lets rays that meet the door see what it reflects. A matt door shows a mean of all that lies on its side; each of its
    /// rays takes one sample of that, which is what the probe sees by another of its rays.
    pub(super) fn shut(&self, baked: &BakedScene, door: Shut, ways: &mut OpenWays) {
        let origin = baked.probes[self.probe as usize].position;
        let seen = &baked.relight_surfels[baked.rays_of(self.probe as usize)];
        for (ray, distance) in &self.rays {
            let end = origin + *distance * baked.relight_directions[*ray as usize];
            let Some((_, face)) = door.shape.entry(origin, end) else { continue };
            let stand_in = |attempt: u32| {
                let bits = hash_pair(hash_pair(*ray, self.probe), attempt);
                let other = bits as usize % seen.len();
                let cosine = baked.relight_directions[other].dot(face);
                let is_chosen = unit_from_bits(hash_pair(bits, 1)) < cosine && seen[other] != NONE;
                is_chosen.then_some(seen[other])
            };
            let (surfel, share) = match (0..STAND_INS).find_map(stand_in) {
                Some(surfel) => (surfel, door.albedo),
                None => (seen[*ray as usize], 0.0),
            };
            ways.divert(baked, self.probe, *ray as usize, surfel, share);
        }
    }
}
