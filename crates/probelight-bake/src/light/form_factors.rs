//! Form factors of the emitters as sites see them.
//!
//! Points on the emitter seen from the site, combined with the gather rays that happen to hit it by the balance
//! heuristic (Veach and Guibas 1995), which keeps nearby large emitters free of noise too.

use probelight_asset::NONE;
use probelight_math::color::luminance;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{hash_pair, sobol_owen, unit_from_bits};
use probelight_scene::Bounds;
use probelight_trace::Tracer;

use crate::ground::site::Place;
use crate::light::emitters::{EmitterPatch, Emitters};
use crate::transport::gather::GatherRay;

/// Points on emitters per receiver and half of the estimate, divided among the patches by how large they look;
/// each gets a few, as long as those of all together do not exceed a limit.
const SAMPLES: f32 = 64.0;
const FEWEST_SAMPLES: f32 = 2.0;
const MOST_SAMPLES: f32 = 256.0;

/// How many points each patch gets from the receivers of a cluster, on average: many patches share few points.
pub(crate) struct EmitterSampling(Vec<f32>);

impl EmitterSampling {
    /// Whole numbers of points on a patch for one estimate: the first, and how many.
    fn points(&self, patch: u32, site: u32, half: u32) -> (u32, u32) {
        let expected = self.0[patch as usize];
        let chance = unit_from_bits(hash_pair(hash_pair(site, half), 0xc4a2 ^ patch));
        let drawn = expected.floor() + f32::from(chance < expected.fract());
        (half * expected.ceil() as u32, drawn as u32)
    }
}

impl Emitters {
    /// Divides the samples among the patches by how large they look from the middle of a cluster.
    pub(crate) fn sampling(&self, receivers: &Bounds) -> EmitterSampling {
        let middle = 0.5 * (receivers.min + receivers.max);
        let solid_angle = |patch: &EmitterPatch| {
            let squared = patch.bounds.distance(middle).powi(2) + receivers.size().length_squared() * 0.25;
            patch.area() / (squared + patch.area()).max(f32::MIN_POSITIVE)
        };
        let weights: Vec<f32> = self.patches.iter().map(|p| solid_angle(p).sqrt()).collect();
        let total: f32 = weights.iter().sum();
        let counts = weights.iter().map(|weight| (SAMPLES * weight / total).floor().max(FEWEST_SAMPLES));
        let counts: Vec<f32> = counts.collect();
        if counts.iter().sum::<f32>() <= MOST_SAMPLES {
            return EmitterSampling(counts);
        }
        EmitterSampling(weights.iter().map(|weight| MOST_SAMPLES * weight / total).collect())
    }

    /// Adds the form factors (steradians, weighted as the place's rows do) of all emitters to `sums`, one for each signal,
    /// row by row: one of two independent estimates. The gather rays are part of it.
    pub(crate) fn add_form_factors(
        &self,
        tracer: &Tracer,
        place: &Place<'_>,
        sampling: &EmitterSampling,
        half: usize,
        rays: &[GatherRay],
        sums: &mut [f32],
    ) {
        let rays_per_lobe = rays.len() as f32 / place.points[0].lobe.total();
        let mut add = |signal: u32, direction: Vec3, share: f32| {
            let rows = sums.chunks_exact_mut(self.signals.len());
            for (row, factor) in rows.zip(place.reception.factors(direction)) {
                row[signal as usize] += factor * share;
            }
        };
        for ray in rays {
            let Some(hit) = ray.hit else { continue };
            let patch = self.patch_of_triangle[hit.triangle as usize];
            if hit.is_back_face || patch == NONE {
                continue;
            }
            let samples = sampling.0[patch as usize];
            let patch = &self.patches[patch as usize];
            let values = (ray.lobe, -hit.normal.dot(ray.direction));
            let squared = hit.distance * hit.distance;
            let weight = balanced_weight(samples, rays_per_lobe, patch.area(), values, squared);
            let share = weight * self.texel_share(tracer, patch, hit.triangle, hit.barycentric);
            add(patch.signal, ray.direction, share);
        }
        for (p, (patch, samples)) in (0..).zip(self.patches.iter().zip(&sampling.0)) {
            let (first, drawn) = sampling.points(p, place.site.seed, half as u32);
            for sample in first..first + drawn {
                let point = &place.points[sample as usize % place.points.len()];
                let origin = point.origin;
                let u = sobol_owen(sample, hash_pair(place.site.seed, 0x5eed ^ p));
                let (triangle, barycentric) = patch.point(u);
                let normal = tracer.front_normal(triangle);
                let position =
                    tracer.off_surface(tracer.scene().position(triangle as usize, barycentric), normal);
                let offset = position - origin;
                let squared = offset.length_squared().max(f32::MIN_POSITIVE);
                let direction = offset / squared.sqrt();
                let values = (point.lobe.value(direction), -normal.dot(direction));
                if values.0 > 0.0 && values.1 > 0.0 && tracer.is_visible(origin, position) {
                    let weight = balanced_weight(*samples, rays_per_lobe, patch.area(), values, squared);
                    let share = weight * self.texel_share(tracer, patch, triangle, barycentric);
                    add(patch.signal, direction, share);
                }
            }
        }
    }

    /// How much brighter a point emits than the mean of its signal.
    fn texel_share(&self, tracer: &Tracer, patch: &EmitterPatch, triangle: u32, at: Vec2) -> f32 {
        let mean = self.signals[patch.signal as usize].mean_texel;
        if mean == Vec3::ONE {
            return 1.0;
        }
        luminance(tracer.scene().emission_texel(triangle as usize, at))
            / luminance(mean).max(f32::MIN_POSITIVE)
    }
}

/// What one point adds to the form factor, whichever way it was found: the value of the place's lobe over the density
/// (per solid angle) of `samples` points on the patch and of gather rays, `rays_per_lobe` for each unit of the lobe.
/// `values`: the lobe's, and the cosine at the emitter.
fn balanced_weight(
    samples: f32,
    rays_per_lobe: f32,
    area: f32,
    values: (f32, f32),
    squared_distance: f32,
) -> f32 {
    let (lobe, at_emitter) = values;
    let by_area = samples * squared_distance / (area * at_emitter).max(f32::MIN_POSITIVE);
    lobe / (by_area + rays_per_lobe * lobe)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use probelight_math::glam::{Vec4, vec2};
    use probelight_scene::{Material, Scene};

    use super::*;
    use crate::ground::sample_point::{Lobe, Reception, SamplePoint};
    use crate::ground::site::Site;
    use crate::transport::gather::gather_rays;

    const HALF_SIDE: f32 = 0.5;
    const RAYS: u32 = 64;

    /// A square lamp that shines down, above the origin; and, if asked for, a sheet half way that shades the
    /// side x > 0.
    fn square_lamp(height: f32, is_shaded: bool) -> Tracer {
        let lamp = Material { emission: Vec3::ONE, ..Material::default() };
        let mut scene = Scene { materials: vec![lamp, Material::default()], ..Scene::default() };
        let mut add = |low: Vec2, high: Vec2, height: f32, material: u32| {
            let first = scene.positions.len() as u32;
            let corners = [low, vec2(high.x, low.y), high, vec2(low.x, high.y)];
            scene.positions.extend(corners.map(|c| Vec3::new(c.x, height, c.y)));
            scene.normals.extend([Vec3::NEG_Y; 4]);
            scene.tangents.extend([Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
            scene.uv0.extend([Vec2::ZERO; 4]);
            scene.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| first + v)));
            scene.triangle_material.extend([material; 2]);
        };
        add(Vec2::splat(-HALF_SIDE), Vec2::splat(HALF_SIDE), height, 0);
        if is_shaded {
            add(vec2(0.0, -9.0), vec2(9.0, 9.0), 0.5 * height, 1);
        }
        Tracer::new(Arc::new(scene))
    }

    /// ∫ cosθ dω over a square of half side a at distance d, from below its middle: four times the form factor
    /// of a rectangle above one of its corners, with X = a/d, `2 X/√(1+X²) · atan(X/√(1+X²))`.
    fn closed_form(distance: f32) -> f32 {
        let x = HALF_SIDE / distance;
        let slope = x / (1.0 + x * x).sqrt();
        4.0 * slope * slope.atan()
    }

    /// Mean over many receivers at the origin of the estimate, with or without gather rays.
    fn form_factor(tracer: &Tracer, with_rays: bool) -> f32 {
        let emitters = Emitters::find(tracer.scene(), 0.1);
        let sampling = emitters.sampling(&Bounds::of([Vec3::ZERO]));
        mean_form_factor(tracer, &emitters, &sampling, with_rays, 200)
    }

    fn mean_form_factor(
        tracer: &Tracer,
        emitters: &Emitters,
        sampling: &EmitterSampling,
        with_rays: bool,
        sites: u32,
    ) -> f32 {
        assert_eq!(emitters.signals.len(), 1);
        let mut sums = [0.0];
        for seed in 0..sites {
            let site = Site { seed, normal: Vec3::Y, ..Site::default() };
            let points = vec![SamplePoint { origin: Vec3::ZERO, lobe: Lobe::Cosine(Vec3::Y) }];
            let place = Place { site: &site, points, reception: Reception::Irradiance };
            let rays: Vec<GatherRay> =
                if with_rays { gather_rays(tracer, &place, RAYS, 0).concat() } else { Vec::new() };
            emitters.add_form_factors(tracer, &place, sampling, 0, &rays, &mut sums);
        }
        sums[0] / sites as f32
    }

    #[test]
    fn form_factors_of_a_square_lamp_are_those_of_the_closed_form() {
        for distance in [0.2, 1.0, 4.0] {
            let tracer = square_lamp(distance, false);
            for with_rays in [false, true] {
                let ratio = form_factor(&tracer, with_rays) / closed_form(distance);
                assert!((ratio - 1.0).abs() < 0.01, "{distance} m, rays {with_rays}: {ratio}");
            }
        }
    }

    #[test]
    fn what_stands_between_shades_half_of_the_lamp() {
        // Negative control: the comparison above would see it.
        let tracer = square_lamp(1.0, true);
        for with_rays in [false, true] {
            let ratio = form_factor(&tracer, with_rays) / closed_form(1.0);
            assert!((ratio - 0.5).abs() < 0.02, "rays {with_rays}: {ratio}");
        }
    }

    #[test]
    fn lamps_shine_from_their_front_only() {
        let mut scene = Scene::clone(square_lamp(1.0, false).scene());
        for triangle in &mut scene.triangles {
            triangle.swap(1, 2);
        }
        let tracer = Tracer::new(Arc::new(scene));
        assert_eq!([false, true].map(|with_rays| form_factor(&tracer, with_rays)), [0.0; 2]);
    }

    #[test]
    fn less_than_a_point_a_receiver_still_gives_the_closed_form() {
        let tracer = square_lamp(1.0, false);
        let emitters = Emitters::find(tracer.scene(), 0.1);
        for with_rays in [false, true] {
            let mean = |expected: f32| {
                let sampling = EmitterSampling(vec![expected; emitters.patches.len()]);
                mean_form_factor(&tracer, &emitters, &sampling, with_rays, 20_000)
            };
            for expected in [0.3, 1.6] {
                let ratio = mean(expected) / closed_form(1.0);
                assert!((ratio - 1.0).abs() < 0.03, "{expected} points, rays {with_rays}: {ratio}");
            }
        }
    }

    #[test]
    fn ten_thousand_lamps_cost_no_more_points_than_a_hundred() {
        let patch = |i: u32| {
            let corner = Vec3::new((i % 100) as f32, 3.0, (i / 100) as f32) * 4.0;
            let bounds = Bounds { min: corner, max: corner + Vec3::ONE };
            EmitterPatch { signal: 0, triangles: vec![i], areas: vec![1.0], bounds }
        };
        let sampled = |patches: u32| {
            let emitters = Emitters { patches: (0..patches).map(patch).collect(), ..Emitters::default() };
            emitters.sampling(&Bounds::of([Vec3::ZERO]))
        };
        assert!(sampled(90).0.iter().all(|samples| *samples >= FEWEST_SAMPLES));
        let many = sampled(10_000);
        assert!((many.0.iter().sum::<f32>() / MOST_SAMPLES - 1.0).abs() < 1e-3);
        let drawn = |site: u32| (0..10_000).map(|p| many.points(p, site, 0).1).sum::<u32>();
        let mean = (0..100).map(drawn).sum::<u32>() as f32 / 100.0;
        assert!((mean / MOST_SAMPLES - 1.0).abs() < 0.02, "{mean}");
        assert!(many.0[0] > 10.0 * many.0[9999], "the nearest gets most");
    }

    #[test]
    fn near_patches_get_more_samples_and_none_is_forgotten() {
        let tracer = square_lamp(1.0, false);
        let emitters = Emitters::find(tracer.scene(), 0.01);
        assert_eq!(emitters.patches.len(), 2, "one patch for each triangle where surfels are small");
        let total = |middle: Vec3| emitters.sampling(&Bounds::of([middle])).0;
        assert!(total(Vec3::X * 1e4).iter().all(|samples| *samples >= FEWEST_SAMPLES));
        let near = total(Vec3::ZERO);
        assert!((0.9 * SAMPLES..=SAMPLES).contains(&near.iter().sum()));
    }
}
