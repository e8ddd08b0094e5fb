//! Objects in pictures of the GPU, against the CPU's.
#![cfg(feature = "gpu")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;
#[path = "support/shown_difference.rs"]
mod shown_difference;
mod support;

use std::path::Path;
use std::sync::Arc;

use probelight_asset::{GridBasis, GridBasisKind, GridLobe};
use probelight_math::glam::{EulerRot, Quat, Vec3};
use probelight_render::gpu::{GpuRenderer, GpuView, LitScene, Shading, ViewOptions};
use probelight_render::{Image, RenderOutput};
use probelight_runtime::gpu::{GpuOptions, GpuRuntime};
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Lighting, Object, Placement, Scene, Sky, load_gltf};
use shown_difference::shown_difference;
use support::{GpuPictures, LitExample, cornell_with_grid, cpu_picture, picture_lit_on_gpu};

/// As for scenes without objects, see `gpu_pictures.rs`.
const MOST_INDIRECT_DIFFERENCE: f64 = 0.02;
const MOST_DIRECT_DIFFERENCE: f64 = 0.03;

/// Where each backend finds direct light on surfels itself: rays of lights against shadow maps, in a coarse bake.
const MOST_DIFFERENCE_OF_DIRECT_LIGHT: f64 = 0.045;

fn model() -> Arc<Scene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/cornell.glb");
    Arc::new(load_gltf(&path).unwrap())
}

/// Two Cornell boxes as models of themselves.
fn objects(shift: f32) -> [Object; 2] {
    let model = model();
    [(Vec3::new(1.2 + shift, 1.0, 1.5), 0.5), (Vec3::new(4.6, 0.7, 2.0), 2.2)].map(|(translation, angle)| {
        let rotation = Quat::from_euler(EulerRot::YXZ, angle, 0.2, 0.1);
        Object::new(Arc::clone(&model), Placement { translation, rotation, scale: 0.3 }).unwrap()
    })
}

fn with_objects(shift: f32) -> LitExample {
    with_objects_in(GridBasis::default(), shift)
}

fn with_objects_in(basis: GridBasis, shift: f32) -> LitExample {
    let mut lit = cornell_with_grid(basis);
    for object in objects(shift) {
        lit.runtime.objects_mut().insert(object);
    }
    lit.runtime.converge(1e-3, 30);
    lit
}

fn view(view: GpuView) -> ViewOptions {
    ViewOptions { view, shading: Shading::Diffuse }
}

#[test]
fn objects_look_as_on_the_cpu() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = with_objects(0.0);
    let mut pictures = GpuPictures::new(gpu, &lit);
    for (output, gpu_view, most) in [
        (RenderOutput::Indirect, GpuView::Indirect, MOST_INDIRECT_DIFFERENCE),
        (RenderOutput::Irradiance, GpuView::Irradiance, MOST_INDIRECT_DIFFERENCE),
        (RenderOutput::Direct, GpuView::Direct, MOST_DIRECT_DIFFERENCE),
        (RenderOutput::Full, GpuView::Full, MOST_DIRECT_DIFFERENCE),
    ] {
        let found = shown_difference(&pictures.draw(&lit, view(gpu_view)), &cpu_picture(&lit, output));
        assert!(found <= most, "{gpu_view:?}: {found}");
    }
    let by_runtime = picture_lit_on_gpu(gpu, &lit, view(GpuView::Indirect));
    let reference = cpu_picture(&lit, RenderOutput::Indirect);
    let found = shown_difference(&by_runtime, &reference);
    assert!(found <= MOST_DIFFERENCE_OF_DIRECT_LIGHT, "lit on the GPU: {found}");
    // An object a hand's breadth beside its place is noticed.
    let moved = shown_difference(&cpu_picture(&with_objects(0.1), RenderOutput::Indirect), &reference);
    assert!(moved > MOST_INDIRECT_DIFFERENCE, "{moved}");
}

#[test]
fn other_bases_look_as_on_the_cpu() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let basis = |kind, lobe| GridBasis { kind, lobe };
    for basis in
        [basis(GridBasisKind::Axes6, GridLobe::Cosine), basis(GridBasisKind::Axes14, GridLobe::Angle)]
    {
        let lit = with_objects_in(basis, 0.0);
        let by_gpu = GpuPictures::new(gpu, &lit).draw(&lit, view(GpuView::Irradiance));
        let found = shown_difference(&by_gpu, &cpu_picture(&lit, RenderOutput::Irradiance));
        assert!(found <= MOST_INDIRECT_DIFFERENCE, "{basis:?}: {found}");
    }
}

/// Mean of a picture's pixels.
fn mean(image: &Image) -> Vec3 {
    image.pixels.iter().sum::<Vec3>() / image.pixels.len() as f32
}

#[test]
fn objects_that_left_leave_no_shadow() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = cornell_with_grid(GridBasis::default());
    let (device, queue) = (&gpu.device, &gpu.queue);
    let mut runtime =
        GpuRuntime::new(device, queue, Arc::clone(lit.runtime.baked()), GpuOptions::default()).unwrap();
    runtime.set_lighting(lit.runtime.lighting().clone()).unwrap();
    let (geometry, shadow_maps, grid) = (runtime.geometry(), runtime.shadow_maps(), runtime.grid());
    let baked = Arc::clone(lit.runtime.baked());
    let mut renderer = GpuRenderer::new(device, queue, baked, geometry, shadow_maps, grid).unwrap();
    let mut picture = |runtime: &mut GpuRuntime| {
        runtime.reset();
        (0..8).for_each(|_| runtime.step(&probelight_runtime::FrameInput::default()));
        renderer.still(&LitScene::of(runtime), &lit.camera, view(GpuView::Full), 4).unwrap()
    };
    let before = picture(&mut runtime);
    let ids = objects(0.0).map(|object| runtime.objects_mut().insert(object));
    let with = picture(&mut runtime);
    runtime.objects_mut().place(ids[0], Placement::at(Vec3::splat(90.0))).unwrap();
    let with_one = picture(&mut runtime);
    for id in ids {
        runtime.objects_mut().remove(id).unwrap();
    }
    let after = picture(&mut runtime);
    assert_eq!(before.pixels, after.pixels);
    assert!(mean(&with) != mean(&before) && mean(&with_one) != mean(&with));
}

#[test]
fn doors_shut_the_same_ways_as_on_the_cpu() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = cornell_with_grid(GridBasis::default());
    let baked = Arc::clone(lit.runtime.baked());
    // Without analytic lights, which the backends find in ways of their own.
    let light = Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() };
    let mut cpu = Runtime::new(Arc::clone(&baked));
    let mut gpu = GpuRuntime::new(&gpu.device, &gpu.queue, baked, GpuOptions::default()).unwrap();
    cpu.set_lighting(light.clone()).unwrap();
    gpu.set_lighting(light).unwrap();
    let both = |cpu: &mut Runtime, gpu: &mut GpuRuntime| {
        cpu.reset();
        gpu.reset();
        (0..10).for_each(|_| {
            cpu.step(&FrameInput::default());
            gpu.step(&FrameInput::default());
        });
        [cpu.receiver_irradiance().to_vec(), gpu.read_irradiance().unwrap()]
    };
    let difference = |a: &[Vec3], b: &[Vec3]| {
        let squares = a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f32>();
        (squares / a.iter().map(|a| a.length_squared()).sum::<f32>()).sqrt()
    };
    let open = both(&mut cpu, &mut gpu);
    assert!(difference(&open[0], &open[1]) < 1e-4);
    // Before the open side, as a shutter of half its width.
    let place = |x: f32| Placement { scale: 0.5, ..Placement::at(Vec3::new(x, 1.0, -1.6)) };
    let door = || Object::new(model(), place(0.0)).unwrap().as_door();
    let ids = (cpu.objects_mut().insert(door()), gpu.objects_mut().insert(door()));
    for x in [0.0, 1.5] {
        cpu.objects_mut().place(ids.0, place(x)).unwrap();
        gpu.objects_mut().place(ids.1, place(x)).unwrap();
        let shut = both(&mut cpu, &mut gpu);
        let (twins, change) = (difference(&shut[0], &shut[1]), difference(&open[0], &shut[0]));
        assert!(twins < 1e-4 && change > 0.1, "{twins} {change}");
    }
    cpu.objects_mut().remove(ids.0).unwrap();
    gpu.objects_mut().remove(ids.1).unwrap();
    let again = both(&mut cpu, &mut gpu);
    assert_eq!([difference(&open[0], &again[0]), difference(&open[1], &again[1])], [0.0; 2]);
}

#[test]
fn gloss_shows_where_light_comes_from() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut lit = cornell_with_grid(GridBasis::default());
    let mut model = Scene::clone(&model());
    for material in &mut model.materials {
        (material.metallic, material.roughness, material.base_color.x) = (1.0, 0.3, 1.0);
    }
    let placement = Placement { translation: Vec3::new(2.0, 1.0, 1.5), rotation: Quat::IDENTITY, scale: 0.3 };
    lit.runtime.objects_mut().insert(Object::new(Arc::new(model), placement).unwrap());
    lit.runtime.converge(1e-3, 30);
    let mut pictures = GpuPictures::new(gpu, &lit);
    let glossy = ViewOptions { view: GpuView::Indirect, shading: Shading::Physical };
    let (glossy, even) = (pictures.draw(&lit, glossy), pictures.draw(&lit, view(GpuView::Indirect)));
    assert!(glossy.pixels.iter().all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0));
    assert!(shown_difference(&glossy, &even) > MOST_INDIRECT_DIFFERENCE);
}
