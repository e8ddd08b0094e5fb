//! Pictures whose right answer is known on paper.

use std::f32::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_render::{Image, PixelFilter, RenderOptions, RenderOutput, Surfaces, View, render};
use probelight_scene::{Camera, Light, Lighting, Material, Scene, Sky};
use probelight_trace::{Cancelled, Hit, Progress, Silent, Tracer};

/// The same irradiance everywhere.
struct UniformIrradiance(Vec3);

impl Surfaces for UniformIrradiance {
    fn irradiance(&self, _hit: &Hit) -> Vec3 {
        self.0
    }
}

/// A lightmap without light.
const UNLIT: UniformIrradiance = UniformIrradiance(Vec3::ZERO);

/// Quads (counter-clockwise corners, seen from the front) of one material.
fn scene_of_quads(quads: &[[Vec3; 4]], material: Material) -> Arc<Scene> {
    let mut scene = Scene { materials: vec![material], ..Scene::default() };
    for corners in quads {
        let first = scene.positions.len() as u32;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        scene.positions.extend(corners);
        scene.normals.extend([normal; 4]);
        scene.tangents.extend([Vec4::X; 4]);
        scene.uv0.extend([Vec2::ZERO; 4]);
        scene.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        scene.triangle_material.extend([0; 2]);
    }
    scene.validate().unwrap();
    Arc::new(scene)
}

/// A closed box of edge 2 around the origin whose front faces look inwards.
fn closed_box(material: Material) -> Arc<Scene> {
    let quad = |axis: Vec3, u: Vec3| {
        let v = axis.cross(u);
        [(u + v), (u - v), (-u - v), (-u + v)].map(|corner| axis + corner)
    };
    let pairs = [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)];
    let quads: Vec<_> = pairs.iter().flat_map(|(a, u)| [quad(*a, *u), quad(-*a, *u)]).collect();
    let scene = scene_of_quads(&quads, material);
    assert!((0..12).all(|t| scene.geometric_normal(t).dot(scene.corners(t)[0]) < 0.0));
    scene
}

/// A square floor of half edge `half` at y = 0 whose front looks up.
fn floor(half: f32, material: Material) -> Arc<Scene> {
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    let corners = [corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    scene_of_quads(&[corners], material)
}

fn grey(albedo: f32) -> Material {
    Material { base_color: Vec3::splat(albedo).extend(1.0), ..Material::default() }
}

fn camera(position: Vec3, target: Vec3, up: Vec3) -> Camera {
    let (width, height) = (24, 16);
    Camera { name: "test".into(), position, target, up, vertical_fov: PI / 3.0, width, height }
}

fn picture(view: View, camera: &Camera, output: RenderOutput) -> Image {
    let options = RenderOptions { output, samples: 4, ..RenderOptions::default() };
    render(view, camera, &options, &Silent).unwrap()
}

fn all_close(image: &Image, expected: Vec3, tolerance: f32) -> bool {
    image.pixels.iter().all(|p| p.abs_diff_eq(expected, tolerance))
}

#[test]
fn furnace_with_its_analytic_irradiance_has_radiance_two_everywhere() {
    // Albedo ½ and Le = 1 in a closed box: L = Le + ρ L = 2, so E = 2π.
    let tracer = Tracer::new(closed_box(Material { emission: Vec3::ONE, ..grey(0.5) }));
    let lighting = Lighting::default();
    let uniform = UniformIrradiance(Vec3::splat(2.0 * PI));
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &uniform };
    let camera = camera(Vec3::ZERO, Vec3::new(1.0, 0.3, 0.2), Vec3::Y);
    assert!(all_close(&picture(view, &camera, RenderOutput::Full), Vec3::splat(2.0), 1e-5));
    assert!(all_close(&picture(view, &camera, RenderOutput::Direct), Vec3::ONE, 1e-5));
    assert!(all_close(&picture(view, &camera, RenderOutput::Indirect), Vec3::ONE, 1e-5));
    assert!(all_close(&picture(view, &camera, RenderOutput::Irradiance), Vec3::splat(2.0 * PI), 1e-5));

    let wrong = UniformIrradiance(Vec3::splat(2.1 * PI));
    let view = View { surfaces: &wrong, ..view };
    assert!(!all_close(&picture(view, &camera, RenderOutput::Full), Vec3::splat(2.0), 1e-5));
}

#[test]
fn a_floor_under_a_point_light_follows_the_cosine_and_the_distance() {
    let tracer = Tracer::new(floor(50.0, grey(0.6)));
    let light = Vec3::new(0.4, 2.0, -0.3);
    let lighting = Lighting {
        lights: vec![Light::Point { position: light, intensity: Vec3::new(10.0, 5.0, 1.0), range: None }],
        ..Lighting::default()
    };
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &UNLIT };
    let camera = camera(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, Vec3::Z);
    let options = RenderOptions { output: RenderOutput::Direct, samples: 64, filter: PixelFilter::Box };
    let image = render(view, &camera, &options, &Silent).unwrap();
    for y in 0..image.height {
        for x in 0..image.width {
            let direction = camera.ray_direction(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            let point = camera.position - direction * (camera.position.y / direction.y);
            let to_light = light - point;
            let irradiance = to_light.y / to_light.length().powi(3);
            let expected = Vec3::new(10.0, 5.0, 1.0) * irradiance * 0.6 / PI;
            let relative = (image.pixel(x, y) - expected).abs() / expected;
            assert!(relative.max_element() < 5e-3, "pixel {x}, {y}: {}, not {expected}", image.pixel(x, y));
        }
    }
}

#[test]
fn a_roof_between_light_and_floor_makes_the_floor_black() {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x * 5.0, y, z * 5.0);
    let quad = |y| [corner(-1.0, y, 1.0), corner(1.0, y, 1.0), corner(1.0, y, -1.0), corner(-1.0, y, -1.0)];
    let tracer = Tracer::new(scene_of_quads(&[quad(0.0), quad(2.0)], grey(0.6)));
    let sun = Light::Directional { direction: -Vec3::Y, irradiance: Vec3::ONE };
    let lighting = Lighting { lights: vec![sun], ..Lighting::default() };
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &UNLIT };
    let below = camera(Vec3::Y, Vec3::ZERO, Vec3::Z);
    let above = camera(Vec3::Y * 3.0, Vec3::ZERO, Vec3::Z);
    assert!(all_close(&picture(view, &below, RenderOutput::Full), Vec3::ZERO, 0.0));
    assert!(all_close(&picture(view, &above, RenderOutput::Full), Vec3::splat(0.6 / PI), 1e-5));
}

#[test]
fn the_camera_keeps_left_right_up_and_down() {
    // Looking along −Z at a floor under a sky: the floor fills the lower half, and a light on the right
    // makes the right side brighter.
    let tracer = Tracer::new(floor(1000.0, grey(0.5)));
    let light =
        Light::Point { position: Vec3::new(8.0, 2.0, -8.0), intensity: Vec3::splat(100.0), range: None };
    let sky = Sky::Uniform(Vec3::new(0.0, 0.0, 7.0));
    let lighting = Lighting { lights: vec![light], sky, ..Lighting::default() };
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &UNLIT };
    let camera = camera(Vec3::Y, Vec3::new(0.0, 1.0, -1.0), Vec3::Y);
    let image = picture(view, &camera, RenderOutput::Full);
    assert!(image.pixels[..24 * 7].iter().all(|p| *p == Vec3::new(0.0, 0.0, 7.0)), "sky above");
    assert!(image.pixels[24 * 9..].iter().all(|p| p.x > 0.0 && p.x == p.z), "floor below");
    assert!(image.pixel(20, 11).x > 1.5 * image.pixel(3, 11).x, "light on the right");
}

#[test]
fn emission_shows_on_front_faces_and_follows_its_scale() {
    let tracer = Tracer::new(floor(50.0, Material { emission: Vec3::splat(3.0), ..grey(0.5) }));
    let lighting = Lighting { emissive_scale: 2.0, ..Lighting::default() };
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &UNLIT };
    let front = picture(view, &camera(Vec3::Y, Vec3::ZERO, Vec3::Z), RenderOutput::Full);
    let back = picture(view, &camera(-Vec3::Y, Vec3::ZERO, Vec3::Z), RenderOutput::Full);
    assert!(all_close(&front, Vec3::splat(6.0), 1e-5));
    assert!(all_close(&back, Vec3::ZERO, 0.0));
}

/// Counts rows and asks to stop at once when told so.
#[derive(Default)]
struct Counter {
    begun: AtomicU64,
    done: AtomicU64,
    stop: bool,
}

impl Progress for Counter {
    fn begin(&self, _stage: &str, total: u64) {
        self.begun.fetch_add(total, Ordering::Relaxed);
    }

    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        self.stop
    }
}

#[test]
fn progress_is_complete_and_cancellation_is_heard() {
    let tracer = Tracer::new(floor(5.0, grey(0.5)));
    let lighting = Lighting::default();
    let view = View { world: (&tracer).into(), lighting: &lighting, surfaces: &UNLIT };
    let camera = camera(Vec3::Y, Vec3::ZERO, Vec3::Z);
    let (patient, impatient) = (Counter::default(), Counter { stop: true, ..Counter::default() });
    render(view, &camera, &RenderOptions::default(), &patient).unwrap();
    assert_eq!((patient.begun.into_inner(), patient.done.into_inner()), (16, 16));
    assert_eq!(render(view, &camera, &RenderOptions::default(), &impatient), Err(Cancelled));
}
