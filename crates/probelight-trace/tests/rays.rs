//! The tracer against every triangle tested one by one, and in closed rooms.

mod scenes;

use std::path::Path;
use std::sync::Arc;

use probelight_math::glam::{DVec3, Vec2, Vec3};
use probelight_math::sampling::{Rng, sphere_from_square};
use probelight_scene::{AlphaMode, Material, Scene, Texture, TextureSlot, load_gltf};
use probelight_trace::{Ray, Tracer};
use proptest::prelude::*;
use scenes::closed_box;

/// Rays nearer to an edge than this, in barycentric units, are not compared: either answer is right.
const EDGE_MARGIN: f64 = 1e-4;

/// What testing every triangle in f64 finds.
enum Exact {
    Miss,
    Hit(usize, f64),
    /// Too near to an edge, or two surfaces too near to each other, to tell.
    Unclear,
}

fn exact_closest_hit(scene: &Scene, ray: &Ray) -> Exact {
    let mut hits = Vec::new();
    for t in 0..scene.triangles.len() {
        let [a, b, c] = scene.corners(t).map(|corner| corner.as_dvec3());
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(direction);
        if slope.abs() < 1e-4 * normal.length() * direction.length() {
            // Nearly edge-on: cannot tell, unless the ray's line passes far away.
            if (a - origin).cross(direction).length()
                < 4.0 * direction.length() * (b - a).length().max((c - a).length())
            {
                return Exact::Unclear;
            }
            continue;
        }
        let distance = normal.dot(a - origin) / slope;
        let at = origin + direction * distance;
        let area = normal.length_squared();
        let v = (at - a).cross(c - a).dot(normal) / area;
        let w = (b - a).cross(at - a).dot(normal) / area;
        let inside = v.min(w).min(1.0 - v - w);
        let from_ends = distance.min(f64::from(ray.max_distance) - distance);
        if inside > -EDGE_MARGIN && from_ends > -1e-4 {
            let barycentric = Vec2::new(v as f32, w as f32);
            match solidity(scene, t, barycentric) {
                Some(false) => continue,
                Some(true) if inside > EDGE_MARGIN && from_ends > 1e-4 => hits.push((distance, t)),
                _ => return Exact::Unclear,
            }
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    match hits[..] {
        [] => Exact::Miss,
        [(first, _), (second, _), ..] if second - first < 1e-4 => Exact::Unclear,
        [(distance, triangle), ..] => Exact::Hit(triangle, distance),
    }
}

/// Whether a masked surface exists at a point; unknown where alpha is near the cutoff.
fn solidity(scene: &Scene, triangle: usize, barycentric: Vec2) -> Option<bool> {
    let AlphaMode::Mask { cutoff } = scene.material(triangle).alpha_mode else { return Some(true) };
    let alpha = scene.base_color_texel(triangle, barycentric).w;
    ((alpha - cutoff).abs() > 0.01).then_some(alpha > cutoff)
}

/// Random triangles in the unit cube; half of them have holes where a small texture is transparent.
fn random_triangles(seed: u64, count: usize) -> Scene {
    let mut rng = Rng::new(seed, 1);
    let holes = Texture {
        name: String::new(),
        width: 4,
        height: 4,
        rgba8: (0..16).flat_map(|i| [255, 255, 255, if (i + i / 4) % 2 == 0 { 255 } else { 0 }]).collect(),
    };
    let masked = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(TextureSlot { texture: 0, tex_coord: 0 }),
        ..Material::default()
    };
    let mut scene =
        Scene { materials: vec![Material::default(), masked], textures: vec![holes], ..Scene::default() };
    for triangle in 0..count {
        let centre = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let size = 0.05 + 0.5 * rng.next_f32() * rng.next_f32();
        let first = scene.positions.len() as u32;
        for uv in [Vec2::ZERO, Vec2::X, Vec2::Y] {
            scene.positions.push(centre + size * sphere_from_square(rng.next_vec2()));
            scene.normals.push(Vec3::Y);
            scene.tangents.push(Vec3::X.extend(1.0));
            scene.uv0.push(uv * 1.5);
        }
        scene.triangles.push([first, first + 1, first + 2]);
        scene.triangle_material.push((triangle % 2) as u32);
    }
    scene
}

fn random_ray(rng: &mut Rng) -> Ray {
    let origin = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 3.0 - Vec3::ONE;
    let inside = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
    let max_distance = if rng.next_f32() < 0.3 { rng.next_f32() * 2.0 } else { f32::INFINITY };
    if rng.next_f32() < 0.2 {
        return axis_ray(rng, inside, max_distance);
    }
    Ray { origin, direction: (inside - origin) * (0.2 + 2.0 * rng.next_f32()), max_distance }
}

/// A ray through `inside` along an axis; the other components are zeros of either sign.
fn axis_ray(rng: &mut Rng, inside: Vec3, max_distance: f32) -> Ray {
    let axis = (rng.next_u32() % 3) as usize;
    let signs = Vec3::from_array(std::array::from_fn(|_| if rng.next_f32() < 0.5 { -1.0 } else { 1.0 }));
    let mut direction = Vec3::ZERO.copysign(signs);
    direction[axis] = signs[axis];
    Ray { origin: inside - direction * 0.7, direction, max_distance }
}

/// How many of `count` random rays have a clear answer; all of those must be traced right.
fn compare_with_brute_force(scene: Scene, seed: u64, count: usize) -> usize {
    let tracer = Tracer::new(Arc::new(scene));
    let mut rng = Rng::new(seed, 2);
    let mut clear = 0;
    for _ in 0..count {
        let ray = random_ray(&mut rng);
        let found = tracer.closest_hit(&ray);
        match exact_closest_hit(tracer.scene(), &ray) {
            Exact::Unclear => continue,
            Exact::Miss => {
                assert!(found.is_none(), "{ray:?} hits nothing, but {found:?}");
                assert!(!tracer.is_occluded(&ray));
            }
            Exact::Hit(triangle, distance) => {
                let found = found.unwrap_or_else(|| panic!("{ray:?} misses triangle {triangle}"));
                assert_eq!(found.triangle as usize, triangle, "{ray:?}");
                assert!((f64::from(found.distance) - distance).abs() < 1e-4 * (1.0 + distance));
                assert!(tracer.is_occluded(&ray));
                let [a, b, c] = tracer.scene().corners(triangle).map(|corner| corner.as_dvec3());
                let (v, w) = (f64::from(found.barycentric.x), f64::from(found.barycentric.y));
                let at: DVec3 = a + (b - a) * v + (c - a) * w;
                assert!(at.distance((ray.origin + ray.direction * found.distance).as_dvec3()) < 1e-3);
                assert!(found.normal.dot(ray.direction) <= 0.0);
                let front = tracer.front_normal(found.triangle);
                assert_eq!(found.is_back_face, front.dot(ray.direction) > 0.0);
            }
        }
        clear += 1;
    }
    clear
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn tracer_finds_what_testing_every_triangle_finds(seed: u64, count in 1usize..200) {
        prop_assert!(compare_with_brute_force(random_triangles(seed, count), seed, 100) > 20);
    }
}

#[test]
fn stacked_and_equal_triangles_are_all_found() {
    // Boxes that cannot be told apart make the deepest trees.
    let mut scene = random_triangles(3, 1);
    let (triangle, material) = (scene.triangles[0], scene.triangle_material[0]);
    scene.triangles = vec![triangle; 5000];
    scene.triangle_material = vec![material; 5000];
    let tracer = Tracer::new(Arc::new(scene));
    let [a, b, c] = tracer.scene().corners(0);
    let origin = Vec3::splat(5.0);
    let hit = tracer.closest_hit(&Ray::new(origin, (a + b + c) / 3.0 - origin)).unwrap();
    assert!((hit.distance - 1.0).abs() < 1e-4);
}

#[test]
fn visibility_ends_before_the_far_point() {
    let tracer = Tracer::new(Arc::new(closed_box(Vec3::ONE, Material::default())));
    let centre = Vec3::splat(0.5);
    assert!(tracer.is_visible(centre, Vec3::new(0.3, 0.999, 0.4)));
    assert!(!tracer.is_visible(centre, Vec3::new(0.3, 1.001, 0.4)));
}

/// Rays from inside a closed scene that leave it.
fn escapes(scene: Scene, margin: f32, count: u32) -> u32 {
    let bounds = scene.bounds();
    let tracer = Tracer::new(Arc::new(scene));
    let mut rng = Rng::new(5, 5);
    let is_lost = |_: &u32| {
        let at = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
        let origin = bounds.min + bounds.size() * (at * (1.0 - 2.0 * margin) + margin);
        let direction = sphere_from_square(rng.next_vec2());
        tracer.closest_hit(&Ray::new(origin, direction)).is_none()
    };
    (0..count).filter(is_lost).count() as u32
}

#[test]
fn nothing_escapes_from_closed_rooms() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    let furnace = load_gltf(&assets.join("furnace.glb")).unwrap();
    assert_eq!(escapes(furnace, 0.0, 1_000_000), 0);
    // Walls of many thin triangles, far from the origin, have edges everywhere.
    assert_eq!(escapes(tessellated_box(60, Vec3::new(100.0, -40.0, 7.0)), 0.001, 1_000_000), 0);
}

/// A closed box whose faces are grids of `steps` by `steps` quads.
fn tessellated_box(steps: u32, shift: Vec3) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    let size = Vec3::new(4.0, 3.0, 5.0);
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    for (edge_u, edge_v) in [(x, y), (y, z), (z, x)] {
        let across = x + y + z - edge_u - edge_v;
        for (corner, edge_u, edge_v) in [(Vec3::ZERO, edge_u, edge_v), (across, edge_v, edge_u)] {
            add_grid(&mut scene, shift + corner, edge_u, edge_v, steps);
        }
    }
    scene
}

fn add_grid(scene: &mut Scene, corner: Vec3, edge_u: Vec3, edge_v: Vec3, steps: u32) {
    let first = scene.positions.len() as u32;
    for i in 0..=steps {
        for j in 0..=steps {
            let (u, v) = (i as f32 / steps as f32, j as f32 / steps as f32);
            scene.positions.push(corner + edge_u * u + edge_v * v);
            scene.normals.push(edge_u.cross(edge_v).normalize());
            scene.tangents.push(edge_u.normalize().extend(1.0));
            scene.uv0.push(Vec2::new(u, v));
        }
    }
    for i in 0..steps {
        for j in 0..steps {
            let at = |di: u32, dj: u32| first + (i + di) * (steps + 1) + j + dj;
            scene.triangles.extend([[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]);
            scene.triangle_material.extend([0; 2]);
        }
    }
}

#[test]
fn rays_without_numbers_hit_nothing_and_end() {
    let tracer = Tracer::new(Arc::new(closed_box(Vec3::ONE, Material::default())));
    for ray in [
        Ray::new(Vec3::NAN, Vec3::Y),
        Ray::new(Vec3::ZERO, Vec3::new(0.0, f32::NAN, 1.0)),
        Ray::new(Vec3::INFINITY, Vec3::Y),
    ] {
        assert_eq!(tracer.closest_hit(&ray), None);
        assert!(!tracer.is_occluded(&ray));
    }
}
