//! Light that the CPU's runtime computed, on the GPU: for GPUs that draw well but lack the memory for the
//! matrices, and to tell a difference in lighting from one in drawing.

use half::f16;
use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::Runtime;
use probelight_runtime::gpu::device::checked;
use probelight_runtime::gpu::filled_buffer::check_size;
use probelight_runtime::gpu::{
    GpuError, GridTables, MovingGeometry, SceneGeometry, ShadowMapOptions, ShadowMaps,
};

use super::gpu_renderer::LitScene;

const STORAGE_USAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_DST);

/// A scene on the GPU with the light of a CPU [`Runtime`].
#[derive(Debug)]
pub struct UploadedLight {
    geometry: SceneGeometry,
    shadow_maps: ShadowMaps,
    moving: MovingGeometry,
    grid: GridTables,
    lightmap: wgpu::Texture,
    signals: wgpu::Buffer,
    irradiance: wgpu::Buffer,
}

impl UploadedLight {
    /// Darkness.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: &BakedScene,
        options: ShadowMapOptions,
    ) -> Result<Self, GpuError> {
        let geometry = SceneGeometry::new(device, queue, &baked.scene)?;
        let shadow_maps = ShadowMaps::new(device, &geometry, options)?;
        checked(device, "the lightmap", || {
            let lightmap = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("irradiance lightmap"),
                size: wgpu::Extent3d {
                    width: baked.lightmap.width.max(1),
                    height: baked.lightmap.height.max(1),
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba16Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let irradiance = storage(device, "irradiance", baked.receiver_count())?;
            let signals = baked.scalar_signals() + baked.probes.len() * baked.coefficients();
            let signals = storage(device, "signals", signals)?;
            let moving = MovingGeometry::new(device);
            let grid = GridTables::new(device, queue, baked, &irradiance)?;
            Ok(Self { geometry, shadow_maps, moving, grid, lightmap, signals, irradiance })
        })
    }

    /// Takes the light of the runtime's last frame.
    ///
    /// # Errors
    /// [`GpuError::TooManyLights`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        runtime: &Runtime,
    ) -> Result<(), GpuError> {
        self.shadow_maps.set_lights(device, queue, &self.geometry, &runtime.lighting().lights)?;
        let lightmap = runtime.irradiance();
        let texels: Vec<[f16; 4]> = lightmap.texels.iter().map(half_texel).collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(lightmap.width * 8),
            rows_per_image: None,
        };
        if !texels.is_empty() {
            let bytes = bytemuck::cast_slice(&texels);
            queue.write_texture(self.lightmap.as_image_copy(), bytes, layout, self.lightmap.size());
        }
        let mut signals = runtime.signals().values().to_vec();
        signals.extend(probe_coefficients(runtime));
        queue.write_buffer(&self.signals, 0, bytemuck::cast_slice(&signals));
        queue.write_buffer(&self.irradiance, 0, bytemuck::cast_slice(runtime.receiver_irradiance()));
        self.grid.set_discs(queue, runtime.emissive_discs());
        self.grid.set_spheres(device, queue, runtime.objects().spheres())?;
        self.moving.update(device, queue, runtime.objects().as_slice())
    }

    /// Draws shadow maps.
    pub fn encode(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder) {
        let Self { geometry, moving, .. } = self;
        self.shadow_maps.encode_with_objects(device, queue, encoder, geometry, moving, true);
    }

    /// The triangles, from which a [`GpuRenderer`](super::GpuRenderer) is made.
    pub fn geometry(&self) -> &SceneGeometry {
        &self.geometry
    }

    /// The lights and their maps, from which a [`GpuRenderer`](super::GpuRenderer) is made.
    pub fn shadow_maps(&self) -> &ShadowMaps {
        &self.shadow_maps
    }

    /// The grid, from which a [`GpuRenderer`](super::GpuRenderer) is made.
    pub fn grid(&self) -> &GridTables {
        &self.grid
    }

    /// What a renderer draws.
    pub fn scene<'a>(&'a self, runtime: &'a Runtime) -> LitScene<'a> {
        LitScene {
            geometry: &self.geometry,
            shadow_maps: &self.shadow_maps,
            moving: &self.moving,
            grid: &self.grid,
            lightmap: self.lightmap.create_view(&wgpu::TextureViewDescriptor::default()),
            signals: &self.signals,
            lighting: runtime.lighting(),
            colors: (0..runtime.baked().scene.materials.len())
                .filter_map(|material| runtime.surface_colors(material))
                .collect(),
        }
    }
}

/// A storage buffer of colours.
fn storage(device: &wgpu::Device, content: &'static str, colors: usize) -> Result<wgpu::Buffer, GpuError> {
    let size = (colors.max(1) * size_of::<Vec3>()) as u64;
    check_size(&device.limits(), content, size, STORAGE_USAGE)?;
    Ok(device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(content),
        size,
        usage: STORAGE_USAGE,
        mapped_at_creation: false,
    }))
}

/// A texel without infinities.
fn half_texel(irradiance: &Vec3) -> [f16; 4] {
    let limited = irradiance.clamp(Vec3::splat(-65504.0), Vec3::splat(65504.0));
    limited.extend(1.0).to_array().map(f16::from_f32)
}

/// All coefficients of each probe.
fn probe_coefficients(runtime: &Runtime) -> impl Iterator<Item = Vec3> + '_ {
    let radiance = runtime.probe_radiance();
    (0..runtime.baked().probes.len()).flat_map(move |probe| {
        let [red, green, blue] = [0, 1, 2].map(|channel| radiance.coefficients(probe, channel));
        red.iter().zip(green).zip(blue).map(|((r, g), b)| Vec3::new(*r, *g, *b))
    })
}
