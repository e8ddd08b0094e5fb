//! Pictures of the GPU: against the CPU's, and against pictures that were looked at.
#![cfg(feature = "gpu")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;
#[path = "support/shown_difference.rs"]
mod shown_difference;
mod support;

use std::path::{Path, PathBuf};

use probelight_math::glam::Vec3;
use probelight_render::gpu::{Coloring, GpuView, PictureTarget, Presenter, Shading, Shown, ViewOptions};
use probelight_render::{DisplayImage, Exposure, Image, RenderOutput, ToneMap};
use probelight_runtime::gpu::GpuDevice;
use probelight_runtime::gpu::readback::read_texture;
use shown_difference::{difference, shown_difference};
use support::{GpuPictures, baked_cornell, cpu_picture, lit_scene, picture_lit_on_gpu};

/// Pictures of indirect light are the same but for noise at edges and mip levels of textures. Those with direct light
/// also differ along the borders of shadows, which maps blur over three texels.
const MOST_INDIRECT_DIFFERENCE: f64 = 0.02;
const MOST_DIRECT_DIFFERENCE: f64 = 0.03;

/// Where each backend finds direct light on surfels itself, rays of lights are compared with shadow maps. Coarse bakes such as
/// these show the noise of both, in patches of sun behind windows above all: this one of the rooms misses the path tracer's
/// light under `rooms_sun` by 20 % on the CPU and by 16 % on the GPU.
const MOST_DIFFERENCE_OF_DIRECT_LIGHT: f64 = 0.047;

fn compare_with_cpu(name: &str) {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = lit_scene(name);
    let mut pictures = GpuPictures::new(gpu, &lit);
    for (output, view, most) in [
        (RenderOutput::Indirect, GpuView::Indirect, MOST_INDIRECT_DIFFERENCE),
        (RenderOutput::Irradiance, GpuView::Irradiance, MOST_INDIRECT_DIFFERENCE),
        (RenderOutput::Direct, GpuView::Direct, MOST_DIRECT_DIFFERENCE),
        (RenderOutput::Full, GpuView::Full, MOST_DIRECT_DIFFERENCE),
    ] {
        let by_gpu = pictures.draw(&lit, ViewOptions { view, shading: Shading::Diffuse });
        let found = shown_difference(&by_gpu, &cpu_picture(&lit, output));
        assert!(found <= most, "{name}, {view:?}: {found}");
    }
    let options = ViewOptions { view: GpuView::Indirect, shading: Shading::Diffuse };
    let lit_on_gpu = picture_lit_on_gpu(gpu, &lit, options);
    let found = shown_difference(&lit_on_gpu, &cpu_picture(&lit, RenderOutput::Indirect));
    assert!(found <= MOST_DIFFERENCE_OF_DIRECT_LIGHT, "{name}, lit on the GPU: {found}");
}

#[test]
fn cornell_looks_as_on_the_cpu() {
    compare_with_cpu("cornell");
}

#[test]
fn rooms_look_as_on_the_cpu() {
    compare_with_cpu("rooms");
}

#[test]
fn the_atrium_looks_as_on_the_cpu() {
    compare_with_cpu("atrium");
}

#[test]
fn the_comparison_notices_other_light() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut lit = baked_cornell();
    let mut pictures = GpuPictures::new(gpu, &lit);
    let options = ViewOptions { view: GpuView::Indirect, shading: Shading::Diffuse };
    let before = cpu_picture(&lit, RenderOutput::Indirect);
    lit.runtime.set_base_color(0, Vec3::new(0.5, 0.6, 0.7)).unwrap();
    lit.runtime.converge(1e-3, 30);
    let found = shown_difference(&pictures.draw(&lit, options), &before);
    assert!(found > MOST_INDIRECT_DIFFERENCE, "{found}");
}

/// Largest accepted FLIP difference of a picture from the one that was looked at: drivers round differently, which
/// shows at edges.
const MOST_SNAPSHOT_DIFFERENCE: f64 = 0.01;

fn snapshot_path(view: GpuView, shading: Shading) -> PathBuf {
    let name = format!("{view:?}_{shading:?}.png").to_lowercase();
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots").join(name)
}

fn shown(image: &Image, view: GpuView) -> DisplayImage {
    if view.is_light() {
        return ToneMap::new(Exposure::Automatic, image).apply(image);
    }
    DisplayImage::from_colors(image)
}

/// The committed picture, linear; or after setting `PROBELIGHT_UPDATE_SNAPSHOTS` the picture itself, now committed.
fn snapshot(picture: &DisplayImage, path: &Path) -> Image {
    if std::env::var_os("PROBELIGHT_UPDATE_SNAPSHOTS").is_some() {
        picture.write_png(path).unwrap();
    }
    let file = image::open(path).unwrap().into_rgb8();
    let (width, height) = file.dimensions();
    linear(&DisplayImage { width, height, pixels: file.pixels().map(|pixel| pixel.0).collect() })
}

fn linear(picture: &DisplayImage) -> Image {
    let pixels = picture.pixels.iter().map(|p| probelight_math::color::linear_from_srgb8(*p)).collect();
    Image { width: picture.width, height: picture.height, pixels }
}

#[test]
fn every_view_is_as_it_was_looked_at() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut lit = baked_cornell();
    (lit.camera.width, lit.camera.height) = (128, 96);
    let mut pictures = GpuPictures::new(gpu, &lit);
    let diffuse = GpuView::ALL.map(|view| ViewOptions { view, shading: Shading::Diffuse });
    let physical = ViewOptions { view: GpuView::Full, shading: Shading::Physical };
    let mut snapshots = Vec::new();
    for options in diffuse.into_iter().chain([physical]) {
        let picture = shown(&pictures.draw(&lit, options), options.view);
        let expected = snapshot(&picture, &snapshot_path(options.view, options.shading));
        let found = difference(&linear(&picture), &expected);
        assert!(found <= MOST_SNAPSHOT_DIFFERENCE, "{options:?}: {found}");
        snapshots.push(expected);
    }
    // The two ways to shade a box of rough plaster are nearly the same; all other views are not.
    for (i, a) in snapshots[..GpuView::ALL.len()].iter().enumerate() {
        for b in &snapshots[..i] {
            assert!(difference(a, b) > MOST_SNAPSHOT_DIFFERENCE, "view {i} is mistaken for another");
        }
    }
}

#[test]
fn windows_show_what_files_hold() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = baked_cornell();
    let mut pictures = GpuPictures::new(gpu, &lit);
    for format in [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Rgba8UnormSrgb] {
        for view in [GpuView::Full, GpuView::Clusters] {
            let options = ViewOptions { view, shading: Shading::Diffuse };
            let target = pictures.draw_on_gpu(&lit, options);
            let image = target.read(&gpu.device, &gpu.queue).unwrap();
            let tone_map = ToneMap::new(Exposure::Automatic, &image);
            let presented = present(gpu, &target, format, view, tone_map);
            let expected = shown(&image, view);
            let farthest = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|c| a[c].abs_diff(b[c])).max();
            let pairs = presented.iter().zip(&expected.pixels);
            // Powers are a little different on GPUs.
            assert!(pairs.map(farthest).max().flatten() <= Some(1), "{format:?} {view:?}");
            let darker = ToneMap { scale: 0.9 * tone_map.scale };
            let other = present(gpu, &target, format, view, darker);
            assert_eq!(other != presented, view.is_light(), "exposure is for light alone");
        }
    }
}

#[test]
fn pictures_are_shown_beside_each_other_and_in_false_colors() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let lit = baked_cornell();
    let mut pictures = GpuPictures::new(gpu, &lit);
    let mut draw = |view| pictures.draw_on_gpu(&lit, ViewOptions { view, shading: Shading::Diffuse });
    let (full, direct) = (draw(GpuView::Full), draw(GpuView::Direct));
    let image = full.read(&gpu.device, &gpu.queue).unwrap();
    let plain = Shown::new(&full, GpuView::Full, ToneMap::new(Exposure::Automatic, &image));
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let show = |shown: Shown| present_shown(gpu, &shown, format);
    let (alone, other) = (show(plain), show(Shown { picture: &direct, ..plain }));
    let beside = Shown { other: Some(direct.view()), divider: 0.5, ..plain };
    let width = image.width as usize;
    for (index, pixel) in show(beside).iter().enumerate() {
        let expected = if index % width < width / 2 { other[index] } else { alone[index] };
        assert_eq!(*pixel, expected, "pixel {index}");
    }
    assert_eq!(show(Shown { divider: 0.0, fade: 1.0, ..beside }), other);
    // The same is black; where bounced light is missing the picture is brighter, never darker.
    let difference = Shown { divider: 0.0, coloring: Coloring::Difference, ..beside };
    assert!(show(Shown { other: None, ..difference }).iter().all(|pixel| *pixel == [0; 3]));
    let found = show(difference);
    assert!(found.iter().any(|[red, ..]| *red > 200) && found.iter().all(|[red, _, blue]| red >= blue));
    // A stop brighter is a stop further.
    let stops = |scale: f32| {
        let tone_map = ToneMap { scale: plain.tone_map.scale * scale };
        show(Shown { tone_map, coloring: Coloring::Stops, ..plain })
    };
    let [at, brighter] = [1.0, 2.0].map(stops);
    let gray =
        |pixel: &[u8; 3]| pixel[0] == pixel[1] && pixel[1] == pixel[2] && pixel[0] > 0 && pixel[0] < 255;
    assert!(
        at.iter().any(gray)
            && at.iter().zip(&brighter).all(|(a, b)| a != b || *a == [0; 3] || *a == [255; 3])
    );
    // Nothing is broken; with a long exposure much is too bright.
    assert_eq!(
        show(Shown { marks: true, ..plain })
            .iter()
            .filter(|p| [[255, 0, 255], [0, 255, 255]].contains(p))
            .count(),
        0
    );
    let long = ToneMap { scale: plain.tone_map.scale * 1e4 };
    assert!(show(Shown { marks: true, tone_map: long, ..plain }).contains(&[255, 0, 0]));
}

fn present(
    gpu: &GpuDevice,
    picture: &PictureTarget,
    format: wgpu::TextureFormat,
    view: GpuView,
    tone_map: ToneMap,
) -> Vec<[u8; 3]> {
    present_shown(gpu, &Shown::new(picture, view, tone_map), format)
}

fn present_shown(gpu: &GpuDevice, shown: &Shown, format: wgpu::TextureFormat) -> Vec<[u8; 3]> {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: shown.picture.texture().size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let presenter = Presenter::new(&gpu.device, &gpu.queue, format);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
    presenter.present(&mut encoder, shown, &target);
    gpu.queue.submit([encoder.finish()]);
    let bytes = read_texture(&gpu.device, &gpu.queue, &texture).unwrap();
    bytes.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2]]).collect()
}
