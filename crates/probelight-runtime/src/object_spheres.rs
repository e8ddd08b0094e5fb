//! Spheres in place of objects, where these darken and colour the soft light around them.
//!
//! The light around a surface is taken for a sum of two: that of a [`Lamp`](crate::Lamp), and even light. Where the lamp is an
//! emissive surface, or two of them, these are told apart from it. A sphere stands before a part of each lamp, as two discs in
//! the sky cover each other, and before the part F of the cosine-weighted hemisphere, about (n·c) r²/d². It hides half of both,
//! and from there comes the light that it reflects instead: an object's spheres show twice its surface, so that there are no
//! gaps between them, and what they hide is summed up, as nothing is hidden more than once. (Spheres that hide all behind them,
//! as if by chance, leave a third of the light in the middle of a shadow.) An object that is thick in its middle has a core
//! besides, which hides all of a narrow lamp behind it.

use std::f32::consts::{FRAC_1_PI, PI};

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec3;
use probelight_scene::{Placement, Scene};

use crate::emissive_discs::{LitPlace, smoothstep, told_apart};
use crate::spread_points::spread_points;
use crate::{EmissiveDisc, GridLight};

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
    /// Whether it is the core of its object: 1 or 0.
    pub is_core: u32,
    /// Fills the record.
    pub(crate) unused: u32,
}

/// Most spheres of an object; one of them is its core.
pub const SPHERES_PER_OBJECT: usize = PATCHES + 1;

/// Patches that an object's surface is divided into.
const PATCHES: usize = 16;

/// Points next to the middle of an object that must all face away from it if it has a core there.
const CORE_POINTS: usize = 32;

/// Share of the light behind a sphere that it hides; it shows so much more than its part of the object does.
pub(crate) const OPACITY: f32 = 0.5;

/// How far spheres lie below the surface, in their radii: there they stick out least and leave least light between them.
const INSET: f32 = 0.4;

/// Points of the surface that are divided among spheres.
const POINTS: u32 = 2048;

/// Passes over the points, after which the middles hardly move any more.
const PASSES: usize = 12;

/// Reach of an object's spheres, in radii of a sphere that shows as much as the object.
const REACH: f32 = 9.0;

/// Share of the reach within which spheres hide all kinds of light, beyond it only that of discs: there they hide 1/36 of the
/// sky.
pub(crate) const EVEN_REACH: f32 = 2.0 / 3.0;

/// From this share of the reach on, spheres fade out.
pub(crate) const FADE_FROM: f32 = 0.5;

/// Divides a model's surface into patches, and gives each a sphere that hides as much as the patch does on average: a closed
/// surface of area A shows A / 4 of it from any side, a sphere π r², of which it hides [`OPACITY`].
pub(crate) fn fit_spheres(model: &Scene) -> Vec<ObjectSphere> {
    let points = surface_points(model);
    if points.is_empty() {
        return Vec::new();
    }
    let mut middles: Vec<Vec3> = Vec::with_capacity(PATCHES);
    // Each begins where no other is near.
    let mut distances = vec![f32::INFINITY; points.len()];
    let mut farthest = 0;
    while middles.len() < PATCHES {
        let middle = points[farthest].position;
        middles.push(middle);
        distances.iter_mut().zip(&points).for_each(|(d, p)| *d = d.min(p.position.distance_squared(middle)));
        farthest = (0..points.len()).max_by(|a, b| distances[*a].total_cmp(&distances[*b])).unwrap_or(0);
        if distances[farthest] == 0.0 {
            break;
        }
    }
    let mut patches = vec![Patch::default(); middles.len()];
    for _ in 0..PASSES {
        patches.fill(Patch::default());
        for point in &points {
            let distance = |middle: &Vec3| middle.distance_squared(point.position);
            let nearest =
                (0..middles.len()).min_by(|a, b| distance(&middles[*a]).total_cmp(&distance(&middles[*b])));
            patches[nearest.unwrap_or(0)].add(point);
        }
        for (middle, patch) in middles.iter_mut().zip(&patches).filter(|(_, patch)| patch.points > 0.0) {
            *middle = patch.sum.position / patch.points;
        }
    }
    let area = model.surface_area() as f32;
    let reach = REACH * (area / (4.0 * PI)).sqrt();
    let sphere = |(middle, patch): (&Vec3, &Patch)| {
        let radius = (area * patch.points / points.len() as f32 / (4.0 * PI * OPACITY)).sqrt();
        // What has two sides has no mean normal.
        let center = *middle - INSET * radius * patch.sum.normal / patch.points;
        let albedo = patch.sum.albedo / patch.points;
        ObjectSphere { center, radius, albedo, reach, object: 0, hides: 1.0, is_core: 0, unused: 0 }
    };
    let spheres = middles.iter().zip(&patches).filter(|(_, patch)| patch.points > 0.0).map(sphere);
    let core = core(&points).map(|(center, radius)| ObjectSphere {
        center,
        radius,
        reach,
        is_core: 1,
        hides: 1.0,
        ..ObjectSphere::zeroed()
    });
    core.into_iter().chain(spheres).collect()
}

/// The ball within an object about the middle of its surface, if that lies inside.
fn core(points: &[SurfacePoint]) -> Option<(Vec3, f32)> {
    let center = points.iter().map(|point| point.position).sum::<Vec3>() / points.len() as f32;
    let mut nearest: Vec<(Vec3, Vec3)> = points.iter().map(|p| (p.position - center, p.normal)).collect();
    nearest.sort_by(|(a, _), (b, _)| a.length_squared().total_cmp(&b.length_squared()));
    nearest.truncate(CORE_POINTS);
    let radius = nearest.first()?.0.length();
    let is_inside = nearest.iter().all(|(outward, normal)| outward.dot(*normal) > 0.0);
    (is_inside && radius > 0.0).then_some((center, radius))
}

/// A point of a surface; or sums over several.
#[derive(Clone, Copy, Default)]
struct SurfacePoint {
    position: Vec3,
    /// Unit vector out of the surface.
    normal: Vec3,
    albedo: Vec3,
}

/// Points whose sphere is the same.
#[derive(Clone, Copy, Default)]
struct Patch {
    points: f32,
    sum: SurfacePoint,
}

impl Patch {
    fn add(&mut self, point: &SurfacePoint) {
        self.points += 1.0;
        self.sum.position += point.position;
        self.sum.normal += point.normal;
        self.sum.albedo += point.albedo;
    }
}

/// Points spread evenly over a surface.
fn surface_points(model: &Scene) -> Vec<SurfacePoint> {
    let triangles: Vec<usize> = (0..model.triangles.len()).collect();
    let points = spread_points(model, &triangles, POINTS).into_iter();
    let point = |(triangle, barycentric)| SurfacePoint {
        position: model.position(triangle, barycentric),
        normal: model.geometric_normal(triangle),
        albedo: model.albedo(triangle, barycentric),
    };
    points.map(point).collect()
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

    /// Whether it may hide any light from a point; far away, that of one of the discs.
    fn reaches(&self, position: Vec3, discs: &[EmissiveDisc]) -> bool {
        let offset = self.center - position;
        let squared = offset.length_squared();
        let even_reach = EVEN_REACH * self.reach;
        let stands_before = |disc: &EmissiveDisc| {
            let to_disc = disc.center - position;
            let along = offset.dot(to_disc) / to_disc.length_squared();
            // Patches count as if the disc was as large as they are, at least.
            let width = 2.0 * self.radius + along * (disc.area * FRAC_1_PI).sqrt();
            (0.0..1.0).contains(&along) && (offset - along * to_disc).length_squared() < width * width
        };
        squared < even_reach * even_reach
            || (squared < self.reach * self.reach && discs.iter().any(stands_before))
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
    /// to, which does nothing to itself. Without objects `irradiance` arrives (W/m²), of `light`, and `discs` send out some of it.
    pub fn of(
        spheres: &[ObjectSphere],
        discs: &[EmissiveDisc],
        own: Option<u32>,
        position: Vec3,
        normal: Vec3,
        irradiance: Vec3,
        light: impl FnOnce() -> Option<GridLight>,
    ) -> Self {
        let is_near = |sphere: &&ObjectSphere| Some(sphere.object) != own && sphere.reaches(position, discs);
        let mut near = spheres.iter().filter(is_near).peekable();
        if near.peek().is_none() {
            return Self::NONE;
        }
        let Some(light) = light() else { return Self::NONE };
        let lamps = told_apart(&light.lamp(normal), discs, &LitPlace { position, normal, irradiance });
        let widths = lamps.map(|lamp| lamp.cosine.acos());
        let (mut hidden, mut lamps_left, mut reflected) = (0.0, [1.0; 3], Vec3::ZERO);
        // By patches, and by the core.
        let (mut lamps_hidden, mut lamps_behind) = ([0.0f32; 3], [0.0f32; 3]);
        // Of one object: its spheres follow each other.
        let (mut object, mut albedo, mut from_object) = (None, Vec3::ZERO, Vec3::ZERO);
        let reflected_by = |albedo: Vec3, from_object: Vec3| {
            // By the side of the object that faces the surface.
            from_object.try_normalize().map_or(Vec3::ZERO, |direction| albedo * light.irradiance(-direction))
        };
        let after = |left: [f32; 3], hidden: [f32; 3], behind: [f32; 3]| {
            [0, 1, 2].map(|k: usize| left[k] * (1.0 - hidden[k].max(behind[k])).max(0.0))
        };
        for sphere in near {
            if object != Some(sphere.object) {
                reflected += reflected_by(albedo, from_object);
                lamps_left = after(lamps_left, lamps_hidden, lamps_behind);
                (object, albedo, from_object) = (Some(sphere.object), Vec3::ZERO, Vec3::ZERO);
                (lamps_hidden, lamps_behind) = ([0.0; 3], [0.0; 3]);
            }
            let offset = sphere.center - position;
            let distance = offset.length().max(f32::MIN_POSITIVE);
            let direction = offset / distance;
            let is_core = sphere.is_core == 1;
            let [even_fade, disc_fade] =
                [EVEN_REACH, 1.0].map(|share| fade(distance / (share * sphere.reach)));
            let radii = (distance / sphere.radius.max(f32::MIN_POSITIVE)).max(1.0);
            let angle = radii.recip().asin();
            for k in (0..3).filter(|k| lamps[*k].flux != Vec3::ZERO) {
                let lamp = widths[k];
                let between = lamps[k].direction.dot(direction).clamp(-1.0, 1.0).acos();
                // The third is what is not known as a disc.
                let fade = if k < 2 { disc_fade } else { even_fade };
                if is_core {
                    lamps_behind[k] = sphere.hides * fade * covered_by_core(lamp, angle, between);
                } else {
                    // To a patch no lamp is smaller than itself: between the patches there would be light.
                    let covered = covered_share(lamp.max(angle), angle, between);
                    lamps_hidden[k] += sphere.hides * OPACITY * fade * covered;
                }
            }
            if !is_core {
                let share = OPACITY * even_fade * sphere_form_factor(radii, normal.dot(direction));
                hidden += sphere.hides * share;
                albedo += share * sphere.albedo;
                from_object += share * direction;
            }
        }
        reflected += reflected_by(albedo, from_object);
        lamps_left = after(lamps_left, lamps_hidden, lamps_behind);
        let of_lamps = lamps.map(|lamp| lamp.irradiance(normal));
        let all = light.irradiance(normal).max(of_lamps.iter().sum()).max(Vec3::splat(f32::MIN_POSITIVE));
        let even = all - of_lamps.iter().sum::<Vec3>();
        let left: Vec3 = of_lamps.iter().zip(lamps_left).map(|(lamp, left)| *lamp * left).sum();
        Self { left: (left + even * (1.0 - hidden).max(0.0)) / all, reflected }
    }
}

/// From 1 to 0 towards the reach of a sphere.
fn fade(share_of_reach: f32) -> f32 {
    1.0 - smoothstep((share_of_reach - FADE_FROM) / (1.0 - FADE_FROM))
}

/// The share of a disc in the sky that another covers; half opening angles and the angle between them, radians. Exact where
/// they do not meet or one lies within the other, smooth between (Oat and Sander, "Ambient Aperture Lighting", 2007).
fn covered_share(lamp: f32, sphere: f32, between: f32) -> f32 {
    let areas = [1.0 - lamp.cos(), 1.0 - sphere.cos()];
    let (inner, outer) = ((lamp - sphere).abs(), lamp + sphere);
    (1.0 - smoothstep((between - inner) / (outer - inner).max(1e-6)))
        * (areas[1] / areas[0].max(1e-9)).min(1.0)
}

/// The same by a core. What it does to wide lamps, patches know better.
fn covered_by_core(lamp: f32, core: f32, between: f32) -> f32 {
    (1.0 - smoothstep(2.0 * lamp / core - 1.0)) * covered_share(lamp, core, between)
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
        let spheres = &fit_spheres(&ball(0.7))[1..];
        assert_eq!(spheres.len(), PATCHES);
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
        // Half opening angle, height, the largest error.
        let lamps = [
            (4.0f32, 1.2, 0.08),
            (8.0, 1.05, 0.05),
            (15.0, 1.0, 0.04),
            (15.0, 2.0, 0.04),
            (30.0, 1.0, 0.04),
            (45.0, 1.5, 0.02),
        ];
        for (degrees, height, largest) in lamps {
            let cosine = degrees.to_radians().cos();
            let rays: Vec<Vec3> = (0..200_000)
                .map(|i| spherical_fibonacci(i, 200_000))
                .filter(|ray| ray.dot(direction) > cosine)
                .collect();
            let placed: Vec<ObjectSphere> =
                fitted.iter().map(|sphere| sphere.placed(&Placement::at(Vec3::Y * height), 0)).collect();
            let mut squares = [0.0; 3];
            let rows = [-0.8, -0.3, 0.1, 0.6];
            for (i, z) in (-16..16).flat_map(|i| rows.map(|z| (i, z))) {
                let position = Vec3::new(0.2 * i as f32, 0.0, z);
                let middle = Vec3::Y * height - position;
                let meets = |ray: &&Vec3| middle.cross(**ray).length_squared() < 1.0;
                let truth = rays.iter().filter(meets).count() as f32 / rays.len() as f32;
                let seen = |sphere: &ObjectSphere| {
                    let offset = sphere.center - position;
                    let apart = direction.dot(offset.normalize()).acos();
                    ((offset.length() / sphere.radius).max(1.0), apart)
                };
                let covered = |sphere: &ObjectSphere| {
                    let ((radii, apart), lamp) = (seen(sphere), degrees.to_radians());
                    let angle = radii.recip().asin();
                    match sphere.is_core {
                        1 => covered_by_core(lamp, angle, apart),
                        _ => covered_share(lamp.max(angle), angle, apart),
                    }
                };
                let (core, placed) = placed.split_first().unwrap();
                let hidden: f32 = placed.iter().map(|sphere| OPACITY * covered(sphere)).sum();
                let hidden = hidden.max(covered(core));
                // Spheres of half the area that hide all behind them, as if each was where it is by chance.
                let small = |sphere: &ObjectSphere| ObjectSphere {
                    radius: sphere.radius * OPACITY.sqrt(),
                    ..*sphere
                };
                let by_chance: f32 = placed.iter().map(|sphere| 1.0 - covered(&small(sphere))).product();
                // A lamp that is a point to a sphere which is larger.
                let is_before = |sphere: &&ObjectSphere| {
                    let (radii, apart) = seen(sphere);
                    apart < radii.recip().asin()
                };
                let by_points = OPACITY * placed.iter().filter(is_before).count() as f32;
                squares[2] += (by_points.min(1.0) - truth).powi(2) / 128.0;
                squares[0] += (hidden.min(1.0) - truth).powi(2) / 128.0;
                squares[1] += (1.0 - by_chance - truth).powi(2) / 128.0;
            }
            let [error, by_chance, by_points] = squares.map(f32::sqrt);
            let found = format!("{degrees}° at {height}: {error}, {by_chance}, {by_points}");
            assert!(error < largest && error < 0.6 * by_chance.min(by_points), "{found}");
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
    fn what_is_thick_in_its_middle_has_a_core() {
        let cores = |model: &Scene| fit_spheres(model).iter().filter(|sphere| sphere.is_core == 1).count();
        let spheres = fit_spheres(&ball(0.7));
        assert!(spheres[0].is_core == 1 && spheres[0].center.length() < 0.01, "{:?}", spheres[0]);
        assert!((spheres[0].radius - 0.7).abs() < 0.02, "{:?}", spheres[0]);
        assert_eq!(cores(&ball(0.7)), 1);
        // Two balls, with nothing between them.
        let mut pair = ball(0.5);
        let (count, second) = (pair.positions.len() as u32, ball(0.5));
        pair.positions.extend(second.positions.iter().map(|position| *position + 2.0 * Vec3::X));
        pair.normals.extend(second.normals);
        pair.tangents.extend(second.tangents);
        pair.uv0.extend(second.uv0);
        pair.triangles.extend(second.triangles.iter().map(|triangle| triangle.map(|corner| corner + count)));
        pair.triangle_material.extend(second.triangle_material);
        assert_eq!(cores(&pair), 0);
        let mut flat = ball(0.7);
        flat.positions.iter_mut().for_each(|position| *position *= Vec3::X);
        assert!(fit_spheres(&flat).is_empty(), "what has no area hides nothing");
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
