//! Shadow maps against the shadow rays of the CPU.
#![cfg(all(feature = "cpu", feature = "gpu", feature = "blocking"))]

#[path = "support/gpu.rs"]
mod gpu;
#[path = "support/shadow_probe.rs"]
mod shadow_probe;

use std::path::Path;
use std::sync::Arc;

use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::Rng;
use probelight_runtime::gpu::ShadowMapOptions;
use probelight_scene::{AlphaMode, Camera, Light, Material, Scene, Texture, TextureSlot, load_gltf};
use probelight_trace::{Ray, Tracer, shadow_ray};
use shadow_probe::{Sample, map_visibility, visibility_for};

/// Points for each scene and light.
const SAMPLES: usize = 20_000;

fn bundled(name: &str) -> Arc<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    Arc::new(load_gltf(&folder.join(name)).unwrap())
}

/// Points spread evenly over all surfaces, on either side.
fn surface_samples(scene: &Scene, count: usize) -> Vec<Sample> {
    let mut rng = Rng::new(7, 0);
    let total = scene.surface_area();
    let mut samples = Vec::new();
    let mut area_before = 0.0;
    for triangle in 0..scene.triangles.len() {
        let area_behind = area_before + f64::from(scene.area(triangle));
        let rank = |area: f64| (area / total * count as f64) as usize;
        for _ in rank(area_before)..rank(area_behind) {
            let (mut u, mut v) = (rng.next_f32(), rng.next_f32());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = scene.corners(triangle);
            let side = if rng.next_f32() < 0.5 { 1.0 } else { -1.0 };
            let normal = side * scene.geometric_normal(triangle);
            samples.push(Sample { position: a + (b - a) * u + (c - a) * v, normal });
        }
        area_before = area_behind;
    }
    samples
}

/// Whether a point lies within a solid, or where another one touches it: nothing there is ever seen or lit.
fn is_hidden(tracer: &Tracer, sample: &Sample) -> bool {
    let ray = Ray::new(tracer.off_surface(sample.position, sample.normal), sample.normal);
    tracer
        .closest_hit(&ray)
        .is_some_and(|hit| hit.is_back_face && !tracer.scene().material(hit.triangle as usize).double_sided)
}

/// Visibility by a shadow ray; `None` if the light does not shine on this side.
fn ray_visibility(tracer: &Tracer, light: &Light, sample: &Sample) -> Option<f32> {
    let arriving = light.illuminate(sample.position)?;
    if sample.normal.dot(arriving.to_light) <= 0.0 {
        return None;
    }
    let ray = shadow_ray(sample.position, sample.normal, &arriving, tracer.offset());
    Some(if tracer.is_occluded(&ray) { 0.0 } else { 1.0 })
}

/// How maps differ from rays, over the samples on which the light could shine, as shares of those that it
/// reaches.
#[derive(Debug, Default)]
struct Disagreement {
    /// Samples that are lit by less than half where rays find them lit, or by more where not.
    share: f64,
    /// Light by maps minus light by rays.
    bias: f64,
}

fn compare(tracer: &Tracer, light: &Light, samples: &[Sample], by_maps: &[f32]) -> Disagreement {
    let pairs: Vec<(f32, f32)> = samples
        .iter()
        .zip(by_maps)
        .filter_map(|(sample, map)| Some((*map, ray_visibility(tracer, light, sample)?)))
        .collect();
    assert!(pairs.len() > SAMPLES / 50, "only {} samples face the light", pairs.len());
    let wrong = pairs.iter().filter(|(map, ray)| (map - ray).abs() > 0.5).count();
    let difference: f64 = pairs.iter().map(|(map, ray)| f64::from(map - ray)).sum();
    let lit = pairs.iter().filter(|(_, ray)| *ray > 0.0).count() as f64;
    Disagreement { share: wrong as f64 / lit, bias: difference / lit }
}

fn sun(x: f32, y: f32, z: f32) -> Light {
    Light::Directional { direction: Vec3::new(x, y, z).normalize(), irradiance: Vec3::ONE }
}

fn lamp(x: f32, y: f32, z: f32) -> Light {
    Light::Point { position: Vec3::new(x, y, z), intensity: Vec3::ONE, range: None }
}

fn spot(position: Vec3, target: Vec3, outer_angle: f32) -> Light {
    let direction = (target - position).normalize();
    let inner_angle = 0.5 * outer_angle;
    Light::Spot { position, direction, intensity: Vec3::ONE, inner_angle, outer_angle, range: None }
}

/// Scenes, lights that they are meant for, and the largest accepted share of wrong samples. Maps blur the borders
/// of shadows over three texels, so samples are only wrong near borders: there are few in the box, and many behind the
/// atrium's balustrades, most of all by a lamp whose texels are two centimetres wide there.
fn scenes_and_lights() -> Vec<(&'static str, Vec<Light>, f64)> {
    let middle = Vec3::new(2.78, 5.4, 2.8);
    let cornell = vec![
        lamp(0.7, 3.4, 1.6),
        lamp(2.8, 5.3, 2.8),
        spot(middle, Vec3::new(1.0, 0.0, 2.0), 0.6),
        spot(middle, Vec3::new(2.78, 0.0, 2.8), 1.4),
    ];
    let rooms = vec![sun(-0.6, -0.5, 0.7), sun(0.9, -0.15, 0.7), lamp(2.0, 2.0, 2.0)];
    let atrium = vec![ATRIUM_SUN, sun(-0.85, -0.3, 0.25)];
    vec![
        ("cornell.glb", cornell, 0.001),
        ("rooms.glb", rooms, 0.003),
        ("atrium.glb", atrium, MOST_WRONG_UNDER_THE_ATRIUM_SUN),
        ("atrium.glb", vec![lamp(3.0, 4.0, 0.5)], 0.02),
    ]
}

const ATRIUM_SUN: Light = Light::Directional {
    direction: Vec3::new(0.317_853_63, -0.908_153_24, 0.272_445_98),
    irradiance: Vec3::ONE,
};

const MOST_WRONG_UNDER_THE_ATRIUM_SUN: f64 = 0.005;

/// Largest accepted difference of all light that arrives.
const MOST_BIAS: f64 = 0.005;

#[test]
fn maps_agree_with_shadow_rays() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    for (name, lights, most_wrong) in scenes_and_lights() {
        let scene = bundled(name);
        let tracer = Tracer::new(scene.clone());
        let mut samples = surface_samples(&scene, SAMPLES);
        samples.retain(|sample| !is_hidden(&tracer, sample));
        let by_maps = map_visibility(gpu, &scene, &lights, &samples, ShadowMapOptions::default());
        for (light, by_maps) in lights.iter().zip(&by_maps) {
            let found = compare(&tracer, light, &samples, by_maps);
            assert!(found.share <= most_wrong, "{name}, {light:?}: {found:?}");
            assert!(found.bias.abs() <= MOST_BIAS, "{name}, {light:?}: {found:?}");
        }
    }
}

#[test]
fn the_comparison_notices_a_sun_a_few_degrees_off() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let scene = bundled("atrium.glb");
    let tracer = Tracer::new(scene.clone());
    let samples = surface_samples(&scene, SAMPLES);
    let moved = [sun(0.4, -1.0, 0.3)];
    let by_maps = map_visibility(gpu, &scene, &moved, &samples, ShadowMapOptions::default());
    let found = compare(&tracer, &ATRIUM_SUN, &samples, &by_maps[0]);
    assert!(found.share > MOST_WRONG_UNDER_THE_ATRIUM_SUN, "{found:?}");
}

/// Points a tenth of a millimetre from the edges of all triangles, on their fronts.
fn edge_samples(scene: &Scene) -> Vec<Sample> {
    let mut samples = Vec::new();
    for triangle in 0..scene.triangles.len() {
        let (corners, normal) = (scene.corners(triangle), scene.geometric_normal(triangle));
        for edge in 0..3 {
            let [from, to] = [corners[edge], corners[(edge + 1) % 3]];
            let inwards = 1e-4 * normal.cross(to - from).normalize();
            let along = (1..20).map(|i| from.lerp(to, i as f32 / 20.0));
            samples.extend(along.map(|position| Sample { position: position + inwards, normal }));
        }
    }
    samples
}

/// Mean visibility by maps of the samples that rays find lit, and of those that they find in the dark.
fn mean_lit_and_dark(tracer: &Tracer, light: &Light, samples: &[Sample], by_maps: &[f32]) -> [f32; 2] {
    [1.0, 0.0].map(|by_ray| {
        let is_wanted = |sample: &Sample| ray_visibility(tracer, light, sample) == Some(by_ray);
        let found: Vec<f32> = samples
            .iter()
            .zip(by_maps)
            .filter(|(sample, _)| is_wanted(sample))
            .map(|(_, map)| *map)
            .collect();
        found.iter().sum::<f32>() / found.len() as f32
    })
}

/// Where walls meet, half of a filter's texels hold the other wall.
#[test]
fn corners_are_as_light_as_rays_find_them() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let scene = bundled("cornell.glb");
    let tracer = Tracer::new(scene.clone());
    let samples = edge_samples(&scene);
    let lights = [lamp(2.0, 2.7, 2.5), lamp(1.0, 5.0, 4.0)];
    let by_maps = map_visibility(gpu, &scene, &lights, &samples, ShadowMapOptions::default());
    let agrees = |[lit, dark]: [f32; 2]| lit > 0.99 && dark < 0.05;
    for (light, by_maps) in lights.iter().zip(&by_maps) {
        let means = mean_lit_and_dark(&tracer, light, &samples, by_maps);
        assert!(agrees(means), "{light:?}: {means:?}");
    }
    let crossed = mean_lit_and_dark(&tracer, &lights[0], &samples, &by_maps[1]);
    assert!(!agrees(crossed), "the other lamp's maps go unnoticed: {crossed:?}");
}

/// How many samples that face a light it reaches, however weakly.
fn reached(light: &Light, samples: &[Sample], visibility: &[f32]) -> usize {
    let faces = |s: &Sample| light.illuminate(s.position).is_some_and(|a| s.normal.dot(a.to_light) > 0.0);
    samples.iter().zip(visibility).filter(|(sample, visible)| faces(sample) && **visible > 0.0).count()
}

#[test]
fn no_sun_reaches_the_sealed_room() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let scene = bundled("rooms.glb");
    let is_in_sealed_room = |s: &Sample| {
        let p = s.position + 1e-3 * s.normal;
        p.cmpgt(Vec3::new(6.06, 0.0, 0.0)).all() && p.cmplt(Vec3::new(10.0, 3.0, 5.0)).all()
    };
    let mut samples = surface_samples(&scene, 500_000);
    let (inside, outside): (Vec<Sample>, Vec<Sample>) = samples.drain(..).partition(is_in_sealed_room);
    assert!(inside.len() > 5_000, "{} samples", inside.len());
    let suns: Vec<Light> = (0..16)
        .map(|i| {
            let (angle, height) = (i as f32 * 2.4, 0.05 + 0.3 * (i % 8) as f32);
            sun(angle.cos(), -height, angle.sin())
        })
        .collect();
    let options = ShadowMapOptions { resolution: 1024, ..ShadowMapOptions::default() };
    let by_maps = map_visibility(gpu, &scene, &suns, &inside, options);
    for (light, visibility) in suns.iter().zip(&by_maps) {
        assert_eq!(reached(light, &inside, visibility), 0, "{light:?}");
    }
    let outside = &outside[..SAMPLES];
    let by_maps = map_visibility(gpu, &scene, &suns[..1], outside, options);
    assert!(reached(&suns[0], outside, &by_maps[0]) > 0, "it is not that the sun never shines");
}

#[test]
fn shadows_before_an_eye_are_sharper_than_the_scenes() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let scene = bundled("atrium.glb");
    let tracer = Tracer::new(Arc::clone(&scene));
    let eye = |position, target| Camera {
        name: "eye".into(),
        position,
        target,
        up: Vec3::Y,
        vertical_fov: 0.8,
        width: 640,
        height: 480,
    };
    let before = eye(Vec3::new(2.5, 1.6, 1.0), Vec3::new(0.0, 0.6, 0.0));
    let is_seen = |camera: &Camera, sample: &Sample| {
        let offset = sample.position - camera.position;
        let forward = (camera.target - camera.position).normalize();
        offset.length() < 3.0 && offset.normalize().dot(forward) > 0.92
    };
    let mut samples = surface_samples(&scene, 2_000_000);
    samples.retain(|sample| is_seen(&before, sample) && !is_hidden(&tracer, sample));
    let options = ShadowMapOptions { resolution: 1024, for_eye: true, ..ShadowMapOptions::default() };
    // With many lamps there is little room for each: theirs are made coarser, as it would be then.
    let lamp =
        Light::Point { position: Vec3::new(-7.0, 4.4, -2.0), intensity: Vec3::splat(50.0), range: None };
    let for_lamps = ShadowMapOptions { memory: 6 * 4 * 256 * 256, ..options };
    for (light, options) in [(ATRIUM_SUN, options), (lamp, for_lamps)] {
        let light = [light];
        let wrong = |eye: Option<&Camera>| {
            let by_maps = visibility_for(gpu, &scene, &light, &samples, options, eye);
            compare(&tracer, &light[0], &samples, &by_maps[0]).share
        };
        let (scenes, fitted) = (wrong(None), wrong(Some(&before)));
        assert!(scenes > 0.01, "{scenes}: there are borders of shadows");
        assert!(fitted < 0.4 * scenes, "{fitted} where the scene's maps have {scenes}");
        // One elsewhere has nothing to do with what lies there.
        let away = wrong(Some(&eye(Vec3::new(-11.0, 1.6, 5.0), Vec3::new(-20.0, 1.6, 8.0))));
        assert!((away / scenes - 1.0).abs() < 0.2, "{away} where the scene's maps have {scenes}");
    }
}

#[test]
fn masked_surfaces_let_light_through_their_holes() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    // A floor two metres wide under a sheet of the same size whose left half is a hole.
    let floor = Material::default();
    let half = Texture {
        name: String::new(),
        width: 2,
        height: 1,
        rgba8: [255, 255, 255, 0, 255, 255, 255, 255].into(),
    };
    let slot = TextureSlot { texture: 0, tex_coord: 0 };
    let sheet = Material {
        base_color_texture: Some(slot),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::default()
    };
    let mut scene = Scene { materials: vec![sheet, floor], textures: vec![half], ..Scene::default() };
    for (y, material) in [(1.0, 0), (0.0, 1)] {
        let first = scene.positions.len() as u32;
        for (u, v) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)] {
            scene.positions.push(Vec3::new(2.0 * u - 1.0, y, 2.0 * v - 1.0));
            // Half a texel's blend lies at the middle, where the two texels' centres are equally far.
            scene.uv0.push(Vec2::new(0.25 + 0.5 * u, v));
        }
        scene.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        scene.triangle_material.extend([material; 2]);
    }
    scene.normals = vec![Vec3::Y; 8];
    scene.tangents = vec![Vec3::X.extend(1.0); 8];
    scene.validate().unwrap();

    let samples: Vec<Sample> = (0..10)
        .map(|i| Sample { position: Vec3::new(-0.9 + 0.2 * i as f32, 0.0, 0.3), normal: Vec3::Y })
        .collect();
    let expected: Vec<f32> = (0..10).map(|i| if i < 5 { 1.0 } else { 0.0 }).collect();
    let down = [sun(0.0, -1.0, 0.0)];
    let by_maps = map_visibility(gpu, &scene, &down, &samples, ShadowMapOptions::default());
    assert_eq!(by_maps[0], expected);

    scene.materials[0].alpha_mode = AlphaMode::Opaque;
    let by_maps = map_visibility(gpu, &scene, &down, &samples, ShadowMapOptions::default());
    assert_eq!(by_maps[0], [0.0; 10], "an opaque sheet has no hole");
}
