//! Small bakes of the bundled scenes under light, drawn on the GPU.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::Path;
use std::sync::Arc;

use probelight_asset::{BakedParts, BakedScene, GridBasis, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_math::glam::{Vec3, vec3};
use probelight_render::gpu::{GpuRenderer, LitScene, PictureTarget, UploadedLight, ViewOptions};
use probelight_render::{Image, RenderOptions, RenderOutput, View, render};
use probelight_runtime::Runtime;
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime, ShadowMapOptions};
use probelight_scene::{Camera, Light, Lighting, Material, Scene, Sky, load_gltf};
use probelight_trace::Silent;

/// A scene, its light, and where it is looked at from.
pub(crate) struct LitExample {
    pub(crate) runtime: Runtime,
    pub(crate) camera: Camera,
}

/// A bundled scene, baked as quickly as it still looks like something.
pub(crate) fn lit_scene(name: &str) -> LitExample {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../assets/scenes/{name}.glb"));
    let mut scene = load_gltf(&path).unwrap();
    if name == "atrium" {
        keep_near_the_camera(&mut scene);
    }
    let options = match name {
        // Its patches of sun are small: it needs more samples, which the hybrid method has.
        "rooms" => BakeOptions {
            receivers: Some(20_000),
            gather_rays: Some(32),
            grid_vertices: Some(0),
            ..BakeOptions::default()
        },
        _ => BakeOptions {
            method: Some(Method::Paper),
            receivers: Some(3_000),
            gather_rays: Some(64),
            relight_rays: Some(64),
            sh_degree: Some(3),
            max_rank: Some(8),
            grid_vertices: Some(0),
            ..BakeOptions::default()
        },
    };
    lit(bake(Arc::new(scene), &options, None, &Silent).unwrap(), name)
}

/// The Cornell box without its blocks and with a grid, and the camera nearer to it.
pub(crate) fn cornell_with_grid(grid_basis: GridBasis) -> LitExample {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/cornell_empty.glb");
    let options = BakeOptions {
        receivers: Some(2_000),
        gather_rays: Some(64),
        relight_rays: Some(64),
        sh_degree: Some(3),
        // Finer near the lamp than elsewhere.
        grid_vertices: Some(500),
        grid_basis: Some(grid_basis),
        ..BakeOptions::default()
    };
    let scene = Arc::new(load_gltf(&path).unwrap());
    let mut lit = lit(bake(scene, &options, None, &Silent).unwrap(), "cornell");
    lit.camera.position.z = -3.0;
    lit
}

/// The Cornell box from a baked file, so that its pictures only change when the renderer or the runtime does. Made by
///
/// ```sh
/// probelight bake assets/scenes/cornell.glb -o crates/probelight-render/tests/data/cornell.plight \
///     --receivers 800 --rays 256 --near-radius 1.5 --relight-rays 64 --sh-degree 3 --max-rank 8 --grid 0
/// ```
pub(crate) fn baked_cornell() -> LitExample {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cornell.plight");
    lit(BakedScene::read(&path).unwrap(), "cornell")
}

/// The same with all of it made of one material.
pub(crate) fn baked_cornell_of(material: &Material) -> LitExample {
    let mut parts = BakedParts::clone(baked_cornell().runtime.baked());
    Arc::make_mut(&mut parts.scene).materials.fill(material.clone());
    lit(BakedScene::new(parts).unwrap(), "cornell")
}

fn lit(baked: BakedScene, name: &str) -> LitExample {
    let mut runtime = Runtime::new(Arc::new(baked));
    runtime.set_lighting(lighting(name)).unwrap();
    runtime.converge(1e-3, 30);
    LitExample { runtime, camera: camera(name) }
}

/// Leaves of the atrium what lies before the camera: each of its 76,700 triangles would need a texel.
fn keep_near_the_camera(scene: &mut Scene) {
    let is_near = |triangle: usize| {
        let [a, b, c] = scene.corners(triangle);
        let middle = (a + b + c) / 3.0;
        middle.x > -13.0 && middle.x < -5.0 && middle.z > 0.0
    };
    let kept: Vec<usize> = (0..scene.triangles.len()).filter(|t| is_near(*t)).collect();
    scene.triangles = kept.iter().map(|t| scene.triangles[*t]).collect();
    scene.triangle_material = kept.iter().map(|t| scene.triangle_material[*t]).collect();
    scene.sources.triangles = kept.iter().map(|t| scene.sources.triangles[*t]).collect();
    scene.validate().unwrap();
}

fn lighting(name: &str) -> Lighting {
    let sun = |direction: Vec3, sky: Vec3| Lighting {
        lights: vec![Light::Directional {
            direction: direction.normalize(),
            irradiance: vec3(20.0, 18.0, 15.0),
        }],
        sky: Sky::Gradient { zenith: sky, horizon: 1.5 * sky, ground: 0.3 * sky },
        emissive_scale: 1.0,
    };
    match name {
        "cornell" => Lighting {
            lights: vec![Light::Point {
                position: vec3(2.0, 4.4, 1.6),
                intensity: vec3(12.0, 11.0, 9.0),
                range: None,
            }],
            sky: Sky::default(),
            emissive_scale: 0.1,
        },
        "rooms" => sun(vec3(-0.1, -0.8, 0.7), vec3(0.4, 0.55, 0.8)),
        _ => sun(vec3(0.35, -1.0, 0.3), vec3(0.6, 0.9, 1.5)),
    }
}

fn camera(name: &str) -> Camera {
    let (position, target, degrees): (Vec3, Vec3, f32) = match name {
        "cornell" => (vec3(2.78, 2.73, -8.0), vec3(2.78, 2.73, 0.0), 39.3),
        "rooms" => (vec3(0.6, 1.6, 4.4), vec3(5.8, 1.2, 1.2), 65.0),
        _ => (vec3(-13.0, 1.7, 0.0), vec3(-8.0, 3.0, 5.0), 70.0),
    };
    let (width, height) = (160, 120);
    Camera {
        name: name.into(),
        position,
        target,
        up: Vec3::Y,
        vertical_fov: degrees.to_radians(),
        width,
        height,
    }
}

/// Draws one scene with the light of its CPU runtime.
pub(crate) struct GpuPictures<'a> {
    gpu: &'a GpuDevice,
    light: UploadedLight,
    renderer: GpuRenderer,
}

impl<'a> GpuPictures<'a> {
    pub(crate) fn new(gpu: &'a GpuDevice, lit: &LitExample) -> Self {
        let GpuDevice { device, queue, .. } = gpu;
        let baked = lit.runtime.baked();
        let light = UploadedLight::new(device, queue, baked, ShadowMapOptions::default()).unwrap();
        let (geometry, shadow_maps, grid) = (light.geometry(), light.shadow_maps(), light.grid());
        let renderer = GpuRenderer::new(device, queue, baked.clone(), geometry, shadow_maps, grid).unwrap();
        Self { gpu, light, renderer }
    }

    /// As many samples per pixel as [`cpu_picture`] has.
    pub(crate) fn draw(&mut self, lit: &LitExample, options: ViewOptions) -> Image {
        self.update(lit);
        self.renderer.still(&self.light.scene(&lit.runtime), &lit.camera, options, SAMPLES).unwrap()
    }

    pub(crate) fn draw_on_gpu(&mut self, lit: &LitExample, options: ViewOptions) -> PictureTarget {
        self.update(lit);
        let GpuDevice { device, queue, .. } = self.gpu;
        let target = PictureTarget::new(device, lit.camera.width, lit.camera.height).unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.renderer.draw(&mut encoder, &target, &self.light.scene(&lit.runtime), &lit.camera, options);
        queue.submit([encoder.finish()]);
        target
    }

    fn update(&mut self, lit: &LitExample) {
        let GpuDevice { device, queue, .. } = self.gpu;
        self.light.update(device, queue, &lit.runtime).unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.light.encode(device, queue, &mut encoder);
        queue.submit([encoder.finish()]);
    }
}

/// Samples per pixel of pictures that are compared.
const SAMPLES: u32 = 64;

/// The CPU's picture of the same.
pub(crate) fn cpu_picture(lit: &LitExample, output: RenderOutput) -> Image {
    let options = RenderOptions { output, samples: SAMPLES, ..RenderOptions::default() };
    render(View::of(&lit.runtime), &lit.camera, &options, &Silent).unwrap()
}

/// The same picture, lit by the GPU's own runtime.
pub(crate) fn picture_lit_on_gpu(gpu: &GpuDevice, lit: &LitExample, options: ViewOptions) -> Image {
    let GpuDevice { device, queue, .. } = gpu;
    let baked = lit.runtime.baked();
    let mut runtime = GpuRuntime::new(device, queue, baked.clone(), GpuOptions::default()).unwrap();
    runtime.set_lighting(lit.runtime.lighting().clone()).unwrap();
    for object in lit.runtime.objects().as_slice() {
        runtime.objects_mut().insert(object.clone());
    }
    runtime.converge(1e-3, 30).unwrap();
    let (geometry, shadow_maps, grid) = (runtime.geometry(), runtime.shadow_maps(), runtime.grid());
    let mut renderer = GpuRenderer::new(device, queue, baked.clone(), geometry, shadow_maps, grid).unwrap();
    renderer.still(&LitScene::of(&runtime), &lit.camera, options, SAMPLES).unwrap()
}
