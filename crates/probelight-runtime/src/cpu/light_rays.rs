//! Rays that a light sends out, each with the same share of its flux.
//!
//! The rays of a lamp or spot are a spiral of the golden angle around its axis, those of a directional light a lattice
//! over the scene's outline as the light sees it: well stratified, and the same each frame for the same light.

use std::f32::consts::TAU;

use probelight_math::glam::{Mat3, Vec2, Vec3};
use probelight_math::sampling::world_from_tangent;
use probelight_scene::{Bounds, Light};
use probelight_trace::Ray;

/// The narrowest ramp between the cones of a spot, as [`Light::illuminate`] has it.
const NARROWEST_RAMP: f32 = 0.001;

/// The rays of a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightRays {
    shape: Shape,
    count: usize,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    /// From a position, all around or within a cone along the third axis of the frame.
    Cone { position: Vec3, world_from_cone: Mat3, cone: Cone, start: f32 },
    /// Side by side: from a corner of a rectangle with two sides.
    Beam { corner: Vec3, sides: [Vec3; 2], direction: Vec3 },
}

/// How a spot's intensity falls with the versine of the angle from its axis (1 − cosine, which is exact in narrow cones
/// too): all of it up to `outer − ramp`, then the square of a line down to none at `outer`.
#[derive(Clone, Copy, Debug)]
struct Cone {
    outer: f32,
    ramp: f32,
}

impl Cone {
    const SPHERE: Self = Self { outer: 2.0, ramp: 0.0 };

    fn of_spot(inner_angle: f32, outer_angle: f32) -> Self {
        let [inner, outer] = [inner_angle, outer_angle].map(|angle| 2.0 * (0.5 * angle).sin().powi(2));
        Self { outer, ramp: (outer - inner).max(NARROWEST_RAMP) }
    }

    /// Flux within the full part and that outside of it, over 2π: integrals of the intensity over the versine.
    fn parts(self) -> [f32; 2] {
        let ramp = self.ramp.min(self.outer);
        let partial = if self.ramp > 0.0 { ramp.powi(3) / (3.0 * self.ramp.powi(2)) } else { 0.0 };
        [self.outer - ramp, partial]
    }

    /// Solid angle that would hold the same flux at full intensity, sr.
    fn solid_angle(self) -> f32 {
        TAU * self.parts().iter().sum::<f32>()
    }

    /// The versine within which a share of the flux lies.
    fn versine(self, share: f32) -> f32 {
        let [full, partial] = self.parts();
        let within = share * (full + partial);
        if within <= full {
            return within;
        }
        (self.outer - (3.0 * self.ramp.powi(2) * (full + partial - within)).cbrt()).max(0.0)
    }
}

impl LightRays {
    /// `count` rays of a light in a scene; those of lamps begin `start` metres from them, past what they are mounted on.
    pub(super) fn new(light: &Light, bounds: &Bounds, start: f32, count: usize) -> Self {
        let shape = match *light {
            Light::Point { position, .. } => {
                Shape::Cone { position, world_from_cone: Mat3::IDENTITY, cone: Cone::SPHERE, start }
            }
            Light::Spot { position, direction, inner_angle, outer_angle, .. } => Shape::Cone {
                position,
                world_from_cone: world_from_tangent(direction),
                cone: Cone::of_spot(inner_angle, outer_angle),
                start,
            },
            Light::Directional { direction, .. } => beam(direction, bounds),
        };
        Self { shape, count }
    }

    /// Flux of a ray if the light has an intensity (or irradiance) of 1, sr (or m²).
    pub(super) fn flux_per_ray(&self) -> f32 {
        let flux = match &self.shape {
            Shape::Cone { cone, .. } => cone.solid_angle(),
            Shape::Beam { sides: [a, b], .. } => a.length() * b.length(),
        };
        flux / self.count as f32
    }

    /// Ray number `index`.
    #[inline]
    pub(super) fn ray(&self, index: usize) -> Ray {
        let stratum = (index as f32 + 0.5) / self.count as f32;
        // f64: the golden-ratio multiple of a large index has no fractional bits left in f32.
        let golden = (index as f64 * 0.618_033_988_749_894_8).fract() as f32;
        match &self.shape {
            Shape::Cone { position, world_from_cone, cone, start } => {
                let versine = cone.versine(stratum);
                let radius = (versine * (2.0 - versine)).max(0.0).sqrt();
                let direction =
                    *world_from_cone * (radius * Vec2::from_angle(TAU * golden)).extend(1.0 - versine);
                Ray::new(*position + direction * *start, direction)
            }
            Shape::Beam { corner, sides: [a, b], direction } => {
                Ray::new(*corner + *a * stratum + *b * golden, *direction)
            }
        }
    }
}

/// A rectangle before the scene, in whose shadow all of it lies.
fn beam(direction: Vec3, bounds: &Bounds) -> Shape {
    let beam_from_world = world_from_tangent(direction).transpose();
    let corner = |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        beam_from_world * Vec3::new(pick(0), pick(1), pick(2))
    };
    let outline = Bounds::of((0..8).map(corner));
    let size = outline.size();
    let world_from_beam = beam_from_world.transpose();
    Shape::Beam {
        corner: world_from_beam * (outline.min - Vec3::Z * size.length()),
        sides: [world_from_beam * (Vec3::X * size.x), world_from_beam * (Vec3::Y * size.y)],
        direction,
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    const ROOM: Bounds = Bounds { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(3.0, 2.0, 5.0) };

    fn spot(inner_angle: f32, outer_angle: f32) -> Light {
        Light::Spot {
            position: Vec3::Y,
            direction: Vec3::new(0.6, 0.0, 0.8),
            intensity: Vec3::ONE,
            inner_angle,
            outer_angle,
            range: None,
        }
    }

    /// A fine quadrature of what [`Light::illuminate`] sends out.
    fn flux(light: &Light, within: f32) -> f32 {
        let steps = 200_000;
        let shares = (0..steps).map(|i| 1.0 - (i as f32 + 0.5) / steps as f32 * 2.0);
        let axis = Vec3::new(0.6, 0.0, 0.8);
        let across = Vec3::Y;
        let intensity = |cosine: f32| {
            let direction = axis * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt();
            light.illuminate(Vec3::Y + direction).map_or(0.0, |it| f64::from(it.irradiance.x))
        };
        let sum: f64 = shares.filter(|cosine| *cosine >= within).map(intensity).sum();
        (sum * 2.0 / f64::from(steps)) as f32 * TAU
    }

    #[test]
    fn each_ray_carries_the_same_share_of_the_flux() {
        for light in [spot(0.3, 0.5), spot(0.0, 1.2), spot(0.2, 0.2), spot(0.5, 3.0)] {
            let rays = LightRays::new(&light, &ROOM, 0.0, 1000);
            let whole = flux(&light, -1.0);
            assert!((rays.flux_per_ray() * 1000.0 / whole - 1.0).abs() < 2e-3, "{light:?}");
            // The first rays lie nearest to the axis.
            let cosine = |i: usize| rays.ray(i).direction.dot(Vec3::new(0.6, 0.0, 0.8));
            for middle in [200, 500, 900] {
                let share = flux(&light, cosine(middle)) / whole;
                assert!((share - (middle as f32 + 0.5) / 1000.0).abs() < 3e-3, "{light:?} {share}");
            }
        }
    }

    #[test]
    fn lamps_shine_all_around_and_suns_on_all_of_the_scene() {
        let lamp = Light::Point { position: Vec3::X, intensity: Vec3::ONE, range: None };
        let rays = LightRays::new(&lamp, &ROOM, 0.1, 500);
        assert!((rays.flux_per_ray() * 500.0 - 4.0 * PI).abs() < 1e-4);
        let mean = (0..500).map(|i| rays.ray(i).direction).sum::<Vec3>() / 500.0;
        assert!(mean.length() < 1e-3 && (rays.ray(7).origin.distance(Vec3::X) - 0.1).abs() < 1e-6);
        let direction = Vec3::new(0.48, -0.8, 0.36);
        let rays =
            LightRays::new(&Light::Directional { direction, irradiance: Vec3::ONE }, &ROOM, 0.0, 20_000);
        // Flux through a box: its faces' areas times their cosines.
        let meets = |i: &usize| {
            let ray = rays.ray(*i);
            let (a, b) = ((ROOM.min - ray.origin) / ray.direction, (ROOM.max - ray.origin) / ray.direction);
            a.min(b).max_element().max(0.0) < a.max(b).min_element()
        };
        let flux = (0..20_000).filter(meets).count() as f32 * rays.flux_per_ray();
        let expected = 6.0 * 0.48 + 12.0 * 0.8 + 8.0 * 0.36;
        assert!((flux / expected - 1.0).abs() < 2e-3, "{flux} of {expected}");
    }
}
