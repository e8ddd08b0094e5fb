//! Which probes a cluster draws on: those that together see best what its receivers see.

use std::collections::BTreeSet;

use probelight_math::glam::Vec3;
use probelight_trace::{Ray, Tracer};

use crate::ground::Groundwork;
use crate::ground::site::Site;
use crate::partition::centroid;
use crate::transport::gather::GatherHit;

/// Receivers of a group from which candidates are looked for, probes tried from each, nearest first, and
/// how many that it sees become candidates.
const SCOUTS: usize = 32;
const PROBES_TRIED_PER_SCOUT: usize = 48;
const CANDIDATES_PER_SCOUT: usize = 10;

/// Probes beyond the wanted number that a group may draw on while rays remain that no probe serves, as a
/// multiple of that number, and the share of such rays that is accepted.
const MOST_EXTRA: usize = 2;
const ACCEPTED_UNSERVED: f32 = 0.005;

/// A further probe must serve at least this much better, summed over all rays (1 = every ray served ideally).
const SMALLEST_GAIN: f32 = 0.003;

/// What a probe is worth for a ray just for seeing its end; the rest is for seeing it from near and face on.
const WORTH_OF_SEEING: f32 = 0.4;

/// Chooses at most `most` probes, greedily by what each adds to the service of `hits` (a sample of the
/// cluster's gather hits).
pub(crate) fn choose_probes(ground: &Groundwork, group: &[u32], hits: &[GatherHit], most: usize) -> Vec<u32> {
    let Groundwork { tracer, probes, sites, .. } = ground;
    let candidates = find_candidates(ground, group);
    let scale = typical_distance(sites, group, hits);
    let mut services: Vec<(u32, Vec<f32>)> = candidates
        .into_iter()
        .map(|probe| {
            let position = probes.positions[probe as usize];
            (probe, hits.iter().map(|hit| service(tracer, position, hit, scale)).collect())
        })
        .collect();
    let mut served = vec![0f32; hits.len()];
    let mut chosen = Vec::new();
    while !services.is_empty() {
        let unserved = served.iter().filter(|s| **s == 0.0).count() as f32;
        let is_well_served = unserved <= ACCEPTED_UNSERVED * hits.len() as f32;
        if chosen.len() >= if is_well_served { most } else { MOST_EXTRA * most } {
            break;
        }
        let gain = |service: &[f32]| -> f32 {
            service.iter().zip(&served).map(|(s, served)| (s - served).max(0.0)).sum()
        };
        let gains: Vec<f32> = services.iter().map(|(_, service)| gain(service)).collect();
        let best =
            (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]).then(b.cmp(a))).unwrap_or(0);
        if gains[best] < SMALLEST_GAIN * hits.len() as f32 && !chosen.is_empty() {
            break;
        }
        let (probe, service) = services.swap_remove(best);
        for (served, service) in served.iter_mut().zip(service) {
            *served = served.max(service);
        }
        chosen.push(probe);
    }
    chosen
}

/// The outlooks of all the group's receivers, and more of the probes nearest to some of them among those
/// that these see; in order of their numbers.
fn find_candidates(ground: &Groundwork, group: &[u32]) -> Vec<u32> {
    let Groundwork { tracer, probes, sites, .. } = ground;
    let mut candidates: BTreeSet<u32> =
        group.iter().filter_map(|s| Some(sites[*s as usize].outlook?.probe)).collect();
    for site in group.iter().step_by(group.len().div_ceil(SCOUTS)) {
        let site = &sites[*site as usize];
        let origin = site.ray_origin(tracer);
        let seen = probes.nearest_visible(tracer, origin, PROBES_TRIED_PER_SCOUT, |_| true);
        candidates.extend(seen.take(CANDIDATES_PER_SCOUT));
    }
    candidates.into_iter().collect()
}

/// How well a probe serves a ray, from 0 (does not see its end) to 1 (sees it from near, face on).
fn service(tracer: &Tracer, probe: Vec3, hit: &GatherHit, scale: f32) -> f32 {
    match hit {
        GatherHit::Sky(direction) => f32::from(u8::from(!tracer.is_occluded(&Ray::new(probe, *direction)))),
        GatherHit::Surface { position, normal } => {
            let offset = probe - position;
            let squared = offset.length_squared();
            let cosine = normal.dot(offset) / squared.sqrt().max(f32::MIN_POSITIVE);
            if cosine <= 0.0 || !tracer.is_visible(*position, probe) {
                return 0.0;
            }
            let nearness = (scale * scale / squared.max(f32::MIN_POSITIVE)).min(1.0);
            WORTH_OF_SEEING + (1.0 - WORTH_OF_SEEING) * cosine * nearness
        }
    }
}

/// Half the mean distance from the group's middle to what it sees, metres.
fn typical_distance(sites: &[Site], group: &[u32], hits: &[GatherHit]) -> f32 {
    let middle = centroid(sites, group);
    let distances = hits.iter().filter_map(|hit| match hit {
        GatherHit::Surface { position, .. } => Some(position.distance(middle)),
        GatherHit::Sky(_) => None,
    });
    let (sum, count) = distances.fold((0.0, 0u32), |(sum, count), d| (sum + d, count + 1));
    0.5 * sum / count.max(1) as f32
}
