//! A baked scene on a GPU, lit and drawn frame by frame as the document has it.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_render::gpu::{GpuRenderer, LitScene, PictureTarget, ViewOptions};
use probelight_runtime::gpu::{
    FrameTimestamps, GpuDevice, GpuError, GpuOptions, GpuRuntime, ShadowMapOptions,
};
use probelight_runtime::{FrameInput, ObjectId};
use probelight_scene::{AnimatedModel, Camera, Light, Lighting, Object, Scene, Sky};
use probelight_trace::Tracer;

use crate::state::document::{Document, Item, ObjectEntry};
use crate::state::view_state::{Muted, ViewState};

/// Models of objects, by their files.
pub type Models = HashMap<PathBuf, Arc<AnimatedModel>>;

/// A scene on a GPU.
pub struct LiveScene {
    /// Its device.
    pub gpu: GpuDevice,
    /// What was baked, or a scene that was [not](BakedScene::unbaked).
    pub baked: Arc<BakedScene>,
    /// Whether it was baked.
    pub is_baked: bool,
    /// Computes its light.
    pub runtime: GpuRuntime,
    /// Draws it.
    pub renderer: GpuRenderer,
    /// Finds what the mouse points at.
    pub tracer: Arc<Tracer>,
    /// Models that were read.
    pub models: Models,
    objects: HashMap<Item, Placed>,
}

/// Half the largest angle of the lamp at the camera, radians; nothing shines backwards.
const WIDEST_HEADLIGHT: f32 = 1.5;

/// An object of the document in the runtime.
#[derive(Debug)]
struct Placed {
    id: ObjectId,
    file: PathBuf,
    is_door: bool,
}

impl LiveScene {
    /// Uploads a baked scene.
    ///
    /// # Errors
    /// If the GPU cannot hold it.
    pub async fn new(gpu: &GpuDevice, baked: Arc<BakedScene>, is_baked: bool) -> Result<Self, GpuError> {
        // A driver in software takes a tenth of a second for each large map.
        let resolution = if gpu.is_software() { 1024 } else { 2048 };
        let shadow_maps = ShadowMapOptions { for_eye: true, resolution, ..ShadowMapOptions::default() };
        let options = GpuOptions { shadow_maps, ..GpuOptions::default() };
        let runtime = GpuRuntime::new_async(&gpu.device, &gpu.queue, Arc::clone(&baked), options).await?;
        let renderer = GpuRenderer::new(
            &gpu.device,
            &gpu.queue,
            Arc::clone(&baked),
            runtime.geometry(),
            runtime.shadow_maps(),
            runtime.grid(),
        )?;
        let tracer = Arc::new(Tracer::new(Arc::clone(&baked.scene)));
        let (models, objects) = (Models::new(), HashMap::new());
        Ok(Self { gpu: gpu.clone(), baked, is_baked, runtime, renderer, tracer, models, objects })
    }

    /// The scene's geometry.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.baked.scene
    }

    /// Whether a lamp at the camera lights the scene: one that was not baked and has no lights would be black.
    pub fn has_headlight(&self, document: &Document) -> bool {
        !self.is_baked && document.lights.is_empty()
    }

    /// Gives the runtime the light, colours and objects of the document as the view has them.
    ///
    /// # Errors
    /// What the runtime refuses, such as more lights than it has shadow maps for; the rest is as wanted.
    pub fn sync(&mut self, document: &Document, view: &ViewState) -> Result<(), GpuError> {
        let ViewState { time, muted, camera, .. } = view;
        let mut lighting = audible(document, muted, *time);
        if self.has_headlight(document) {
            lighting.lights.push(headlight(camera, self.scene().bounds().diagonal()));
        }
        let lighting = self.runtime.set_lighting(lighting);
        self.runtime.set_bounces(!muted.bounces);
        for (material, colors) in document.materials.iter().enumerate() {
            let Some(present) = self.runtime.surface_colors(material) else { break };
            if present.base_color != colors.base_color {
                self.runtime.set_base_color(material, colors.base_color)?;
            }
            if present.emission != colors.emission {
                self.runtime.set_emission(material, colors.emission)?;
            }
        }
        self.sync_objects(document, *time)?;
        lighting
    }

    fn sync_objects(&mut self, document: &Document, time: f32) -> Result<(), GpuError> {
        let Self { runtime, objects, models, .. } = self;
        let is_wanted = |item: &Item, placed: &Placed| {
            let is_same =
                |entry: &ObjectEntry| entry.path.file == placed.file && entry.path.is_door == placed.is_door;
            document.object(*item).is_some_and(is_same)
        };
        let gone: Vec<Item> =
            objects.iter().filter(|(item, placed)| !is_wanted(item, placed)).map(|(item, _)| *item).collect();
        for placed in gone.iter().filter_map(|item| objects.remove(item)) {
            runtime.objects_mut().remove(placed.id)?;
        }
        for entry in &document.objects {
            let Some(model) = models.get(&entry.path.file) else { continue };
            let clip = entry.path.clip.as_deref().and_then(|name| model.clip(name));
            let placement = entry.placement(time);
            match objects.get(&entry.item) {
                None => {
                    let shape = shape(model, clip, time);
                    let Ok(object) = entry.path.object(shape, placement) else { continue };
                    let id = runtime.objects_mut().insert(object);
                    let (file, is_door) = (entry.path.file.clone(), entry.path.is_door);
                    objects.insert(entry.item, Placed { id, file, is_door });
                }
                Some(placed) => {
                    if clip.is_some() {
                        runtime.objects_mut().reshape(placed.id, shape(model, clip, time))?;
                    }
                    runtime.objects_mut().place(placed.id, placement)?;
                }
            }
        }
        Ok(())
    }

    /// The objects in their places, for rays.
    pub fn placed_objects(&self) -> impl Iterator<Item = (Item, &Object)> {
        let objects = self.runtime.objects();
        self.objects.iter().filter_map(|(item, placed)| Some((*item, objects.get(placed.id)?)))
    }

    /// Computes one frame's light, and measures it if there are queries for that. Light in free space is computed where
    /// objects are, everywhere if that is wanted or shown.
    pub fn light(
        &mut self,
        camera: &Camera,
        options: ViewOptions,
        whole_grid: bool,
        queries: Option<&FrameTimestamps>,
    ) {
        let whole_grid = whole_grid || self.renderer.shows_whole_grid(options);
        let input = FrameInput { view: Some(camera.into()), whole_grid, ..FrameInput::default() };
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        match queries {
            Some(queries) => self.runtime.encode_timed(&input, &mut encoder, queries),
            None => self.runtime.encode(&input, &mut encoder),
        }
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Draws the shadows of suns as fine as they are seen by a camera.
    pub fn fit_shadows(&mut self, camera: &Camera) {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.runtime.fit_shadows(camera, &mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Draws what the camera sees. A submission of its own, as only one picture can be in each.
    pub fn draw(&mut self, target: &PictureTarget, camera: &Camera, options: ViewOptions) {
        let Self { gpu, runtime, renderer, .. } = self;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.draw(&mut encoder, target, &LitScene::of(runtime), camera, options);
        gpu.queue.submit([encoder.finish()]);
    }
}

/// The light of a document without what is muted.
pub fn audible(document: &Document, muted: &Muted, time: f32) -> Lighting {
    let mut lighting = document.lighting(time);
    for (light, entry) in lighting.lights.iter_mut().zip(&document.lights) {
        if muted.lights.contains(&entry.item) {
            *light.strength_mut() = Vec3::ZERO;
        }
    }
    if muted.sky {
        lighting.sky = Sky::default();
    }
    if muted.emission {
        lighting.emissive_scale = 0.0;
    }
    lighting
}

/// A model at a time of a clip.
fn shape(model: &AnimatedModel, clip: Option<usize>, time: f32) -> Arc<Scene> {
    match clip {
        Some(_) => Arc::new(model.pose(clip, time)),
        None => Arc::clone(model.rest()),
    }
}

/// A lamp at the camera that lights what it sees: by one shadow map where a lamp that shines all around has six, which are drawn
/// anew whenever the camera moves. About as bright as the sky that such a scene gets, seen from as far as the whole of it is.
fn headlight(camera: &Camera, diagonal: f32) -> Light {
    let intensity = Vec3::splat(8.0 * diagonal.powi(2));
    let aspect = camera.width as f32 / camera.height.max(1) as f32;
    let to_corner = ((0.5 * camera.vertical_fov).tan() * aspect.hypot(1.0)).atan();
    Light::Spot {
        position: camera.position,
        direction: (camera.target - camera.position).normalize_or(-Vec3::Z),
        intensity,
        inner_angle: to_corner.min(WIDEST_HEADLIGHT),
        outer_angle: (1.05 * to_corner).min(WIDEST_HEADLIGHT + 0.01),
        range: None,
    }
}
