//! Light along one ray.

use std::f32::consts::FRAC_1_PI;

use probelight_math::glam::Vec3;
use probelight_math::sampling::{cosine_hemisphere_from_square, world_from_tangent};

use super::PathTracer;
use super::sampler::Sampler;
use crate::{Hit, Ray, direct_irradiance};

/// Number of reflections before Russian roulette starts.
const ROULETTE_START: u32 = 8;

/// Roulette lets no path live on with more than this probability, so that paths end among white walls too.
const LARGEST_SURVIVAL: f32 = 0.95;

/// Radiance that arrives along a ray, by origin, W·m⁻²·sr⁻¹.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ArrivingRadiance {
    /// Emitted by the surface that the ray meets.
    pub(super) emitted: Vec3,
    /// From the sky, if the ray leaves the scene.
    pub(super) sky: Vec3,
    /// Reflected by the surface that the ray meets.
    pub(super) reflected: Vec3,
}

/// A point where light is received.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// World position, metres.
    pub(super) position: Vec3,
    /// Unit geometric normal, on the side that is looked at.
    pub(super) normal: Vec3,
}

/// How a ray's direction was chosen, which decides the weight of an emitter that it happens to meet.
#[derive(Clone, Copy, Debug)]
pub(super) enum DirectionChoice {
    /// From outside, as by a camera: nothing else samples the emitter.
    Given,
    /// With this probability density per steradian, beside [`PathTracer::sampled_emitter_irradiance`].
    Sampled(f32),
}

impl PathTracer {
    /// Radiance that arrives at the ray's origin: one unbiased sample.
    pub(super) fn arriving_radiance(
        &self,
        ray: &Ray,
        choice: DirectionChoice,
        sampler: &mut Sampler,
    ) -> ArrivingRadiance {
        match self.tracer.closest_hit(ray) {
            None => ArrivingRadiance { sky: self.lighting.sky.radiance(ray.direction), ..Default::default() },
            Some(hit) => ArrivingRadiance {
                emitted: self.emitted_radiance(ray, &hit, choice),
                sky: Vec3::ZERO,
                reflected: self.reflected_radiance(*ray, hit, sampler),
            },
        }
    }

    /// Follows a path onwards from its first hit.
    fn reflected_radiance(&self, mut ray: Ray, mut hit: Hit, sampler: &mut Sampler) -> Vec3 {
        let scene = self.tracer.scene();
        let mut reflected = Vec3::ZERO;
        let mut throughput = Vec3::ONE;
        for depth in 1.. {
            throughput *= scene.albedo(hit.triangle as usize, hit.barycentric);
            let surface = Surface { position: ray.origin + ray.direction * hit.distance, normal: hit.normal };
            let direct = self.delta_irradiance(surface) + self.sampled_emitter_irradiance(surface, sampler);
            reflected += throughput * direct * FRAC_1_PI;

            if !survives_roulette(depth, &mut throughput, sampler) {
                break;
            }
            let (next, density) = self.cosine_ray(surface, sampler);
            ray = next;
            let Some(next) = self.tracer.closest_hit(&ray) else {
                reflected += throughput * self.lighting.sky.radiance(ray.direction);
                break;
            };
            hit = next;
            reflected += throughput * self.emitted_radiance(&ray, &hit, DirectionChoice::Sampled(density));
        }
        reflected
    }

    /// A ray that leaves the surface with a density of cosθ/π, and that density.
    #[inline]
    pub(super) fn cosine_ray(&self, surface: Surface, sampler: &mut Sampler) -> (Ray, f32) {
        let local = cosine_hemisphere_from_square(sampler.next_pair());
        let direction = world_from_tangent(surface.normal) * local;
        let origin = self.tracer.off_surface(surface.position, surface.normal);
        (Ray::new(origin, direction), local.z * FRAC_1_PI)
    }

    /// Irradiance from the analytic lights, exact.
    #[inline]
    pub(super) fn delta_irradiance(&self, surface: Surface) -> Vec3 {
        direct_irradiance(&*self.tracer, &self.lighting.lights, surface.position, surface.normal)
    }

    /// Emission of the met surface, weighted against finding it by sampling emitters.
    #[inline]
    fn emitted_radiance(&self, ray: &Ray, hit: &Hit, choice: DirectionChoice) -> Vec3 {
        if hit.is_back_face || self.emitters.is_empty() {
            return Vec3::ZERO;
        }
        let scene = self.tracer.scene();
        let emission = scene.emission(hit.triangle as usize, hit.barycentric) * self.lighting.emissive_scale;
        let DirectionChoice::Sampled(density) = choice else { return emission };
        if emission == Vec3::ZERO {
            return emission;
        }
        let per_area = self.emitters.density(scene, hit.triangle);
        let emitter_cosine = -ray.direction.dot(hit.normal);
        let per_steradian = per_area * hit.distance * hit.distance / emitter_cosine;
        emission * (density / (density + per_steradian))
    }

    /// Irradiance from one sampled point of an emissive triangle, weighted against finding the same point by
    /// a cosine-distributed ray.
    #[inline]
    pub(super) fn sampled_emitter_irradiance(&self, surface: Surface, sampler: &mut Sampler) -> Vec3 {
        if self.emitters.is_empty() {
            return Vec3::ZERO;
        }
        let scene = self.tracer.scene();
        let point = self.emitters.sample(scene, sampler.next_pair());
        let emitter_normal = self.tracer.front_normal(point.triangle);
        let origin = self.tracer.off_surface(surface.position, surface.normal);
        let to_emitter = point.position - origin;
        let squared_distance = to_emitter.length_squared();
        let direction = to_emitter / squared_distance.sqrt();
        let (cosine, emitter_cosine) = (direction.dot(surface.normal), -direction.dot(emitter_normal));
        if !(cosine > 0.0 && emitter_cosine > 0.0) {
            return Vec3::ZERO;
        }
        let target = self.tracer.off_surface(point.position, emitter_normal);
        if !self.tracer.is_visible(origin, target) {
            return Vec3::ZERO;
        }
        let emission =
            scene.emission(point.triangle as usize, point.barycentric) * self.lighting.emissive_scale;
        let per_steradian = point.density * squared_distance / emitter_cosine;
        emission * (cosine / (per_steradian + cosine * FRAC_1_PI))
    }
}

/// Ends paths at random after some reflections; those that live on carry the energy of those that ended.
#[inline]
fn survives_roulette(depth: u32, throughput: &mut Vec3, sampler: &mut Sampler) -> bool {
    if *throughput == Vec3::ZERO {
        return false;
    }
    if depth < ROULETTE_START {
        return true;
    }
    let survival = throughput.max_element().min(LARGEST_SURVIVAL);
    *throughput /= survival;
    sampler.next_unstratified() < survival
}
