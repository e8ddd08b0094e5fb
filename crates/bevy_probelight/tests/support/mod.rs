//! Bevy without a window, drawing into an image that is read back.

#![allow(dead_code, reason = "each test uses a part of it")]

pub(crate) mod truth;

use std::path::Path;
use std::sync::Arc;

use bevy::asset::{AssetPlugin, RenderAssetUsages};
use bevy::camera::Hdr;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::image::TextureFormatPixelInfo;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::settings::WgpuSettings;
use bevy::render::texture::GpuImage;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_probelight::probelight_asset::BakedScene;
use bevy_probelight::probelight_runtime::gpu::{GpuDevice, readback};
use bevy_probelight::{Probelight, ProbelightPlugin, ProbelightScene, RenderScenes};
use half::f16;

/// Width and height of pictures.
pub(crate) const SIZE: u32 = 96;

/// Draws what a camera sees into an image, linear light as it is.
pub(crate) fn aim_at_image(app: &mut App, camera: Entity, size: u32, format: TextureFormat) -> Handle<Image> {
    let size = Extent3d { width: size, height: size, depth_or_array_layers: 1 };
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::all());
    image.data = Some(vec![0; format.pixel_size().unwrap() * (size.width * size.height) as usize]);
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT;
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.world_mut().entity_mut(camera).insert(RenderTarget::from(image.clone()));
    image
}

/// Whether there is a GPU. Without one the test is skipped and says so, unless the environment says `CI=true`: there a missing
/// GPU is a failure.
pub(crate) fn has_gpu() -> bool {
    match GpuDevice::open(std::env::var("PROBELIGHT_ADAPTER").ok().as_deref()) {
        Ok(_) => true,
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => panic!("{error}"),
        Err(error) => {
            use std::io::Write;
            let _ = writeln!(std::io::stderr(), "SKIPPED: {error}");
            false
        }
    }
}

/// The Cornell box of the examples, with a grid in free space.
pub(crate) fn cornell() -> BakedScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cornell.plight");
    BakedScene::read(&path).unwrap()
}

/// [`headless_app_in`] with the assets of the examples.
pub(crate) fn headless_app() -> App {
    headless_app_in(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"))
}

/// An app without window that does one step per [`App::update`], each of them drawn to its end; assets come from a folder.
pub(crate) fn headless_app_in(assets: &str) -> App {
    headless_app_with(assets, WgpuSettings::default())
}

/// The same on a device with other limits.
pub(crate) fn headless_app_with(assets: &str, gpu: WgpuSettings) -> App {
    headless_app_of(assets, gpu, |app| {
        app.add_plugins(ProbelightPlugin);
    })
}

/// The same with other plugins than ours.
pub(crate) fn headless_app_of(assets: &str, gpu: WgpuSettings, add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(AssetPlugin { file_path: assets.into(), ..default() })
            .set(RenderPlugin {
                render_creation: gpu.into(),
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .disable::<LogPlugin>()
            .disable::<PipelinedRenderingPlugin>()
            .disable::<WinitPlugin>(),
        RenderDiagnosticsPlugin,
    ));
    add(&mut app);
    while app.plugins_state() == bevy::app::PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app
}

/// Meshes and materials of a scene.
pub(crate) fn new_scene(app: &mut App, baked: BakedScene) -> ProbelightScene {
    app.world_mut().resource_scope(|world, mut meshes: Mut<Assets<Mesh>>| {
        world.resource_scope(|world, mut materials: Mut<Assets<StandardMaterial>>| {
            let mut images = world.resource_mut::<Assets<Image>>();
            ProbelightScene::new(Arc::new(baked), &mut meshes, &mut materials, &mut images)
        })
    })
}

/// Makes a scene an asset and shows it.
pub(crate) fn spawn_scene(app: &mut App, baked: BakedScene, transform: Transform) -> Entity {
    let scene = new_scene(app, baked);
    let scene = app.world_mut().resource_mut::<Assets<ProbelightScene>>().add(scene);
    app.world_mut().spawn((Probelight(scene), transform)).id()
}

/// Takes all gloss from a scene's materials, so that a picture shows nothing but diffuse light.
pub(crate) fn make_diffuse(app: &mut App, scene: Entity) {
    let handle = app.world().get::<Probelight>(scene).unwrap().0.clone();
    let materials = app.world().resource::<Assets<ProbelightScene>>().get(&handle).unwrap().materials.clone();
    let mut assets = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    for material in materials {
        let mut material = assets.get_mut(&material).unwrap();
        material.reflectance = 0.0;
        material.perceptual_roughness = 1.0;
    }
}

/// A camera that draws linear light into an image; returns the image.
pub(crate) fn spawn_camera(app: &mut App, transform: Transform) -> Handle<Image> {
    let camera = (
        Camera3d::default(),
        Camera { clear_color: ClearColorConfig::Custom(Color::BLACK), ..default() },
        Hdr,
        Msaa::Off,
        Tonemapping::None,
        transform,
    );
    let camera = app.world_mut().spawn(camera).id();
    aim_at_image(app, camera, SIZE, TextureFormat::Rgba16Float)
}

/// Bytes of an image in the render world, row by row from the top.
pub(crate) fn read_bytes(app: &App, image: &Handle<Image>) -> Vec<u8> {
    let world = app.sub_app(RenderApp).world();
    let texture =
        &world.resource::<RenderAssets<GpuImage>>().get(image).expect("the image was drawn").texture;
    let device = world.resource::<RenderDevice>().wgpu_device();
    let queue = world.resource::<RenderQueue>();
    readback::read_texture(device, queue, texture).unwrap()
}

/// Linear red, green and blue of an image of half floats.
pub(crate) fn read_image(app: &App, image: &Handle<Image>) -> Vec<Vec3> {
    let half = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32();
    let bytes = read_bytes(app, image);
    bytes.chunks(8).map(|texel| Vec3::new(half(texel), half(&texel[2..]), half(&texel[4..]))).collect()
}

/// Frames of light that were computed for a scene.
pub(crate) fn frames_of(app: &App, scene: Entity) -> Option<u64> {
    app.sub_app(RenderApp).world().resource::<RenderScenes>().frames(scene)
}

/// Updates until light stands still. Nothing is drawn meanwhile, which takes software the most time.
pub(crate) fn settle(app: &mut App, scene: Entity) {
    open_eyes(app, false);
    let mut before = None;
    for _ in 0..400 {
        app.update();
        let now = frames_of(app, scene);
        if now.is_some() && now == before {
            open_eyes(app, true);
            return;
        }
        before = now;
    }
    panic!("light never stands still");
}

/// Switches all cameras on or off.
fn open_eyes(app: &mut App, is_active: bool) {
    let mut cameras = app.world_mut().query::<&mut Camera>();
    for mut camera in cameras.iter_mut(app.world_mut()) {
        camera.is_active = is_active;
    }
}
