//! Which back faces have light of their own.
//!
//! Light meets both sides of every surface, but the back faces of closed solids are never seen and must
//! not cost receivers. A back face needs light if its material is double-sided, or if rays from places
//! in open air hit it (the outside of a house modelled as single sheets).

use std::sync::atomic::{AtomicBool, Ordering};

use probelight_math::glam::Vec3;
use probelight_math::sampling::{
    Rng, cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent,
};
use probelight_trace::{Ray, Tracer};
use rayon::prelude::*;

use crate::surface_samples::{SurfaceSample, sample_front_faces};

/// Points from which to look for back faces, and rays from each.
const VIEWERS: usize = 16_384;
const RAYS: u32 = 64;

/// A place that sees more unlit back faces than this lies inside a solid.
const MAX_BACK_SHARE: f32 = 0.25;

/// One flag per triangle: whether its back face is lit.
pub(crate) fn find_lit_back_faces(tracer: &Tracer, seed: u64) -> Vec<bool> {
    let scene = tracer.scene();
    let mut lit: Vec<bool> = (0..scene.triangles.len()).map(|t| scene.material(t).double_sided).collect();
    let viewers = sample_front_faces(scene, VIEWERS, &mut Rng::new(seed, 1));
    let mut new_viewers = find_seen(tracer, &viewers, &mut lit);
    // Back faces found lit see further back faces; two generations reach around the corners of a house.
    for _ in 0..2 {
        new_viewers = find_seen(tracer, &new_viewers, &mut lit);
    }
    lit
}

/// Marks the back faces that `viewers` in open air see; returns points on them as the next viewers.
fn find_seen(tracer: &Tracer, viewers: &[SurfaceSample], lit: &mut Vec<bool>) -> Vec<SurfaceSample> {
    let seen: Vec<AtomicBool> = lit.iter().map(|l| AtomicBool::new(*l)).collect();
    let found: Vec<Vec<SurfaceSample>> = viewers
        .par_iter()
        .enumerate()
        .map(|(i, viewer)| {
            let hits = back_faces_seen_from(tracer, viewer, i as u32, lit);
            for (triangle, _) in &hits {
                seen[*triangle as usize].store(true, Ordering::Relaxed);
            }
            hits.first().map(|(_, sample)| *sample).into_iter().collect()
        })
        .collect();
    *lit = seen.into_iter().map(AtomicBool::into_inner).collect();
    found.into_iter().flatten().collect()
}

/// Unlit back faces seen from a place in open air; none if the place lies inside a solid.
fn back_faces_seen_from(
    tracer: &Tracer,
    viewer: &SurfaceSample,
    index: u32,
    lit: &[bool],
) -> Vec<(u32, SurfaceSample)> {
    let world_from_local = world_from_tangent(viewer.normal);
    let origin = viewer.position + viewer.normal * tracer.offset();
    let mut unlit = Vec::new();
    let mut reaches_sky = false;
    for ray in 0..RAYS {
        let local = cosine_hemisphere_from_square(sobol_owen(ray, hash_pair(index, 91)));
        let direction: Vec3 = world_from_local * local;
        match tracer.closest_hit(&Ray::new(origin, direction)) {
            None => reaches_sky = true,
            Some(hit) if hit.is_back_face && !lit[hit.triangle as usize] => {
                let position = origin + direction * hit.distance;
                unlit.push((hit.triangle, SurfaceSample { position, normal: hit.normal }));
            }
            Some(_) => {}
        }
    }
    let inside_solid = unlit.len() as f32 > MAX_BACK_SHARE * RAYS as f32 && !reaches_sky;
    if inside_solid { Vec::new() } else { unlit }
}
