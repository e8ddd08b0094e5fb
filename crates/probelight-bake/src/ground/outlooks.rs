//! Which probes and places can exchange light at all.
//!
//! An air space is a set of probes connected by lines of sight, directly or over a surface that both see.
//! Two spaces exchange no light, so no cluster may mix their receivers: truncation would leak light
//! through the wall between them.

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

/// Finds the outlook of each place that rays start from: the nearest probe it sees, and that probe's air space.
pub(crate) fn find_outlooks(
    tracer: &Tracer,
    probes: &PointTree,
    directions: &[Vec3],
    relight_hits: &[Option<Hit>],
    origins: &[Vec3],
    progress: &dyn Progress,
) -> Result<Vec<Option<Outlook>>, BakeError> {
    let spaces = connect_probes(tracer, probes, directions, relight_hits, progress)?;
    let outlook = |origin: &Vec3| {
        let probe = probes.nearest_visible(tracer, *origin, PROBES_TRIED_FOR_OUTLOOK, |_| true).next()?;
        let (position, air_space) = (probes.positions[probe as usize], spaces[probe as usize]);
        Some(Outlook { probe, position, air_space })
    };
    for_each_in_parallel("looking out", origins.par_iter(), progress, outlook)
}

/// The air space of each probe.
fn connect_probes(
    tracer: &Tracer,
    probes: &PointTree,
    directions: &[Vec3],
    relight_hits: &[Option<Hit>],
    progress: &dyn Progress,
) -> Result<Vec<u32>, BakeError> {
    let views = probes.positions.par_iter().zip(relight_hits.par_chunks(directions.len().max(1)));
    let connect = |(p, (position, hits)): (usize, (&Vec3, &[Option<Hit>]))| -> Vec<u32> {
        let rays = directions.iter().zip(hits).take(SHARED_POINTS);
        let seen: Vec<Vec3> = rays.filter_map(|(d, hit)| Some(*position + *d * (*hit)?.distance)).collect();
        probes
            .nearest(*position, NEIGHBOURS)
            .into_iter()
            .filter(|q| *q as usize != p)
            .filter(|q| is_connected(tracer, *position, probes.positions[*q as usize], &seen))
            .collect()
    };
    let links = for_each_in_parallel("connecting probes", views.enumerate(), progress, connect)?;
    let mut spaces: Vec<u32> = (0..probes.positions.len() as u32).collect();
    for (p, neighbours) in links.iter().enumerate() {
        for q in neighbours {
            let (a, b) = (find_root(&mut spaces, p as u32), find_root(&mut spaces, *q));
            spaces[a.max(b) as usize] = a.min(b);
        }
    }
    Ok((0..probes.positions.len() as u32).map(|p| find_root(&mut spaces, p)).collect())
}

/// Whether `to` sees `from` or one of the surface points that `from` sees.
fn is_connected(tracer: &Tracer, from: Vec3, to: Vec3, seen: &[Vec3]) -> bool {
    tracer.is_visible(from, to)
        || seen.iter().any(|point| {
            // Slightly towards `from`, so that the surface itself is not in the way.
            let towards = (from - point).normalize_or_zero();
            tracer.is_visible(point + towards * (4.0 * tracer.offset()), to)
        })
}

fn find_root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}
