//! Direct light of the analytic lights on surfels, driven by the lights: rays go out from each light, and what they carry
//! falls on the surfels that they meet. That costs what the light costs, not what the scene does, and is exact in energy
//! however thin a beam is and however near the wall.
//!
//! Surfels without area, as the paper's method has them, are points: a shadow ray each.

use probelight_asset::{BakedScene, Surfel};
use probelight_math::glam::Vec3;
use probelight_scene::{Bounds, Light};
use probelight_trace::World;
use rayon::prelude::*;

use super::lit_surfels::LitSurfels;
use super::patch_tree::PatchTree;
use super::share_flux::PatchFlux;
use crate::shadow_turns::ShadowWork;
use crate::surfels_of_texels::surfels_of_texels;

/// Rays that a task traces, or surfels that it works through.
pub(super) const PER_TASK: usize = 512;

/// Lights that are found side by side, each with room for the rays at all patches.
const LIGHTS_AT_ONCE: usize = 4;

/// What direct light needs to know of a scene, and the light of each analytic light.
#[derive(Clone, Debug)]
pub(super) struct DirectLight {
    surface: LitSurface,
    lights: Vec<LitSurfels>,
    /// What the lights that are found at a time share out.
    flux: Vec<PatchFlux>,
    /// Irradiance of the surfels, W/m².
    irradiance: Vec<Vec3>,
}

/// Where rays of lights end.
#[derive(Clone, Debug)]
pub(super) struct LitSurface {
    /// Box around the scene, metres.
    pub(super) bounds: Bounds,
    /// Surfel of each lightmap texel; empty if surfels are points.
    pub(super) surfel_of_texel: Vec<u32>,
    /// Position (metres) and unit normal of each light sample.
    pub(super) places: Vec<(Vec3, Vec3)>,
    pub(super) middles: Vec<SurfelMiddle>,
    /// Surfels and what is made of them.
    pub(super) tree: PatchTree,
}

/// A surfel as it looks from afar.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfelMiddle {
    /// Mean position (metres) and mean normal, which is shorter than 1 where the surfel is curved.
    pub(super) place: (Vec3, Vec3),
    /// How far it reaches from there, metres.
    pub(super) radius: f32,
}

impl SurfelMiddle {
    fn new(places: &[(Vec3, Vec3)], area: f32) -> Self {
        let share = (places.len() as f32).recip();
        let position = share * places.iter().map(|(position, _)| position).sum::<Vec3>();
        let normal = share * places.iter().map(|(_, normal)| normal).sum::<Vec3>();
        let distances = places.iter().map(|(place, _)| place.distance(position));
        Self { place: (position, normal), radius: distances.fold(area.sqrt(), f32::max) }
    }
}

impl LitSurface {
    /// Positions and normals of a surfel's light samples.
    pub(super) fn places_of(&self, surfel: &Surfel) -> &[(Vec3, Vec3)] {
        &self.places[surfel.first_sample as usize..][..surfel.sample_count as usize]
    }
}

impl DirectLight {
    /// Darkness for a baked scene.
    pub(super) fn new(baked: &BakedScene) -> Self {
        let have_areas = baked.surfels.iter().any(|surfel| surfel.area > 0.0);
        let mut surface = LitSurface {
            bounds: baked.scene.bounds(),
            surfel_of_texel: if have_areas { surfels_of_texels(baked) } else { Vec::new() },
            places: baked.light_samples.iter().map(|sample| baked.place_of(sample)).collect(),
            middles: Vec::new(),
            tree: PatchTree::new(baked.surfels.len(), &baked.surfel_groups),
        };
        let middle = |surfel: &Surfel| SurfelMiddle::new(surface.places_of(surfel), surfel.area);
        surface.middles = baked.surfels.iter().map(middle).collect();
        Self {
            surface,
            lights: Vec::new(),
            flux: Vec::new(),
            irradiance: vec![Vec3::ZERO; baked.surfels.len()],
        }
    }

    /// Irradiance of each surfel, W/m².
    pub(super) fn irradiance(&self) -> &[Vec3] {
        &self.irradiance
    }

    /// Finds the light of all lights on the surfels.
    pub(super) fn light(&mut self, baked: &BakedScene, world: World<'_>, lights: &[Light], work: ShadowWork) {
        // What lights leave behind serves the next ones.
        self.lights.iter_mut().skip(lights.len()).for_each(LitSurfels::forget);
        self.lights
            .resize_with(self.lights.len().max(lights.len()), || LitSurfels::new(baked, &self.surface.tree));
        let at_once = self.flux.len().max(lights.len().min(LIGHTS_AT_ONCE));
        self.flux.resize_with(at_once, || PatchFlux::new(&self.surface.tree, baked.surfels.len()));
        let (surface, flux) = (&self.surface, &mut self.flux);
        for (lit, lights) in self.lights.chunks_mut(LIGHTS_AT_ONCE).zip(lights.chunks(LIGHTS_AT_ONCE)) {
            lit.par_iter_mut().zip(lights).zip(&mut *flux).for_each(|((lit, light), flux)| {
                lit.set_light(light, work.turn);
                lit.light(baked, surface, world, work, flux);
            });
        }
        let lights = &self.lights[..lights.len()];
        self.irradiance.par_chunks_mut(PER_TASK).enumerate().for_each(|(task, sums)| {
            sums.fill(Vec3::ZERO);
            for lit in lights {
                lit.add_to(sums, task * PER_TASK);
            }
        });
    }
}
