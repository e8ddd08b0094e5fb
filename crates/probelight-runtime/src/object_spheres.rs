//! Spheres in place of objects, where these darken and colour the soft light around them.
//!
//! The light around a surface is taken for a sum of two: that of a [`Lamp`], and even light. A sphere stands before a part of the
//! lamp, as two discs in the sky cover each other, and before the part F of the cosine-weighted hemisphere, about (n·c) r²/d².
//! It hides half of both, and from there comes the light that it reflects instead: an object's spheres show twice its surface,
//! so that there are no gaps between them, and what they hide is summed up, as nothing is hidden more than once. (Spheres that
//! hide all behind them, as if by chance, leave a third of the light in the middle of a shadow.)

use std::f32::consts::{FRAC_1_PI, PI};

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec3;
use probelight_math::sampling::sobol_owen;
use probelight_scene::{Placement, Scene};

use crate::GridLight;

/// A sphere that stands for a part of an object.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ObjectSphere {
    /// Middle, metres.
    pub center: Vec3,
    /// Radius, metres.
    pub radius: f32,
    /// Mean diffuse albedo, linear.
    pub albedo: Vec3,
    /// Distance at which it hides nothing any more, metres.
    pub reach: f32,
    /// Which of the objects it belongs to.
    pub object: u32,
    /// How much it darkens what it hides: 1, or 0 where that light is missing without it.
    pub hides: f32,
    /// Fills the record.
    pub(crate) unused: [u32; 2],
}

/// Spheres of an object.
pub const SPHERES_PER_OBJECT: usize = 16;

/// Share of the light behind a sphere that it hides; it shows so much more than its part of the object does.
pub(crate) const OPACITY: f32 = 0.5;

/// Points of the surface that are divided among spheres.
const POINTS: usize = 2048;

/// Passes over the points, after which the middles hardly move any more.
const PASSES: usize = 12;

/// Reach of an object's spheres, in radii of a sphere that shows as much as the object: there it hides 1/36 of the sky.
const REACH: f32 = 6.0;

/// From this share of the reach on, spheres fade out.
pub(crate) const FADE_FROM: f32 = 0.5;

/// Divides a model's surface into patches, and gives each a sphere that hides as much as the patch does on average: a closed
/// surface of area A shows A / 4 of it from any side, a sphere π r², of which it hides [`OPACITY`].
pub(crate) fn fit_spheres(model: &Scene) -> Vec<ObjectSphere> {
    let points = surface_points(model);
    let mut middles: Vec<Vec3> = Vec::with_capacity(SPHERES_PER_OBJECT);
    // Each begins where no other is near.
    let mut distances = vec![f32::INFINITY; points.len()];
    let mut farthest = 0;
    while middles.len() < SPHERES_PER_OBJECT {
        let middle = points[farthest].0;
        middles.push(middle);
        distances.iter_mut().zip(&points).for_each(|(d, (p, _))| *d = d.min(p.distance_squared(middle)));
        farthest = (0..points.len()).max_by(|a, b| distances[*a].total_cmp(&distances[*b])).unwrap_or(0);
        if distances[farthest] == 0.0 {
            break;
        }
    }
    let mut patches = vec![Patch::default(); middles.len()];
    for _ in 0..PASSES {
        patches.fill(Patch::default());
        for (point, albedo) in &points {
            let distance = |middle: &Vec3| middle.distance_squared(*point);
            let nearest =
                (0..middles.len()).min_by(|a, b| distance(&middles[*a]).total_cmp(&distance(&middles[*b])));
            let patch = &mut patches[nearest.unwrap_or(0)];
            *patch =
                Patch { points: patch.points + 1.0, sum: patch.sum + *point, albedo: patch.albedo + *albedo };
        }
        for (middle, patch) in middles.iter_mut().zip(&patches).filter(|(_, patch)| patch.points > 0.0) {
            *middle = patch.sum / patch.points;
        }
    }
    let area = model.surface_area() as f32;
    let reach = REACH * (area / (4.0 * PI)).sqrt();
    let sphere = |(middle, patch): (&Vec3, &Patch)| ObjectSphere {
        center: *middle,
        radius: (area * patch.points / points.len() as f32 / (4.0 * PI * OPACITY)).sqrt(),
        albedo: patch.albedo / patch.points,
        reach,
        object: 0,
        hides: 1.0,
        unused: [0; 2],
    };
    middles.iter().zip(&patches).filter(|(_, patch)| patch.points > 0.0).map(sphere).collect()
}

/// Sums over the points of a patch.
#[derive(Clone, Copy, Default)]
struct Patch {
    points: f32,
    sum: Vec3,
    albedo: Vec3,
}

/// Points spread evenly over a surface, with their albedo.
fn surface_points(model: &Scene) -> Vec<(Vec3, Vec3)> {
    let areas = (0..model.triangles.len()).scan(0.0, |sum, triangle| {
        *sum += f64::from(model.area(triangle));
        Some(*sum)
    });
    let areas: Vec<f64> = areas.collect();
    let total = areas.last().copied().unwrap_or(0.0);
    let point = |i: usize| {
        let at = (i as f64 + 0.5) / POINTS as f64 * total;
        let triangle = areas.partition_point(|end| *end < at).min(areas.len() - 1);
        let mut barycentric = sobol_owen(i as u32, 0);
        if barycentric.element_sum() > 1.0 {
            barycentric = 1.0 - barycentric;
        }
        (model.position(triangle, barycentric), model.albedo(triangle, barycentric))
    };
    (0..POINTS).map(point).collect()
}

impl ObjectSphere {
    /// The sphere of a model at the place of an object.
    pub(crate) fn placed(&self, placement: &Placement, object: u32) -> Self {
        Self {
            center: placement.point(self.center),
            radius: self.radius * placement.scale,
            reach: self.reach * placement.scale,
            object,
            ..*self
        }
    }
}

/// What objects make of the soft light on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectInfluence {
    /// The share of its irradiance that they leave.
    pub left: Vec3,
    /// Irradiance of what they reflect, W/m².
    pub reflected: Vec3,
}

impl ObjectInfluence {
    /// Without objects.
    pub const NONE: Self = Self { left: Vec3::ONE, reflected: Vec3::ZERO };

    /// That of spheres at a point of a surface that faces along `normal` (unit). `own` is the object that the surface belongs
    /// to, which does nothing to itself; `light` is the light there without objects.
    pub fn of(
        spheres: &[ObjectSphere],
        own: Option<u32>,
        position: Vec3,
        normal: Vec3,
        light: impl FnOnce() -> Option<GridLight>,
    ) -> Self {
        let is_near = |sphere: &&ObjectSphere| {
            Some(sphere.object) != own
                && sphere.center.distance_squared(position) < sphere.reach * sphere.reach
        };
        let mut near = spheres.iter().filter(is_near).peekable();
        if near.peek().is_none() {
            return Self::NONE;
        }
        let Some(light) = light() else { return Self::NONE };
        let lamp = light.lamp(normal);
        let (mut hidden, mut lamp_left, mut reflected) = (0.0, 1.0, Vec3::ZERO);
        let mut lamp_hidden: f32 = 0.0;
        // Of one object: its spheres follow each other.
        let (mut object, mut albedo, mut from_object) = (None, Vec3::ZERO, Vec3::ZERO);
        let reflected_by = |albedo: Vec3, from_object: Vec3| {
            // By the side of the object that faces the surface.
            from_object.try_normalize().map_or(Vec3::ZERO, |direction| albedo * light.irradiance(-direction))
        };
        for sphere in near {
            if object != Some(sphere.object) {
                reflected += reflected_by(albedo, from_object);
                lamp_left *= (1.0 - lamp_hidden).max(0.0);
                (object, albedo, from_object) = (Some(sphere.object), Vec3::ZERO, Vec3::ZERO);
                lamp_hidden = 0.0;
            }
            let offset = sphere.center - position;
            let distance = offset.length().max(f32::MIN_POSITIVE);
            let direction = offset / distance;
            let strength = OPACITY * fade(distance / sphere.reach);
            let radii = (distance / sphere.radius.max(f32::MIN_POSITIVE)).max(1.0);
            let share = strength * sphere_form_factor(radii, normal.dot(direction));
            hidden += sphere.hides * share;
            albedo += share * sphere.albedo;
            from_object += share * direction;
            let angle = lamp.direction.dot(direction).clamp(-1.0, 1.0).acos();
            let covered = covered_share(lamp.cosine.acos(), radii.recip().asin(), angle);
            lamp_hidden += sphere.hides * strength * covered;
        }
        reflected += reflected_by(albedo, from_object);
        lamp_left *= (1.0 - lamp_hidden).max(0.0);
        let all = light.irradiance(normal).max(Vec3::splat(f32::MIN_POSITIVE));
        let of_lamp = (lamp.flux * normal.dot(lamp.direction).max(0.0) / all).min(Vec3::ONE);
        Self { left: of_lamp * lamp_left + (1.0 - of_lamp) * (1.0 - hidden).max(0.0), reflected }
    }
}

/// From 1 to 0 towards the reach of a sphere.
fn fade(share_of_reach: f32) -> f32 {
    1.0 - smoothstep((share_of_reach - FADE_FROM) / (1.0 - FADE_FROM))
}

/// From 0 to 1, level at both ends.
fn smoothstep(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The share of a disc in the sky that another covers; half opening angles and the angle between them, radians. Exact where
/// they do not meet or one lies within the other, smooth between (Oat and Sander, "Ambient Aperture Lighting", 2007).
fn covered_share(lamp: f32, sphere: f32, between: f32) -> f32 {
    let areas = [1.0 - lamp.cos(), 1.0 - sphere.cos()];
    let (inner, outer) = ((lamp - sphere).abs(), lamp + sphere);
    (1.0 - smoothstep((between - inner) / (outer - inner).max(1e-6))) * (areas[1] / areas[0]).min(1.0)
}

/// Form factor of a sphere whose middle is `radii` of its radii away, at an angle of the given cosine to the normal; with
/// what the horizon cuts off (Snyder, "Area Light Sources for Real-Time Graphics", 1996).
fn sphere_form_factor(radii: f32, cosine: f32) -> f32 {
    let squared = (radii * radii).max(1.0 + 1e-4);
    let sine_squared = (1.0 - cosine * cosine).max(1e-6);
    let above = 1.0 - squared * cosine * cosine;
    if above <= 0.0 {
        return cosine.max(0.0) / squared;
    }
    // The horizon cuts the sphere.
    let outside = squared - 1.0;
    let angle = (-cosine * (outside / sine_squared).sqrt()).clamp(-1.0, 1.0).acos();
    let cut = (cosine * angle - (above * outside).sqrt()) / squared + (above / outside).sqrt().atan();
    cut.max(0.0) * FRAC_1_PI
}

#[cfg(test)]
mod tests {
    use probelight_math::directions::spherical_fibonacci;
    use probelight_math::glam::{Vec2, Vec4};
    use probelight_scene::Material;

    use super::*;

    /// A ball of many triangles.
    fn ball(radius: f32) -> Scene {
        let mut scene = Scene {
            materials: vec![Material { base_color: Vec4::new(0.8, 0.2, 0.1, 1.0), ..Material::default() }],
            ..Scene::default()
        };
        let on = |i: u32, j: u32| {
            let (polar, around) = (PI * i as f32 / 24.0, 2.0 * PI * j as f32 / 48.0);
            radius * Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
        };
        for (i, j) in (0..24).flat_map(|i| (0..48).map(move |j| (i, j))) {
            let quad = [on(i, j), on(i, j + 1), on(i + 1, j + 1), on(i + 1, j)];
            for corners in [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|k: usize| quad[k])) {
                if (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() > 1e-6 {
                    let first = scene.positions.len() as u32;
                    scene.positions.extend(corners);
                    scene.normals.extend(corners.map(Vec3::normalize));
                    scene.tangents.extend([Vec4::X; 3]);
                    scene.uv0.extend([Vec2::ZERO; 3]);
                    scene.triangles.push([first, first + 1, first + 2]);
                    scene.triangle_material.push(0);
                }
            }
        }
        scene
    }

    #[test]
    fn form_factors_are_those_of_rays() {
        let rays: Vec<Vec3> = (0..200_000).map(|i| spherical_fibonacci(i, 200_000)).collect();
        for (radii, cosine) in
            [(1.2f32, 0.9f32), (2.0, 1.0), (2.0, 0.3), (1.5, 0.0), (1.2, -0.4), (3.0, -0.2), (4.0, 0.5)]
        {
            let middle = radii * Vec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0);
            let meets = |ray: &&Vec3| {
                let along = ray.dot(middle);
                along > 0.0 && (middle - along * **ray).length_squared() < 1.0
            };
            let sum: f32 = rays.iter().filter(|ray| ray.y > 0.0).filter(meets).map(|ray| ray.y).sum();
            let truth = 4.0 * sum / rays.len() as f32;
            let found = sphere_form_factor(radii, cosine);
            assert!((found - truth).abs() < 2e-3, "{radii} {cosine}: {found} {truth}");
        }
    }

    #[test]
    fn spheres_hide_as_much_as_a_ball_does() {
        let spheres = fit_spheres(&ball(0.7));
        assert_eq!(spheres.len(), SPHERES_PER_OBJECT);
        for direction in (0..20).map(|i| spherical_fibonacci(i, 20)) {
            let position = direction * 4.0;
            let hidden = |sphere: &ObjectSphere| {
                let offset = sphere.center - position;
                let radii = offset.length() / sphere.radius;
                OPACITY * sphere_form_factor(radii, -direction.dot(offset.normalize()))
            };
            let share: f32 = spheres.iter().map(hidden).sum();
            let truth = 0.7f32.powi(2) / 16.0;
            // All of them are in sight, though those behind are hidden by those before.
            assert!((share / truth - 1.0).abs() < 0.1, "{share} {truth}");
        }
        assert!(spheres.iter().all(|sphere| sphere.albedo.abs_diff_eq(Vec3::new(0.8, 0.2, 0.1), 1e-5)));
    }

    /// A ball over a floor, between it and a lamp: what of the lamp is left where.
    #[test]
    fn spheres_hide_a_lamp_as_a_ball_does() {
        let fitted = fit_spheres(&ball(1.0));
        let direction = Vec3::new(0.2, 1.0, 0.1).normalize();
        // No lamp is found to be narrower.
        for (degrees, height) in [(15.0f32, 1.0), (15.0, 2.0), (30.0, 1.0), (45.0, 1.5)] {
            let cosine = degrees.to_radians().cos();
            let rays: Vec<Vec3> = (0..20_000)
                .map(|i| spherical_fibonacci(i, 20_000))
                .filter(|ray| ray.dot(direction) > cosine)
                .collect();
            let placed: Vec<ObjectSphere> =
                fitted.iter().map(|sphere| sphere.placed(&Placement::at(Vec3::Y * height), 0)).collect();
            let mut squares = [0.0; 2];
            for i in 0..16 {
                let position = Vec3::new(0.2 * i as f32, 0.0, 0.1);
                let middle = Vec3::Y * height - position;
                let meets = |ray: &&Vec3| middle.cross(**ray).length_squared() < 1.0;
                let truth = rays.iter().filter(meets).count() as f32 / rays.len() as f32;
                let covered = |sphere: &ObjectSphere| {
                    let offset = sphere.center - position;
                    let apart = direction.dot(offset.normalize()).acos();
                    let radii = (offset.length() / sphere.radius).max(1.0);
                    covered_share(degrees.to_radians(), radii.recip().asin(), apart)
                };
                let hidden: f32 = placed.iter().map(|sphere| OPACITY * covered(sphere)).sum();
                // Spheres of half the area that hide all behind them, as if each was where it is by chance.
                let small = |sphere: &ObjectSphere| ObjectSphere {
                    radius: sphere.radius * OPACITY.sqrt(),
                    ..*sphere
                };
                let by_chance: f32 = placed.iter().map(|sphere| 1.0 - covered(&small(sphere))).product();
                squares[0] += (hidden.min(1.0) - truth).powi(2) / 16.0;
                squares[1] += (1.0 - by_chance - truth).powi(2) / 16.0;
            }
            let [error, by_chance] = squares.map(f32::sqrt);
            assert!(error < 0.13 && error < 0.8 * by_chance, "{degrees}° at {height}: {error}, {by_chance}");
        }
    }

    #[test]
    fn discs_cover_each_other() {
        assert_eq!(covered_share(0.3, 0.1, 0.5), 0.0);
        assert_eq!(covered_share(0.1, 0.3, 0.1), 1.0);
        let quarter = covered_share(0.2, 0.1, 0.05);
        assert!((quarter - 0.25).abs() < 0.01, "{quarter}");
        assert!(covered_share(0.2, 0.1, 0.25) < quarter && covered_share(0.2, 0.1, 0.25) > 0.0);
    }

    #[test]
    fn spheres_go_with_their_object() {
        let placement = Placement { scale: 2.0, ..Placement::at(Vec3::X) };
        let placed = fit_spheres(&ball(1.0))[3];
        let moved = placed.placed(&placement, 7);
        assert_eq!(moved.center, 2.0 * placed.center + Vec3::X);
        assert_eq!([moved.radius, moved.reach], [2.0 * placed.radius, 2.0 * placed.reach]);
        assert_eq!((moved.object, moved.albedo), (7, placed.albedo));
    }
}
