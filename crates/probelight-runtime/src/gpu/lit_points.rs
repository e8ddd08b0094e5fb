//! The points of each surfel at which direct light is looked up in the shadow maps.
//!
//! Each texel of the lightmap has four, or more in small lightmaps, as far as it lies on a face. Each stands for its share
//! of the surfel's area, so that a surfel gets all the light that meets it, as the CPU counts it.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, NONE};

use crate::surfels_of_texels::surfels_of_texels;

/// Points along the edge of a texel: at least, and at most where lightmaps are small.
const POINTS_PER_EDGE: [u32; 2] = [2, 8];

/// About so many points a lightmap may have beyond the least: 16 MB. With four times as many, no reference of the Cornell
/// box or of coarse bakes of the rooms is met better.
const POINTS: usize = 1 << 19;

/// Surfels of whose area points stand for less are slivers between them, and have their light samples instead.
const LEAST_SHARE: f32 = 0.5;

/// A point of direct light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct LitPoint {
    /// World position on the surface, metres.
    pub(super) position: [f32; 3],
    /// Share of the surfel's area that it stands for.
    pub(super) share: f32,
    /// Unit geometric normal of its side.
    pub(super) normal: [f32; 3],
    /// Fills the record.
    pub(super) padding: f32,
}

/// The points of all surfels.
#[derive(Debug)]
pub(super) struct LitPoints {
    /// First point of each surfel, and the end of the last one's.
    firsts: Vec<u32>,
    points: Vec<LitPoint>,
}

impl LitPoints {
    pub(super) fn new(baked: &BakedScene) -> Self {
        let mut of_surfels = vec![Vec::new(); baked.surfels.len()];
        if baked.surfels.iter().any(|surfel| surfel.area > 0.0) {
            let surfel_of_texel = surfels_of_texels(baked);
            let [least, most] = POINTS_PER_EDGE;
            let per_texel = POINTS / baked.receiver_texels.len().max(1);
            let per_edge = (per_texel.isqrt() as u32).clamp(least, most);
            for triangle in 0..baked.scene.triangles.len() as u32 {
                add_points(baked, per_edge, triangle, false, &surfel_of_texel, &mut of_surfels);
                add_points(baked, per_edge, triangle, true, &surfel_of_texel, &mut of_surfels);
            }
        }
        // All at once: a vector that grows needs half as much again.
        let count = of_surfels.iter().map(Vec::len).sum::<usize>();
        let (mut firsts, mut points) = (vec![0], Vec::with_capacity(count));
        for (surfel, of_surfel) in baked.surfels.iter().zip(of_surfels) {
            let total = of_surfel.iter().map(|point: &LitPoint| point.share).sum::<f32>();
            if total >= LEAST_SHARE {
                let share = |point: LitPoint| LitPoint { share: point.share / total, ..point };
                points.extend(of_surfel.into_iter().map(share));
            } else {
                let share = (surfel.sample_count as f32).recip();
                points.extend(baked.samples_of(surfel).iter().map(|sample| {
                    let (position, normal) = baked.place_of(sample);
                    LitPoint { position: position.into(), share, normal: normal.into(), padding: 0.0 }
                }));
            }
            firsts.push(points.len() as u32);
        }
        Self { firsts, points }
    }

    /// The points of some surfels.
    pub(super) fn of(&self, surfels: Range<usize>) -> &[LitPoint] {
        &self.points[self.firsts[surfels.start] as usize..self.firsts[surfels.end] as usize]
    }

    /// First point of each of some surfels among [`of`](Self::of) them, and the end of the last one's.
    pub(super) fn firsts(&self, surfels: Range<usize>) -> Vec<u32> {
        let first = self.firsts[surfels.start];
        self.firsts[surfels.start..=surfels.end].iter().map(|point| point - first).collect()
    }
}

/// Adds the points on one side of a triangle to the surfels on which they lie.
fn add_points(
    baked: &BakedScene,
    per_edge: u32,
    triangle: u32,
    is_back_face: bool,
    surfel_of_texel: &[u32],
    of_surfels: &mut [Vec<LitPoint>],
) {
    let layout = &baked.lightmap;
    let Some(face) = layout.face(triangle, is_back_face).filter(|face| face.area() > 0.0) else { return };
    let front = baked.scene.geometric_normal(triangle as usize);
    let normal = if is_back_face { -front } else { front };
    let square_meters = baked.scene.area(triangle as usize) / (face.area() * (per_edge * per_edge) as f32);
    for (position, barycentric) in face.points(per_edge) {
        let surfel = surfel_of_texel.get(layout.texel_at(position) as usize).copied().unwrap_or(NONE);
        if surfel == NONE {
            continue;
        }
        let area = baked.surfels[surfel as usize].area;
        of_surfels[surfel as usize].push(LitPoint {
            position: baked.scene.position(triangle as usize, barycentric).into(),
            share: if area > 0.0 { square_meters / area } else { 0.0 },
            normal: normal.into(),
            padding: 0.0,
        });
    }
}
