//! Emissive surfaces as discs, which tell where soft light comes from: of all that arrives in free space, the grid knows how much
//! it is, and only coarsely from where.

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use probelight_scene::Scene;

use crate::SurfaceColors;
use crate::grid_light::Lamp;
use crate::spread_points::spread_points;

/// Most discs of a scene.
pub(crate) const MOST_DISCS: usize = 16;

/// Points of a material's surface that are divided among discs.
const POINTS: u32 = 512;

/// Mean square distance from the middle above which a surface is no disc, as a multiple of that of a disc of its area.
const LARGEST_SPREAD: f32 = 2.5;

/// Largest cosine of a disc's half opening angle: what is farther away is so large at least.
pub(crate) const SMALLEST_DISC: f32 = 0.9999;

/// How far beyond a lamp's edge discs still count, as a share of its half opening angle.
pub(crate) const EDGE_SHARE: f32 = 0.5;

/// What is added to that, radians.
pub(crate) const EDGE_ANGLE: f32 = 0.1;

/// A disc counts less where less light than it would send arrives from about there, or in all on the surface, and nothing from
/// this share on: it is hidden then, and what arrives was bounced.
pub(crate) const HIDDEN_SHARE: f32 = 0.5;

/// An emissive surface as it looks from afar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct EmissiveDisc {
    /// Middle, metres.
    pub center: Vec3,
    /// Area, m².
    pub area: f32,
    /// Mean of the unit normals: shorter where the surface is curved, zero if it is closed.
    pub normal: Vec3,
    pub(crate) padding: f32,
    /// Mean radiance, W·m⁻²·sr⁻¹.
    pub radiance: Vec3,
    pub(crate) padding_2: f32,
}

impl EmissiveDisc {
    /// What it is to a point, if nothing stands between.
    pub(crate) fn lamp(&self, position: Vec3) -> Lamp {
        let offset = self.center - position;
        let squared = offset.length_squared().max(1e-12);
        let direction = offset / squared.sqrt();
        // What is closed shows a quarter of its area from anywhere.
        let shown = (-self.normal.dot(direction)).max(0.0) + 0.25 * (1.0 - self.normal.length()).max(0.0);
        let cosine = (squared / (squared + self.area * shown / PI)).sqrt().min(SMALLEST_DISC);
        let solid_angle = (self.area * shown / squared).min(2.0 * PI * (1.0 - cosine));
        Lamp { direction, cosine, flux: self.radiance * solid_angle }
    }
}

/// A point of a surface, and what arrives there without objects.
#[derive(Clone, Copy)]
pub(crate) struct LitPlace {
    /// Metres.
    pub(crate) position: Vec3,
    /// Unit vector.
    pub(crate) normal: Vec3,
    /// W/m².
    pub(crate) irradiance: Vec3,
}

/// The lamp that was found in the light around a point, told apart into the two discs that do most of it there, and the rest.
pub(crate) fn told_apart(found: &Lamp, discs: &[EmissiveDisc], place: &LitPlace) -> [Lamp; 3] {
    let LitPlace { position, normal, irradiance } = *place;
    let none = Lamp { flux: Vec3::ZERO, ..*found };
    let (mut best, mut strengths) = ([none; 2], [0.0; 2]);
    let width = found.cosine.acos();
    for disc in discs {
        let mut lamp = disc.lamp(position);
        let beyond = found.direction.dot(lamp.direction).clamp(-1.0, 1.0).acos() - width;
        let gate = 1.0 - smoothstep(beyond / (EDGE_SHARE * width + EDGE_ANGLE));
        let is_seen = seen(found.flux, lamp.flux) * seen(irradiance, lamp.irradiance(normal));
        lamp.flux = (lamp.flux * (gate * is_seen)).min(found.flux);
        let strength = luminance(lamp.irradiance(normal));
        if strength > strengths[0] {
            (best[1], strengths[1]) = (best[0], strengths[0]);
            (best[0], strengths[0]) = (lamp, strength);
        } else if strength > strengths[1] {
            (best[1], strengths[1]) = (lamp, strength);
        }
    }
    let sum = (best[0].flux + best[1].flux).max(Vec3::splat(f32::MIN_POSITIVE));
    let share = (found.flux / sum).min(Vec3::ONE);
    let [first, second] = best.map(|lamp| Lamp { flux: lamp.flux * share, ..lamp });
    let rest = (found.flux - first.flux - second.flux).max(Vec3::ZERO);
    [first, second, Lamp { flux: rest, ..*found }]
}

/// Whether what arrives may be that of a disc, from 0 to 1.
fn seen(arriving: Vec3, sent: Vec3) -> f32 {
    let share = luminance(arriving) / luminance(sent).max(f32::MIN_POSITIVE);
    smoothstep((share - HIDDEN_SHARE) / (1.0 - HIDDEN_SHARE))
}

/// From 0 to 1, level at both ends.
pub(crate) fn smoothstep(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The discs of a scene, for present colours.
#[derive(Clone, Debug, Default)]
pub(crate) struct EmissiveDiscs {
    /// Materials that emit.
    emitting: Vec<bool>,
    /// With the mean of the emissive texture in place of the radiance, and the material.
    fitted: Vec<(EmissiveDisc, usize)>,
    present: Vec<EmissiveDisc>,
}

impl EmissiveDiscs {
    /// Of the last update.
    pub(crate) fn as_slice(&self) -> &[EmissiveDisc] {
        &self.present
    }

    /// Takes other colours, and a factor on all emission. Only other materials that emit take time.
    pub(crate) fn update(&mut self, scene: &Scene, colors: &[SurfaceColors], scale: f32) {
        let emits = |colors: &SurfaceColors| colors.emission != Vec3::ZERO;
        if !colors.iter().map(emits).eq(self.emitting.iter().copied()) {
            self.emitting = colors.iter().map(emits).collect();
            self.fitted = fit_discs(scene, colors);
        }
        self.present.clear();
        let present = self.fitted.iter().map(|(disc, material)| EmissiveDisc {
            radiance: disc.radiance * colors[*material].emission * scale,
            ..*disc
        });
        self.present.extend(present.filter(|disc| disc.radiance != Vec3::ZERO));
    }
}

/// A point of an emissive surface.
#[derive(Clone, Copy)]
struct EmissivePoint {
    position: Vec3,
    normal: Vec3,
    texel: Vec3,
}

/// Points of one material near each other, and the area that each stands for.
struct Patch {
    material: usize,
    points: Vec<EmissivePoint>,
    area: f32,
}

impl Patch {
    fn weight(&self) -> f32 {
        self.points.iter().map(|point| luminance(point.texel)).sum::<f32>().max(f32::MIN_POSITIVE)
    }

    fn mean(&self, of: impl Fn(&EmissivePoint) -> Vec3) -> Vec3 {
        let sum: Vec3 = self.points.iter().map(|point| of(point) * luminance(point.texel)).sum();
        sum / self.weight()
    }

    /// The disc, with the mean of the texture.
    fn disc(&self) -> EmissiveDisc {
        let squares: f32 = self.points.iter().map(|point| luminance(point.texel).powi(2)).sum();
        // What is dark is no part of the disc.
        let shining = self.weight() * self.weight() / squares.max(f32::MIN_POSITIVE);
        let texels: Vec3 = self.points.iter().map(|point| point.texel).sum();
        EmissiveDisc {
            center: self.mean(|point| point.position),
            area: self.area * shining,
            normal: self.mean(|point| point.normal),
            radiance: texels / shining.max(f32::MIN_POSITIVE),
            ..EmissiveDisc::default()
        }
    }

    /// Variance of the points along each axis, over that of a disc.
    fn spread(&self) -> Vec3 {
        let EmissiveDisc { center, area, .. } = self.disc();
        self.mean(|point| (point.position - center).powf(2.0)) * 2.0 * PI / area.max(f32::MIN_POSITIVE)
    }

    /// Two halves along the axis on which the points lie farthest apart.
    fn halves(self) -> [Self; 2] {
        let (center, spread) = (self.disc().center, self.spread());
        let axis = (0..3).max_by(|a, b| spread[*a].total_cmp(&spread[*b])).unwrap_or(0);
        let (low, high) = self.points.iter().partition(|point| point.position[axis] < center[axis]);
        [low, high].map(|points| Self { points, ..self })
    }
}

/// Divides what emits into discs; of more than there may be, the brightest.
fn fit_discs(scene: &Scene, colors: &[SurfaceColors]) -> Vec<(EmissiveDisc, usize)> {
    let power = |patch: &Patch| patch.area * patch.weight() * luminance(colors[patch.material].emission);
    let by_power = |a: &Patch, b: &Patch| power(b).total_cmp(&power(a));
    let mut triangles = vec![Vec::new(); colors.len()];
    for (triangle, material) in scene.triangle_material.iter().enumerate() {
        if colors[*material as usize].emission != Vec3::ZERO {
            triangles[*material as usize].push(triangle);
        }
    }
    let surfaces = triangles.iter().enumerate();
    let mut patches: Vec<Patch> =
        surfaces.filter_map(|(m, triangles)| surface_of(scene, m, triangles)).collect();
    patches.sort_by(by_power);
    patches.truncate(MOST_DISCS);
    while patches.len() < MOST_DISCS {
        let is_wide = |patch: &Patch| patch.spread().element_sum() > LARGEST_SPREAD && patch.points.len() > 1;
        // They are sorted.
        let Some(wide) = patches.iter().position(is_wide) else { break };
        let halves = patches.swap_remove(wide).halves();
        patches.extend(halves.into_iter().filter(|half| !half.points.is_empty()));
        patches.sort_by(by_power);
    }
    patches.iter().map(|patch| (patch.disc(), patch.material)).collect()
}

/// Points spread evenly over the triangles of a material, if they have any area.
fn surface_of(scene: &Scene, material: usize, triangles: &[usize]) -> Option<Patch> {
    let point = |(triangle, barycentric)| EmissivePoint {
        position: scene.position(triangle, barycentric),
        normal: scene.geometric_normal(triangle),
        texel: scene.emission_texel(triangle, barycentric),
    };
    let points: Vec<_> = spread_points(scene, triangles, POINTS).into_iter().map(point).collect();
    let area: f32 = triangles.iter().map(|triangle| scene.area(*triangle)).sum();
    (!points.is_empty()).then_some(Patch { material, points, area: area / POINTS as f32 })
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::{Vec2, Vec4};
    use probelight_scene::Material;

    use super::*;

    /// Adds a rectangle, counter-clockwise as seen from where it shines.
    fn add_quad(scene: &mut Scene, corner: Vec3, sides: [Vec3; 2], material: u32) {
        let first = scene.positions.len() as u32;
        let normal = sides[0].cross(sides[1]).normalize();
        scene.positions.extend([corner, corner + sides[0], corner + sides[0] + sides[1], corner + sides[1]]);
        scene.normals.extend([normal; 4]);
        scene.tangents.extend([Vec4::X; 4]);
        scene.uv0.extend([Vec2::ZERO; 4]);
        scene.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        scene.triangle_material.extend([material; 2]);
    }

    fn emissive(materials: usize) -> Scene {
        let material = Material { emission: Vec3::new(4.0, 3.0, 2.0), ..Material::default() };
        Scene { materials: vec![material; materials], ..Scene::default() }
    }

    fn discs_of(scene: &Scene) -> Vec<EmissiveDisc> {
        let mut discs = EmissiveDiscs::default();
        discs.update(scene, &SurfaceColors::of(scene), 0.5);
        discs.as_slice().to_vec()
    }

    /// A square that shines down from a height of 3 m.
    fn ceiling() -> Scene {
        let mut scene = emissive(1);
        add_quad(&mut scene, Vec3::new(1.0, 3.0, 1.0), [Vec3::X, Vec3::Z], 0);
        scene
    }

    #[test]
    fn a_square_is_a_disc_of_its_area() {
        let [disc] = discs_of(&ceiling())[..] else { panic!("one square, one disc") };
        assert!(disc.center.abs_diff_eq(Vec3::new(1.5, 3.0, 1.5), 0.01), "{disc:?}");
        assert!((disc.area - 1.0).abs() < 1e-3 && disc.normal.abs_diff_eq(Vec3::NEG_Y, 1e-5), "{disc:?}");
        assert!(disc.radiance.abs_diff_eq(Vec3::new(2.0, 1.5, 1.0), 1e-4), "half of the emission: {disc:?}");
        // Under its middle: π L sin² of the half opening angle.
        let lamp = disc.lamp(disc.center - 2.0 * Vec3::Y);
        let wanted = std::f32::consts::PI * 2.0 / (1.0 + 4.0 * PI);
        assert!((lamp.irradiance(Vec3::Y).x / wanted - 1.0).abs() < 0.01, "{lamp:?}");
        assert_eq!(disc.lamp(disc.center + Vec3::Y).flux, Vec3::ZERO, "nothing shines backwards");
    }

    #[test]
    fn what_is_far_apart_or_long_is_divided() {
        let mut scene = ceiling();
        add_quad(&mut scene, Vec3::new(9.0, 3.0, 1.0), [Vec3::X, Vec3::Z], 0);
        assert_eq!(discs_of(&scene).len(), 2);
        let mut tube = emissive(1);
        add_quad(&mut tube, Vec3::ZERO, [3.0 * Vec3::X, 0.2 * Vec3::Z], 0);
        let discs = discs_of(&tube);
        assert!((3..=MOST_DISCS).contains(&discs.len()), "{discs:?}");
        let area: f32 = discs.iter().map(|disc| disc.area).sum();
        assert!((area - 0.6).abs() < 1e-3, "{area}");
        // The brightest of more materials than there may be discs.
        let mut many = emissive(40);
        (0..40).for_each(|i| {
            let size = 0.01 + 0.01 * i as f32;
            add_quad(&mut many, 3.0 * i as f32 * Vec3::X, [size * Vec3::X, size * Vec3::Z], i);
        });
        let discs = discs_of(&many);
        assert!(discs.len() == MOST_DISCS && discs.iter().all(|disc| disc.area > 0.05), "{discs:?}");
    }

    #[test]
    fn a_closed_surface_shines_alike_to_all_sides() {
        let mut cube = emissive(1);
        for (corner, sides) in [
            (Vec3::ZERO, [Vec3::Y, Vec3::X]),
            (Vec3::ZERO, [Vec3::X, Vec3::Z]),
            (Vec3::ZERO, [Vec3::Z, Vec3::Y]),
            (Vec3::ONE, [Vec3::NEG_X, Vec3::NEG_Y]),
            (Vec3::ONE, [Vec3::NEG_Z, Vec3::NEG_X]),
            (Vec3::ONE, [Vec3::NEG_Y, Vec3::NEG_Z]),
        ] {
            add_quad(&mut cube, corner, sides, 0);
        }
        let [disc] = discs_of(&cube)[..] else { panic!("one cube, one disc") };
        assert!(disc.normal.length() < 0.05, "{disc:?}");
        for side in [Vec3::X, Vec3::NEG_Y, Vec3::ONE.normalize()] {
            let lamp = disc.lamp(disc.center + 10.0 * side);
            // A quarter of its six faces.
            assert!((lamp.flux.x / (2.0 * 1.5 / 100.0) - 1.0).abs() < 0.05, "{lamp:?}");
        }
    }

    #[test]
    fn lamps_are_told_apart_into_discs_and_a_rest() {
        let discs = discs_of(&ceiling());
        let position = Vec3::new(1.3, 0.0, 1.9);
        let [ceiling, ..] = discs[..] else { panic!("there is a disc") };
        let direct = ceiling.lamp(position);
        // Wider, brighter and a little beside.
        let found = Lamp {
            direction: (direct.direction + 0.2 * Vec3::X).normalize(),
            cosine: 0.82,
            flux: 1.5 * direct.flux,
        };
        let place = LitPlace { position, normal: Vec3::Y, irradiance: Vec3::splat(100.0) };
        let [first, second, rest] = told_apart(&found, &discs, &place);
        assert_eq!((first, second.flux), (direct, Vec3::ZERO));
        assert!(rest.flux.abs_diff_eq(0.5 * direct.flux, 1e-5) && rest.cosine == found.cosine, "{rest:?}");
        // Light from elsewhere is not the disc's, nor is light that is less than the disc's.
        let beside = Lamp { direction: Vec3::X, ..found };
        assert_eq!(told_apart(&beside, &discs, &place)[2], beside);
        let of_disc = |share: f32| {
            let dim = Lamp { flux: share * direct.flux, ..found };
            let [first, _, rest] = told_apart(&dim, &discs, &place);
            assert!((first.flux + rest.flux).abs_diff_eq(dim.flux, 1e-6), "nothing is lost");
            first.flux.x / dim.flux.x
        };
        assert_eq!([0.3, 0.5, 1.0].map(of_disc), [0.0, 0.0, 1.0]);
        assert!((0.3..0.9).contains(&of_disc(0.75)), "partly hidden: {}", of_disc(0.75));
        // A surface that is in its shadow, in air that is not.
        let shadow = LitPlace { irradiance: 0.4 * direct.irradiance(Vec3::Y), ..place };
        assert_eq!(told_apart(&found, &discs, &shadow)[2], found);
    }

    #[test]
    fn other_materials_may_begin_to_shine() {
        let mut scene = ceiling();
        scene.materials.push(Material::default());
        add_quad(&mut scene, Vec3::new(9.0, 3.0, 1.0), [Vec3::X, Vec3::Z], 1);
        let (mut discs, mut colors) = (EmissiveDiscs::default(), SurfaceColors::of(&scene));
        discs.update(&scene, &colors, 1.0);
        assert_eq!(discs.as_slice().len(), 1);
        colors[1].emission = Vec3::X;
        discs.update(&scene, &colors, 1.0);
        assert_eq!(discs.as_slice().len(), 2);
        discs.update(&scene, &colors, 0.0);
        assert!(discs.as_slice().is_empty(), "nothing shines");
    }
}
