//! Sources of light drawn at random.

use std::f32::consts::TAU;

use probelight_math::glam::Vec3;
use probelight_math::sampling::{Rng, hash_pair, sobol_owen, sphere_from_square};
use probelight_scene::Light;

use crate::ground::Groundwork;
use crate::light::emitters::Emitters;

/// Lightings of each kind; emitters take part one by one, up to a limit.
const POINTS: usize = 84;
const SPOTS: usize = 84;
const SUNS: usize = 64;
const SKIES: usize = 24;
const MOST_EMITTERS: usize = 32;

/// How much points, spots, suns, skies and emitters count. Spots count most: what they light is small.
const KIND_WEIGHTS: [f32; 5] = [0.2, 0.3, 0.2, 0.15, 0.15];

/// One source of light, of unit strength.
pub(crate) enum Lighting {
    Analytic(Light),
    Sky(RandomSky),
    Emitter(u32),
}

/// A sky with a gradient and a bright region.
#[derive(Clone, Copy)]
pub(crate) struct RandomSky {
    zenith: f32,
    horizon: f32,
    ground: f32,
    lobe: Vec3,
    lobe_strength: f32,
}

impl RandomSky {
    pub(crate) fn radiance(&self, direction: Vec3) -> f32 {
        let pole = if direction.y > 0.0 { self.zenith } else { self.ground };
        let gradient = self.horizon + (pole - self.horizon) * direction.y.abs();
        gradient + self.lobe_strength * self.lobe.dot(direction).max(0.0).powi(4)
    }
}

/// Draws the sources of light.
pub(crate) fn draw_lightings(ground: &Groundwork, emitters: &Emitters) -> Vec<Lighting> {
    let mut rng = Rng::new(ground.settings.seed, 0x11_67);
    let probes = &ground.probes.positions;
    let mut lightings = Vec::new();
    let count = if probes.is_empty() { 0 } else { POINTS + SPOTS };
    for i in 0..count {
        // Evenly through the probes, so that every room gets its lamps.
        let at = (i as f32 + rng.next_f32()) / count as f32 * probes.len() as f32;
        let position = probes[(at as usize).min(probes.len() - 1)];
        let direction = sphere_from_square(rng.next_vec2());
        let outer_angle = 0.2 + 0.6 * rng.next_f32();
        lightings.push(Lighting::Analytic(if i % 2 == 1 {
            let inner_angle = outer_angle * rng.next_f32();
            Light::Spot { position, direction, intensity: Vec3::ONE, inner_angle, outer_angle, range: None }
        } else {
            Light::Point { position, intensity: Vec3::ONE, range: None }
        }));
    }
    for i in 0..SUNS {
        let u = sobol_owen(i as u32, hash_pair(ground.settings.seed as u32, 3));
        let (height, azimuth) = (0.05 + 0.95 * u.x, TAU * u.y);
        let across = (1.0 - height * height).sqrt();
        let direction = Vec3::new(across * azimuth.cos(), -height, across * azimuth.sin());
        lightings.push(Lighting::Analytic(Light::Directional { direction, irradiance: Vec3::ONE }));
    }
    for i in 0..SKIES {
        let mut random = || rng.next_f32();
        let (zenith, horizon, ground) = (random(), random(), random());
        let lobe_strength = if i % 2 == 0 { 0.0 } else { 4.0 * random() };
        let lobe = sphere_from_square(rng.next_vec2());
        let lobe = Vec3::new(lobe.x, lobe.y.abs(), lobe.z);
        lightings.push(Lighting::Sky(RandomSky { zenith, horizon, ground, lobe, lobe_strength }));
    }
    let emitters = emitters.signals.len();
    let step = emitters.div_ceil(MOST_EMITTERS).max(1);
    lightings.extend((0..emitters as u32).step_by(step).map(Lighting::Emitter));
    lightings
}

/// The lightings' weights: every kind of source counts as a whole, however many of it there are.
pub(crate) fn kind_weights(lightings: &[Lighting]) -> Vec<f32> {
    let kind = |l: &Lighting| match l {
        Lighting::Analytic(Light::Point { .. }) => 0,
        Lighting::Analytic(Light::Spot { .. }) => 1,
        Lighting::Analytic(Light::Directional { .. }) => 2,
        Lighting::Sky(_) => 3,
        Lighting::Emitter(_) => 4,
    };
    let mut counts = [0usize; KIND_WEIGHTS.len()];
    lightings.iter().for_each(|l| counts[kind(l)] += 1);
    let present = KIND_WEIGHTS.iter().zip(counts).filter(|(_, count)| *count > 0);
    let total: f32 = present.map(|(weight, _)| weight).sum();
    let weight = |k: usize| lightings.len() as f32 * KIND_WEIGHTS[k] / (total * counts[k] as f32);
    lightings.iter().map(|l| weight(kind(l))).collect()
}
