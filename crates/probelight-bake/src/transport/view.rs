//! What a site sees: its gather rays, and the surfels that they meet.

use probelight_asset::NONE;

use crate::air::limits::MAX_UNLIT_SHARE_OF_POINT;
use crate::ground::Groundwork;
use crate::light::surfels::SurfelTree;
use crate::transport::gather::{GatherRay, gather_rays};

/// What a site sees, twice: each half of the rays is an estimate of its own.
pub(crate) struct View {
    pub(crate) halves: [SeenHalf; 2],
}

/// Rays of one half, whose weights sum to the lobe's integral, and the surfel at the end of each, or [`NONE`].
#[derive(Default)]
pub(crate) struct SeenHalf {
    pub(crate) rays: Vec<GatherRay>,
    pub(crate) surfels: Vec<u32>,
}

impl View {
    /// Shoots the rays of a site. Those of points inside solids tell nothing and are left out, unless all are.
    pub(crate) fn of(ground: &Groundwork, tree: &SurfelTree, site: u32) -> Self {
        let place = ground.place(site);
        let rays = gather_rays(&ground.tracer, &place, ground.rays_of(site), ground.settings.seed);
        let texel = |ray: &GatherRay| ray.hit.map_or(NONE, |hit| ground.atlas.texel_of_hit(&hit));
        let texels = rays.each_ref().map(|half| half.iter().map(texel).collect::<Vec<u32>>());
        let is_in_air = points_in_air(&rays, &texels, place.points.len());
        let mut half_rays = rays.into_iter();
        let halves = texels.map(|texels| {
            let kept = half_rays.next().into_iter().flatten().zip(&texels);
            let mut half = SeenHalf::default();
            for (ray, texel) in kept.filter(|(ray, _)| is_in_air[ray.point as usize]) {
                half.rays.push(ray);
                half.surfels.push(tree.surfel_of_texel(*texel));
            }
            let weight = place.points[0].lobe.total() / half.rays.len() as f32;
            half.rays.iter_mut().for_each(|ray| ray.weight = weight);
            half
        });
        Self { halves }
    }

    /// All rays.
    pub(crate) fn rays(&self) -> impl Iterator<Item = &GatherRay> {
        self.halves.iter().flat_map(|half| &half.rays)
    }

    /// The surfels that rays meet, and the rays' share of the lobe as the mean of both halves, steradians.
    pub(crate) fn surfels(&self) -> impl Iterator<Item = (u32, f32)> {
        let met = self.halves.iter().flat_map(|half| half.surfels.iter().zip(&half.rays));
        met.filter(|(surfel, _)| **surfel != NONE).map(|(surfel, ray)| (*surfel, 0.5 * ray.weight))
    }
}

/// Which points of a place lie in open air; all, if none does.
fn points_in_air(rays: &[Vec<GatherRay>; 2], texels: &[Vec<u32>; 2], points: usize) -> Vec<bool> {
    let mut counts = vec![(0u32, 0u32); points];
    for (ray, texel) in rays.iter().flatten().zip(texels.iter().flatten()) {
        let (unlit, all) = &mut counts[ray.point as usize];
        *unlit += u32::from(ray.hit.is_some() && *texel == NONE);
        *all += 1;
    }
    let is_in_air = |(unlit, all): &(u32, u32)| *unlit as f32 <= MAX_UNLIT_SHARE_OF_POINT * *all as f32;
    let in_air: Vec<bool> = counts.iter().map(is_in_air).collect();
    let has_rays = |half: &Vec<GatherRay>| half.iter().any(|ray| in_air[ray.point as usize]);
    if rays.iter().all(has_rays) { in_air } else { vec![true; points] }
}
