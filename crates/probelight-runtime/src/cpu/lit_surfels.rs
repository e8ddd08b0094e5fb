//! What one light makes of the surfels.
//!
//! ```text
//!  rays of the light ─► hits ─► rays that surfels counted ─┐
//!                                                          ├─► shares of the flux ─► irradiance
//!  what surfels expect if nothing is in the way ───────────┘
//! ```

use probelight_asset::{BakedScene, NONE};
use probelight_math::glam::Vec3;
use probelight_scene::{Light, range_window};
use probelight_trace::{Ray, World, direct_irradiance};
use rayon::prelude::*;

use super::direct_light::{LitSurface, PER_TASK, SurfelMiddle};
use super::light_rays::LightRays;
use super::patch_tree::PatchTree;
use super::share_flux::{PatchFlux, Questions};
use crate::shadow_turns::{ShadowTurn, ShadowWork};

/// Rays of a light for each surfel of the scene: what they cost is a share of what a frame does, which grows with the
/// surfels. A sun shines on all of the scene and through few of its windows.
const RAYS_PER_SURFEL: f32 = 0.25;
const SUN_RAYS_PER_SURFEL: f32 = 1.5;

/// But at least so many: small scenes show their noise, and coarse ones have windows, too.
const LEAST_RAYS: usize = 8192;
const LEAST_SUN_RAYS: usize = 65_536;

/// Groups of surfels that get no more than so many rays of a lamp from their neighbours are asked as a whole whether they
/// see it. Where a sun goes in through windows, what is lit and what is not lie too close for that.
const LARGEST_DOUBT: f32 = 0.5;

/// From so many of its radii on a surfel is as bright as its middle.
const FAR: f32 = 4.0;

/// How much more than the cosine's share of a far light a surfel may get: counts are noisy, and its middle need not face the
/// light where it is curved.
const MOST_OF_COSINE: f32 = 1.25;
const MOST_BESIDES: f32 = 0.05;

/// A light and its irradiance on the surfels.
#[derive(Clone, Debug)]
pub(super) struct LitSurfels {
    /// The light, with an intensity of 1, if there is one.
    light: Option<Light>,
    /// Its intensity, W/sr, or irradiance, W/m².
    intensity: Vec3,
    /// Turns until all rays know where the light is now, and all surfels what these rays tell.
    turns_left: usize,
    hits: Vec<LightHit>,
    /// Of each root of the patches' tree, the share of what it expects that is not hidden.
    seen: Vec<f32>,
    /// Irradiance of each surfel at an intensity of 1.
    irradiance: Vec<f32>,
}

/// What a ray of a light met.
#[derive(Clone, Copy, Debug)]
struct LightHit {
    /// The surfel, or [`NONE`].
    surfel: u32,
    distance: f32,
    /// Whether an object is in the way.
    is_hidden: bool,
}

impl LightHit {
    const NOTHING: Self = Self { surfel: NONE, distance: 0.0, is_hidden: false };
}

impl LitSurfels {
    /// Darkness, until there is a light.
    pub(super) fn new(baked: &BakedScene, tree: &PatchTree) -> Self {
        Self {
            light: None,
            intensity: Vec3::ZERO,
            turns_left: 0,
            hits: Vec::new(),
            seen: vec![1.0; tree.roots().len()],
            irradiance: vec![0.0; baked.surfels.len()],
        }
    }

    /// The light as it is in this frame. One that only changed its colour keeps its rays.
    pub(super) fn set_light(&mut self, light: &Light, turn: ShadowTurn) {
        let (light, intensity) = unit_light(light);
        self.intensity = intensity;
        if self.light.as_ref() != Some(&light) {
            let rays = ray_count(&light, self.irradiance.len());
            self.hits.resize(rays, LightHit::NOTHING);
            self.light = Some(light);
            self.turns_left = turn.until_settled();
        }
    }

    /// There is no such light in this frame.
    pub(super) fn forget(&mut self) {
        self.light = None;
    }

    /// Finds the irradiance of the surfels.
    pub(super) fn light(
        &mut self,
        baked: &BakedScene,
        surface: &LitSurface,
        world: World<'_>,
        work: ShadowWork,
        flux: &mut PatchFlux,
    ) {
        let left = self.turns_left;
        let moved = left > 0;
        let Some(light) = self.light.clone().filter(|_| moved || work.objects) else { return };
        self.turns_left = if work.turn.turns == 1 { 0 } else { left.saturating_sub(1) };
        if surface.surfel_of_texel.is_empty() {
            self.light_points(&light, surface, world, baked, work.turn);
            return;
        }
        let rays = LightRays::new(&light, &surface.bounds, world.tracer.offset(), self.hits.len());
        if moved && work.turn.are_rays_due(left) {
            self.trace(&rays, baked, surface, world, work.turn);
        }
        self.meet_objects(&rays, world, work.turn);
        let tree = &surface.tree;
        flux.count(tree, self.arrived(&light));
        expect(&light, baked, surface, flux.of_surfels_mut());
        let questions = Questions {
            largest: if matches!(light, Light::Directional { .. }) { 0.0 } else { LARGEST_DOUBT },
            sees: |surfel: u32| {
                let places = surface.places_of(&baked.surfels[surfel as usize]);
                let (position, normal) = places[places.len() / 2];
                direct_irradiance(&world, std::slice::from_ref(&light), position, normal) != Vec3::ZERO
            },
        };
        flux.share(tree, work.turn, &mut self.seen, &questions);
        let per_ray = rays.flux_per_ray();
        for_each_in_turn(&mut self.irradiance, ShadowTurn::ALL, |index, value| {
            if !work.turn.has(tree.place_of(index).1) {
                return;
            }
            let (area, arrived) = (baked.surfels[index].area, per_ray * flux.shared(tree, index));
            *value = 0.0;
            if area > 0.0 && arrived > 0.0 {
                *value = (arrived / area).min(most(&light, &surface.middles[index]));
            }
        });
    }

    /// Adds the light's irradiance (W/m²) on the surfels from `first` on.
    pub(super) fn add_to(&self, sums: &mut [Vec3], first: usize) {
        for (sum, value) in sums.iter_mut().zip(&self.irradiance[first..]) {
            *sum += self.intensity * *value;
        }
    }

    /// Finds where the rays end whose turn it is, as if nothing moved through the scene.
    fn trace(
        &mut self,
        rays: &LightRays,
        baked: &BakedScene,
        surface: &LitSurface,
        world: World<'_>,
        turn: ShadowTurn,
    ) {
        for_each_in_turn(&mut self.hits, turn, |index, found| {
            *found = LightHit::NOTHING;
            if let Some(hit) = world.tracer.closest_hit(&rays.ray(index)) {
                let texel = baked.lightmap.texel(hit.triangle, hit.is_back_face, hit.barycentric);
                let surfel = texel.map_or(NONE, |texel| surface.surfel_of_texel[texel as usize]);
                *found = LightHit { surfel, distance: hit.distance, is_hidden: false };
            }
        });
    }

    /// Finds which rays objects are in the way of.
    fn meet_objects(&mut self, rays: &LightRays, world: World<'_>, turn: ShadowTurn) {
        for_each_in_turn(&mut self.hits, turn, |index, hit| {
            let ray = || Ray { max_distance: hit.distance, ..rays.ray(index) };
            hit.is_hidden = !world.objects.is_empty() && world.is_object_in_the_way(&ray());
        });
    }

    /// The surfel that each ray arrives at, and what the light's range leaves of it.
    fn arrived(&self, light: &Light) -> impl Iterator<Item = (u32, f32)> {
        let range = match light {
            Light::Point { range, .. } | Light::Spot { range, .. } => *range,
            Light::Directional { .. } => None,
        };
        let arriving = self.hits.iter().filter(|hit| hit.surfel != NONE && !hit.is_hidden);
        arriving.map(move |hit| (hit.surfel, range_window(hit.distance * hit.distance, range)))
    }

    /// The same where surfels are points: by shadow rays.
    fn light_points(
        &mut self,
        light: &Light,
        surface: &LitSurface,
        world: World<'_>,
        baked: &BakedScene,
        turn: ShadowTurn,
    ) {
        let lights = std::slice::from_ref(light);
        for_each_in_turn(&mut self.irradiance, turn, |index, value| {
            let at =
                |(position, normal): &(Vec3, Vec3)| direct_irradiance(&world, lights, *position, *normal).x;
            *value = mean(surface.places_of(&baked.surfels[index]), at);
        });
    }
}

/// How many rays a light sends out.
fn ray_count(light: &Light, surfels: usize) -> usize {
    let (rays_per_surfel, least) = match light {
        Light::Directional { .. } => (SUN_RAYS_PER_SURFEL, LEAST_SUN_RAYS),
        Light::Point { .. } | Light::Spot { .. } => (RAYS_PER_SURFEL, LEAST_RAYS),
    };
    ((surfels as f32 * rays_per_surfel) as usize).max(least)
}

/// The most irradiance that a surfel may have. What is known of slivers' areas is too little to divide flux by.
fn most(light: &Light, middle: &SurfelMiddle) -> f32 {
    let (position, normal) = middle.place;
    let (to_light, irradiance) = match light {
        Light::Directional { direction, .. } => (-*direction, 1.0),
        Light::Point { position: lamp, .. } | Light::Spot { position: lamp, .. } => {
            let offset = *lamp - position;
            if offset.length() <= FAR * middle.radius {
                return f32::INFINITY;
            }
            (offset.normalize(), offset.length_squared().recip())
        }
    };
    irradiance * (MOST_OF_COSINE * to_light.dot(normal).max(0.0) + MOST_BESIDES)
}

/// Finds what each surfel would get if nothing were in the way, up to a common factor.
fn expect(light: &Light, baked: &BakedScene, surface: &LitSurface, expected: &mut [f32]) {
    let position = match light {
        Light::Point { position, .. } | Light::Spot { position, .. } => *position,
        Light::Directional { .. } => Vec3::INFINITY,
    };
    let at = |(position, normal): &(Vec3, Vec3)| {
        let arriving = light.illuminate(*position);
        arriving.map_or(0.0, |it| it.irradiance.x * it.to_light.dot(*normal).max(0.0))
    };
    let middles = surface.middles.par_chunks(PER_TASK).zip(baked.surfels.par_chunks(PER_TASK));
    expected.par_chunks_mut(PER_TASK).zip(middles).for_each(|(expected, (middles, surfels))| {
        for ((expected, middle), surfel) in expected.iter_mut().zip(middles).zip(surfels) {
            let is_far = position.distance_squared(middle.place.0) > (FAR * middle.radius).powi(2);
            let irradiance = if is_far { at(&middle.place) } else { mean(surface.places_of(surfel), at) };
            *expected = surfel.area * irradiance;
        }
    });
}

/// Changes the values whose turn it is.
fn for_each_in_turn<T: Send>(values: &mut [T], turn: ShadowTurn, change: impl Fn(usize, &mut T) + Sync) {
    // Tasks begin with a turn of their own.
    let per_task = PER_TASK.next_multiple_of(turn.turns);
    values.par_chunks_mut(per_task).enumerate().for_each(|(task, values)| {
        for index in turn.of(values.len()) {
            change(task * per_task + index, &mut values[index]);
        }
    });
}

/// A light with an intensity, or irradiance, of 1, and that of the given one.
fn unit_light(light: &Light) -> (Light, Vec3) {
    let mut unit = light.clone();
    let (Light::Point { intensity: power, .. }
    | Light::Spot { intensity: power, .. }
    | Light::Directional { irradiance: power, .. }) = &mut unit;
    let power = std::mem::replace(power, Vec3::ONE);
    (unit, power)
}

fn mean<T>(items: &[T], value: impl Fn(&T) -> f32) -> f32 {
    items.iter().map(value).sum::<f32>() / items.len() as f32
}
