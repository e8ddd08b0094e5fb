//! What bumps and gloss of the scene's surfaces show of the light in free space.
#![cfg(feature = "gpu")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;
#[allow(dead_code, reason = "each test binary uses a part")]
#[path = "../../probelight-bake/tests/support/shapes.rs"]
mod shapes;
mod support;

use std::sync::{Arc, LazyLock};

use probelight_asset::{BakedParts, BakedScene, GridBasis};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::{Vec2, Vec3, vec3};
use probelight_render::Image;
use probelight_render::gpu::{GpuView, Shading, ViewOptions};
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Camera, Lighting, Material, Sky, Texture, TextureSlot};
use probelight_trace::Silent;
use shapes::{scene_of, sheet, solid};
use support::{GpuPictures, LitExample, cornell_with_grid};

/// Half the width of the ground, and how high on the wall the eye looks, metres.
const GROUND: f32 = 12.0;
const HEIGHT: f32 = 1.5;

/// A wall on the ground under an even sky, both black: light comes from a quarter of all directions.
static WALL: LazyLock<BakedScene> = LazyLock::new(|| bake_wall(None));

fn bake_wall(grid_vertices: Option<u32>) -> BakedScene {
    let along_x = 2.0 * GROUND * Vec3::X;
    let ground = sheet(vec3(-GROUND, 0.0, -GROUND), 2.0 * GROUND * Vec3::Z, along_x);
    let wall = solid(vec3(-0.5, 0.0, -GROUND), vec3(0.0, 8.0, GROUND));
    let mut scene = scene_of(vec![(ground, false), (wall, true)]);
    scene.materials.fill(matt(Vec3::ZERO));
    // The normal map's x is up on the wall.
    scene.tangents.fill(Vec3::Y.extend(1.0));
    let options = BakeOptions {
        receivers: Some(2_000),
        gather_rays: Some(64),
        relight_rays: Some(64),
        sh_degree: Some(3),
        grid_vertices,
        grid_spacing: grid_vertices.is_none().then_some(1.5),
        ..BakeOptions::default()
    };
    bake(Arc::new(scene), &options, None, &Silent).unwrap()
}

fn matt(base_color: Vec3) -> Material {
    Material { base_color: base_color.extend(1.0), metallic: 0.0, ..Material::default() }
}

/// Made of a texel that stands for a slope by an angle along the tangent.
fn bumpy(material: Material, angle: f32, parts: &mut BakedParts) -> Material {
    let code = |value: f32| (128.0 + 127.0 * value).round() as u8;
    let rgba8 = [code(angle.sin()), 128, code(angle.cos()), 255].into();
    let scene = Arc::make_mut(&mut parts.scene);
    scene.textures.push(Texture { name: String::new(), width: 1, height: 1, rgba8 });
    let slot = TextureSlot { texture: scene.textures.len() as u32 - 1, tex_coord: 0 };
    Material { normal_texture: Some(slot), ..material }
}

/// The scene with all materials replaced, in its light, and that of the whole grid if asked for.
fn lit_with(
    baked: &BakedScene,
    lighting: Lighting,
    whole_grid: bool,
    material: impl FnOnce(&mut BakedParts) -> Material,
) -> Runtime {
    let mut parts = BakedParts::clone(baked);
    let material = material(&mut parts);
    for old in &mut Arc::make_mut(&mut parts.scene).materials {
        *old = Material { emission: old.emission, ..material.clone() };
    }
    let mut runtime = Runtime::new(Arc::new(BakedScene::new(parts).unwrap()));
    runtime.set_lighting(lighting).unwrap();
    runtime.converge(1e-3, 30);
    runtime.step(&FrameInput { whole_grid, ..FrameInput::default() });
    runtime
}

fn even_sky() -> Lighting {
    Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() }
}

fn camera(position: Vec3, target: Vec3, degrees: f32) -> Camera {
    let (name, vertical_fov) = ("test".into(), degrees.to_radians());
    Camera { name, position, target, up: Vec3::Y, vertical_fov, width: 48, height: 48 }
}

const IRRADIANCE: ViewOptions = ViewOptions { view: GpuView::Irradiance, shading: Shading::Physical };

/// The wall with bumps, straight from the front.
fn wall(baked: &BakedScene, angle: Option<f32>) -> LitExample {
    let material = |parts: &mut BakedParts| {
        let plain = matt(Vec3::ZERO);
        angle.map_or(plain.clone(), |angle| bumpy(plain, angle, parts))
    };
    let (position, target) = (vec3(4.0, HEIGHT, 0.0), vec3(0.0, HEIGHT, 0.0));
    let runtime = lit_with(baked, even_sky(), true, material);
    LitExample { runtime, camera: camera(position, target, 2.0) }
}

fn mean(image: &Image) -> Vec3 {
    image.pixels.iter().sum::<Vec3>() / image.pixels.len() as f32
}

#[test]
fn bumps_take_their_share_of_light_from_one_side() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let bright = |baked: &BakedScene, angle: Option<f32>, options: ViewOptions| {
        let lit = wall(baked, angle);
        mean(&GpuPictures::new(gpu, &lit).draw(&lit, options)).x
    };
    let flat = bright(&WALL, None, IRRADIANCE);
    // The sky goes on below the horizon as far as the ground's end.
    let horizon = (HEIGHT / GROUND).atan();
    for angle in [0.3f32, 0.6, -0.3, -0.6] {
        // Light of a wedge from just below the horizon to straight up: E = π L / 2 (sin to − sin from).
        let [from, to] =
            [-horizon, std::f32::consts::FRAC_PI_2].map(|end| (end - angle).min(std::f32::consts::FRAC_PI_2));
        let expected = (to.sin() - from.sin()) / (1.0 + horizon.sin());
        let found = bright(&WALL, Some(angle), IRRADIANCE) / flat;
        assert!((found / expected - 1.0).abs() < 0.06, "{angle}: {found}, not {expected}");
        assert!((found - 1.0).abs() > 0.1, "{found} is hardly a difference");
        // Without bumps or without a grid there is no share.
        let diffuse = ViewOptions { shading: Shading::Diffuse, ..IRRADIANCE };
        assert_eq!(bright(&WALL, Some(angle), diffuse), flat);
    }
    let without_grid = bake_wall(Some(0));
    assert_eq!(bright(&without_grid, Some(0.6), IRRADIANCE), bright(&without_grid, None, IRRADIANCE));
}

static CORNELL: LazyLock<LitExample> = LazyLock::new(|| cornell_with_grid(GridBasis::default()));

fn glossy() -> Material {
    Material { metallic: 0.7, roughness: 0.4, ..matt(Vec3::splat(0.6)) }
}

/// Full light, as it is and as it would be if none were known in free space.
fn with_and_without_grid(
    gpu: &probelight_runtime::gpu::GpuDevice,
    material: impl Fn(&mut BakedParts) -> Material,
) -> [Vec<Vec3>; 2] {
    let cornell = &*CORNELL;
    [true, false].map(|whole_grid| {
        let lighting = cornell.runtime.lighting().clone();
        let runtime = lit_with(cornell.runtime.baked(), lighting, whole_grid, &material);
        let lit = LitExample { runtime, camera: cornell.camera.clone() };
        let options = ViewOptions { view: GpuView::Full, shading: Shading::Physical };
        GpuPictures::new(gpu, &lit).draw(&lit, options).pixels
    })
}

#[test]
fn flat_normal_maps_change_nothing_and_matt_materials_need_no_grid() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let matt = || matt(Vec3::splat(0.6));
    let [with_grid, without] = with_and_without_grid(gpu, |_| matt());
    assert_eq!(with_grid, without);
    assert_eq!(with_and_without_grid(gpu, |parts| bumpy(matt(), 0.0, parts)), [with_grid.clone(), with_grid]);
    let [with_grid, without] = with_and_without_grid(gpu, |parts| bumpy(matt(), 0.4, parts));
    assert_ne!(with_grid, without);
    let [with_grid, without] = with_and_without_grid(gpu, |_| glossy());
    assert_ne!(with_grid, without);
    assert_eq!(with_and_without_grid(gpu, |parts| bumpy(glossy(), 0.0, parts)), [with_grid, without]);
}

/// Walls that hardly reflect: light comes from the lamp alone.
const DARK: Vec3 = Vec3::splat(0.03);

#[test]
fn a_glossy_floor_shows_the_lamp_where_a_mirror_would() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let eye = vec3(1.2, 1.5, 0.6);
    let lamp = vec3(2.78, 5.49, 2.8);
    let camera = camera(eye, vec3(1.7, 0.0, 1.5), 80.0);
    let brightest_place = |material: Material| {
        let runtime = lit_with(CORNELL.runtime.baked(), Lighting::default(), true, |_| material);
        let lit = LitExample { runtime, camera: camera.clone() };
        let options = ViewOptions { view: GpuView::Indirect, shading: Shading::Physical };
        let image = GpuPictures::new(gpu, &lit).draw(&lit, options);
        let on_floor = |index: usize| {
            let pixel = Vec2::new((index as u32 % image.width) as f32, (index as u32 / image.width) as f32);
            let ray = camera.ray_direction(pixel + 0.5);
            eye - eye.y / ray.y * ray
        };
        let of_floor = (0..image.pixels.len()).filter(|index| {
            let place = on_floor(*index);
            place.cmpge(vec3(0.1, -1.0, 0.1)).all() && place.cmple(vec3(5.4, 1.0, 5.4)).all()
        });
        let brightest = of_floor.max_by(|a, b| image.pixels[*a].y.total_cmp(&image.pixels[*b].y));
        on_floor(brightest.unwrap())
    };
    let mirror = eye + eye.y / (eye.y + lamp.y) * (vec3(lamp.x, -lamp.y, lamp.z) - eye);
    let polished = Material { metallic: 1.0, roughness: 0.25, ..matt(DARK) };
    let highlight = brightest_place(polished);
    assert!(highlight.distance(mirror) < 0.3, "{highlight}, not {mirror}");
    let of_matt = brightest_place(matt(DARK));
    assert!(of_matt.distance(mirror) > 1.0, "{of_matt}");
}
