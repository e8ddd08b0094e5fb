//! Draws a lit scene, or what lights it: one forward pass with four samples per pixel.

use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::SurfaceColors;
use probelight_runtime::gpu::bindings::bind;
use probelight_runtime::gpu::device::checked;
use probelight_runtime::gpu::{GpuError, GpuRuntime, GridTables, MovingGeometry, SceneGeometry, ShadowMaps};
use probelight_scene::{Camera, Lighting};

use super::cluster_colors;
use super::finish::Finish;
use super::frame_record::FrameRecord;
use super::markers::Markers;
use super::materials::Materials;
use super::moving_surfaces::MovingSurfaces;
use super::picture_target::PictureTarget;
use super::pipelines::{Pipelines, SurfaceShader, frame_layout};
use super::surface_attributes;
use super::view::{GpuView, Shading, ViewOptions};

/// A scene under light, in the memory of a GPU.
#[derive(Debug)]
pub struct LitScene<'a> {
    /// The triangles.
    pub geometry: &'a SceneGeometry,
    /// The analytic lights and their shadow maps.
    pub shadow_maps: &'a ShadowMaps,
    /// What moves through the scene.
    pub moving: &'a MovingGeometry,
    /// Light in free space.
    pub grid: &'a GridTables,
    /// Irradiance per lightmap texel, W/m²; filterable.
    pub lightmap: wgpu::TextureView,
    /// Three `f32` for each signal, W·m⁻²·sr⁻¹: the scalar signals in the order of
    /// [`scalar_signals`](probelight_asset::BakedParts::scalar_signals), then all coefficients of each probe.
    pub signals: &'a wgpu::Buffer,
    /// Sky, and the strength of emissive surfaces.
    pub lighting: &'a Lighting,
    /// Present colours of all materials.
    pub colors: Vec<SurfaceColors>,
}

impl<'a> LitScene<'a> {
    /// What a GPU runtime's frames light.
    pub fn of(runtime: &'a GpuRuntime) -> Self {
        let buffers = runtime.buffers();
        let materials = 0..runtime.baked().scene.materials.len();
        Self {
            geometry: runtime.geometry(),
            shadow_maps: runtime.shadow_maps(),
            moving: runtime.moving(),
            grid: runtime.grid(),
            lightmap: buffers.lightmap.create_view(&wgpu::TextureViewDescriptor::default()),
            signals: &buffers.signals,
            lighting: runtime.lighting(),
            colors: materials.filter_map(|material| runtime.surface_colors(material)).collect(),
        }
    }
}

/// Draws pictures of one baked scene.
#[derive(Debug)]
pub struct GpuRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    baked: Arc<BakedScene>,
    attributes: wgpu::Buffer,
    lightmap_faces: wgpu::Buffer,
    materials: Materials,
    /// Of each material.
    finishes: Vec<Finish>,
    moving: MovingSurfaces,
    frame: wgpu::Buffer,
    frame_layout: wgpu::BindGroupLayout,
    lightmap_sampler: wgpu::Sampler,
    cluster_colors: wgpu::Texture,
    pipelines: Pipelines,
    probes: Markers,
    light_samples: Markers,
}

impl GpuRenderer {
    /// Uploads what surfaces look like.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: Arc<BakedScene>,
        geometry: &SceneGeometry,
        shadow_maps: &ShadowMaps,
        grid: &GridTables,
    ) -> Result<Self, GpuError> {
        checked(device, "the scene's surfaces", || {
            let cluster_colors = cluster_colors::texture(device, &baked);
            cluster_colors::write(queue, &cluster_colors, &baked, |cluster, _| {
                cluster_colors::color_of_number(cluster)
            });
            let materials = Materials::new(device, queue, &baked.scene);
            let frame_layout = frame_layout(device);
            let layouts =
                [shadow_maps.bind_group_layout(), &frame_layout, &materials.layout, grid.bind_group_layout()];
            Ok(Self {
                attributes: surface_attributes::vertex_buffer(device, &baked.scene, geometry)?,
                lightmap_faces: surface_attributes::lightmap_faces(device, &baked, geometry)?,
                pipelines: Pipelines::new(device, layouts),
                frame: device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("frame"),
                    size: size_of::<FrameRecord>() as u64,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                }),
                lightmap_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                    label: Some("lightmap"),
                    mag_filter: wgpu::FilterMode::Linear,
                    min_filter: wgpu::FilterMode::Linear,
                    ..wgpu::SamplerDescriptor::default()
                }),
                cluster_colors,
                probes: Markers::probes(device, &baked)?,
                light_samples: Markers::light_samples(device, &baked)?,
                materials,
                finishes: Finish::of_all(&baked.scene),
                moving: MovingSurfaces::default(),
                frame_layout,
                baked,
                device: device.clone(),
                queue: queue.clone(),
            })
        })
    }

    /// Gives each of the lightmap's receivers a colour in [`GpuView::Clusters`], linear, 0 to 1: `color(cluster, receiver)`,
    /// both counted from 0. At first each cluster has one of its own.
    pub fn set_texel_colors(&self, color: impl Fn(u32, u32) -> Vec3) {
        cluster_colors::write(&self.queue, &self.cluster_colors, &self.baked, color);
    }

    /// A colour for a number that is unlike those of its neighbours.
    pub fn color_of_number(number: u32) -> Vec3 {
        cluster_colors::color_of_number(number)
    }

    /// Whether pictures show light in free space on surfaces of the scene, so that frames must compute all of it
    /// ([`FrameInput::whole_grid`](probelight_runtime::FrameInput::whole_grid)): bumps and gloss of
    /// [`Shading::Physical`]. What a frame does not compute is shown as if its light came evenly from all sides.
    pub fn shows_whole_grid(&self, options: ViewOptions) -> bool {
        self.shows_finishes(options) && self.finishes.iter().any(|finish| *finish != Finish::Matt)
    }

    fn shows_finishes(&self, options: ViewOptions) -> bool {
        options.shading == Shading::Physical && options.view.has_soft_light() && self.baked.has_grid()
    }

    /// Draws what `camera` sees. One picture may be drawn per submission.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &PictureTarget,
        scene: &LitScene,
        camera: &Camera,
        options: ViewOptions,
    ) {
        let markers = match options.view {
            GpuView::Probes => Some((&self.probes, &self.pipelines.spheres)),
            GpuView::LightSamples => Some((&self.light_samples, &self.pipelines.discs)),
            _ => None,
        };
        let radius = markers.map_or(0.0, |(markers, _)| markers.radius);
        let diagonal = scene.geometry.bounds.diagonal();
        let record = FrameRecord::new(camera, diagonal, scene.lighting, options, radius);
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&record));
        self.materials.set_colors(&self.queue, &self.baked.scene, &scene.colors);
        self.moving.update(&self.device, &self.queue, scene.moving);

        let frame_group = self.frame_group(scene);
        let mut pass = begin_pass(encoder, target);
        pass.set_bind_group(1, &frame_group, &[]);
        if options.view.has_sky() {
            pass.set_pipeline(&self.pipelines.sky);
            pass.draw(0..3, 0..1);
        }
        self.draw_surfaces(&mut pass, scene, options);
        self.draw_objects(&mut pass, scene);
        if let Some((markers, pipeline)) = markers {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, &self.pipelines.marker_group(&self.device, markers, scene.signals), &[]);
            pass.draw(0..markers.vertices, 0..markers.count);
        }
    }

    /// A finished picture with at least `samples` samples per pixel (4, 16, 36, …), as far as the GPU can draw
    /// pictures so much larger. Waits for the GPU. Shadow maps and lightmap must be there already.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Refused`] or [`GpuError::Lost`].
    #[cfg(feature = "blocking")]
    pub fn still(
        &mut self,
        scene: &LitScene,
        camera: &Camera,
        options: ViewOptions,
        samples: u32,
    ) -> Result<crate::Image, GpuError> {
        let largest = self.device.limits().max_texture_dimension_2d / camera.width.max(camera.height).max(1);
        let wanted = (f64::from(samples) / f64::from(super::picture_target::SAMPLES)).sqrt().ceil() as u32;
        let scale = wanted.min(largest).max(1);
        let camera = Camera { width: scale * camera.width, height: scale * camera.height, ..camera.clone() };
        let target = PictureTarget::new(&self.device, camera.width, camera.height)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.draw(&mut encoder, &target, scene, &camera, options);
        self.queue.submit([encoder.finish()]);
        Ok(target.read(&self.device, &self.queue)?.reduced(scale))
    }

    fn draw_surfaces(&self, pass: &mut wgpu::RenderPass, scene: &LitScene, options: ViewOptions) {
        pass.set_bind_group(0, scene.shadow_maps.bind_group(), &[]);
        pass.set_bind_group(3, scene.grid.bind_group(), &[]);
        pass.set_vertex_buffer(0, scene.geometry.positions.slice(..));
        pass.set_vertex_buffer(1, self.attributes.slice(..));
        let has_objects = scene.moving.count > 0 && options.view.has_soft_light();
        let shows_finishes = self.shows_finishes(options);
        for part in &scene.geometry.parts {
            let material = part.material as usize;
            let shader = match self.finishes[material] {
                Finish::Bumpy if shows_finishes => SurfaceShader::Bumpy,
                Finish::Glossy if shows_finishes => SurfaceShader::Glossy,
                _ if has_objects => SurfaceShader::WithObjects,
                _ => SurfaceShader::Plain,
            };
            let pipelines = self.pipelines.surface(&self.device, shader);
            pass.set_pipeline(pipelines.of(&self.baked.scene.materials[material]));
            pass.set_bind_group(2, &self.materials.bind_groups[material], &[]);
            pass.draw(part.vertices.clone(), 0..1);
        }
    }

    fn draw_objects(&self, pass: &mut wgpu::RenderPass, scene: &LitScene) {
        for model in &scene.moving.models {
            let Some(surfaces) = self.moving.of(&model.model) else { continue };
            pass.set_vertex_buffer(0, model.geometry.positions.slice(..));
            pass.set_vertex_buffer(1, surfaces.attributes.slice(..));
            let pipelines = self.pipelines.surface(&self.device, SurfaceShader::Object);
            for part in &model.geometry.parts {
                let material = part.material as usize;
                pass.set_pipeline(pipelines.of(&model.model.materials[material]));
                pass.set_bind_group(2, &surfaces.materials.bind_groups[material], &[]);
                pass.draw(part.vertices.clone(), model.objects.clone());
            }
        }
    }

    fn frame_group(&self, scene: &LitScene) -> wgpu::BindGroup {
        let cluster_colors = self.cluster_colors.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            self.frame.as_entire_binding(),
            wgpu::BindingResource::TextureView(&scene.lightmap),
            wgpu::BindingResource::Sampler(&self.lightmap_sampler),
            wgpu::BindingResource::TextureView(&cluster_colors),
            self.lightmap_faces.as_entire_binding(),
            scene.geometry.positions.as_entire_binding(),
            scene.moving.placements.as_entire_binding(),
        ];
        bind(&self.device, "frame", &self.frame_layout, resources)
    }
}

fn begin_pass<'a>(encoder: &'a mut wgpu::CommandEncoder, target: &PictureTarget) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("picture"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target.samples,
            depth_slice: None,
            resolve_target: Some(&target.resolved_view),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Discard,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &target.depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}
