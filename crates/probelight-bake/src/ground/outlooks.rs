//! Which probes and places can exchange light at all, and which see much the same.
//!
//! An air space is a set of probes connected by lines of sight, directly or over a surface that both see.
//! Two spaces exchange no light, so no cluster may mix their receivers: truncation would leak light
//! through the wall between them. A room is a part of an air space in which neighbouring probes see most of what the other
//! one sees: it ends at doorways. A door there parts the light of both sides, so no cluster mixes rooms either.

use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Progress, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::limits::PROBES_TRIED_FOR_OUTLOOK;
use crate::air::point_tree::PointTree;
use crate::ground::site::Outlook;
use crate::steps::for_each_in_parallel;

/// Neighbours tested per probe, and ends of relight rays tested per pair that does not see each other.
const NEIGHBOURS: usize = 16;
const SHARED_POINTS: usize = 32;

/// Neighbours are in one room if each sees this share of what the other one sees.
const SHARE_IN_ROOM: f32 = 0.6;

/// Finds the outlook of each place that rays start from: the nearest probe it sees, and that probe's air space.
pub(crate) fn find_outlooks(
    tracer: &Tracer,
    probes: &PointTree,
    directions: &[Vec3],
    relight_hits: &[Option<Hit>],
    origins: &[Vec3],
    progress: &dyn Progress,
) -> Result<Vec<Option<Outlook>>, BakeError> {
    let links = link_probes(tracer, probes, directions, relight_hits, progress)?;
    let spaces = connect(probes.positions.len(), links.iter().map(|link| link.ends));
    let rooms = rooms(probes.positions.len(), &links);
    let outlook = |origin: &Vec3| {
        let probe = probes.nearest_visible(tracer, *origin, PROBES_TRIED_FOR_OUTLOOK, |_| true).next()?;
        let (position, number) = (probes.positions[probe as usize], probe as usize);
        Some(Outlook { probe, position, air_space: spaces[number], room: rooms[number] })
    };
    for_each_in_parallel("looking out", origins.par_iter(), progress, outlook)
}

/// A probe and a neighbour that exchanges light with it.
#[derive(Clone, Copy, Debug)]
struct Link {
    ends: [u32; 2],
    /// The share of what one sees that the other one sees, too; the smaller of both.
    shared: f32,
}

/// The probes that exchange light with their neighbours.
fn link_probes(
    tracer: &Tracer,
    probes: &PointTree,
    directions: &[Vec3],
    relight_hits: &[Option<Hit>],
    progress: &dyn Progress,
) -> Result<Vec<Link>, BakeError> {
    let rays = directions.len().max(1);
    // Slightly off the surface, so that it is not in the way itself.
    let off_surface = |direction: &Vec3, hit: &Hit| *direction * (hit.distance - 4.0 * tracer.offset());
    let seen_by = |p: usize| -> Vec<Vec3> {
        let rays =
            directions.iter().zip(relight_hits.get(p * rays..).unwrap_or_default()).take(SHARED_POINTS);
        rays.filter_map(|(d, hit)| Some(probes.positions[p] + off_surface(d, hit.as_ref()?))).collect()
    };
    let seen: Vec<Vec<Vec3>> = (0..probes.positions.len()).map(seen_by).collect();
    let share_seen_from = |place: Vec3, points: &[Vec3]| {
        let seen = points.iter().filter(|point| tracer.is_visible(**point, place)).count();
        seen as f32 / points.len().max(1) as f32
    };
    let links_of = |p: usize| -> Vec<Link> {
        let position = probes.positions[p];
        let others = probes.nearest(position, NEIGHBOURS).into_iter().filter(|q| *q as usize != p);
        let link = |q: u32| {
            let other = probes.positions[q as usize];
            let (there, back) =
                (share_seen_from(other, &seen[p]), share_seen_from(position, &seen[q as usize]));
            // Where both see the sky only, there is nothing between them.
            let is_linked = there > 0.0 || tracer.is_visible(position, other);
            let shared = if seen[p].is_empty() && is_linked { 1.0 } else { there.min(back) };
            is_linked.then_some(Link { ends: [p as u32, q], shared })
        };
        others.filter_map(link).collect()
    };
    let probes = (0..probes.positions.len()).into_par_iter();
    Ok(for_each_in_parallel("connecting probes", probes, progress, links_of)?.concat())
}

/// The room of each probe. Those in a doorway, which share little with either side, belong to the side with which they share
/// most.
fn rooms(count: usize, links: &[Link]) -> Vec<u32> {
    let mut best = vec![(0.0, u32::MAX); count];
    for Link { ends: [p, q], shared } in links {
        let best = &mut best[*p as usize];
        if *shared > best.0 {
            *best = (*shared, *q);
        }
    }
    let within = links.iter().filter(|link| link.shared >= SHARE_IN_ROOM).map(|link| link.ends);
    let alone = (0..).zip(&best).filter(|(_, (shared, q))| *shared < SHARE_IN_ROOM && *q != u32::MAX);
    connect(count, within.chain(alone.map(|(p, (_, q))| [p, *q])))
}

/// The smallest number of all that each number is connected with.
fn connect(count: usize, links: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..count as u32).collect();
    for ends in links {
        let [a, b] = ends.map(|end| find_root(&mut parents, end));
        parents[a.max(b) as usize] = a.min(b);
    }
    (0..count as u32).map(|number| find_root(&mut parents, number)).collect()
}

fn find_root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both_ways(links: &[(u32, u32, f32)]) -> Vec<Link> {
        let link =
            |(p, q, shared): (u32, u32, f32)| [Link { ends: [p, q], shared }, Link { ends: [q, p], shared }];
        links.iter().copied().flat_map(link).collect()
    }

    #[test]
    fn rooms_end_at_doorways_and_probes_in_them_belong_to_one_side() {
        // Three probes on each side of a doorway, which one stands in.
        let links = both_ways(&[
            (0, 1, 0.9),
            (1, 2, 0.8),
            (2, 3, 0.5),
            (3, 4, 0.4),
            (4, 5, 0.9),
            (5, 6, 0.95),
            (2, 4, 0.2),
        ]);
        assert_eq!(rooms(8, &links), [0, 0, 0, 0, 4, 4, 4, 7]);
        // Negative control: as air, all of it is one, but for the probe that sees none.
        assert_eq!(connect(8, links.iter().map(|link| link.ends)), [0, 0, 0, 0, 0, 0, 0, 7]);
    }
}
