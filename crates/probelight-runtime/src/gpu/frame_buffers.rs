//! What the stages of a frame hand to each other.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use wgpu::{TextureFormat, TextureUsages};

use super::device::GpuError;
use super::frame_extents::FrameExtents;
use super::frame_work::FrameWork;
use super::storage::Storage;

/// Format of the irradiance lightmap: filterable everywhere, and precise enough for light (eleven bits).
pub const LIGHTMAP_FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// Levels of the lightmap. A texel of the coarsest is eight of the finest wide; beyond, charts would blend.
const MOST_LEVELS: u32 = 4;

/// How the signals are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SignalShape {
    /// Number of scalar signals.
    pub(super) scalar_signals: u32,
    /// Coefficients per probe.
    pub(super) coefficients: u32,
    /// Relight rays per probe.
    pub(super) rays: u32,
    /// Number of probes.
    pub(super) probes: u32,
}

/// Signals, irradiance and lightmap: they stay on the GPU from frame to frame.
#[derive(Debug)]
pub struct FrameBuffers {
    /// Three `f32` for each signal, W·m⁻²·sr⁻¹: the scalar signals in the order of
    /// [`scalar_signals`](probelight_asset::BakedParts::scalar_signals), then all coefficients of each probe.
    pub signals: wgpu::Buffer,
    /// Three `f32` for each receiver, W/m²: in the order of
    /// [`receiver_texels`](probelight_asset::BakedParts::receiver_texels), then the grid's.
    pub irradiance: wgpu::Buffer,
    /// Irradiance per texel of the lightmap, W/m², with [`LIGHTMAP_FORMAT`]. Texel (x, y) of level 0 is that of the
    /// CPU's [`IrradianceLightmap`](crate::IrradianceLightmap). Alpha is 1 where there is light, else 0.
    pub lightmap: wgpu::Texture,
    /// All levels of it.
    pub lightmap_view: wgpu::TextureView,
    pub(super) shape: wgpu::Buffer,
    pub(super) extents: FrameExtents,
    pub(super) work: FrameWork,
}

impl FrameBuffers {
    /// Darkness.
    pub(super) fn new(storage: &Storage, baked: &BakedScene) -> Result<Self, GpuError> {
        let lightmap = new_lightmap(storage.device, baked.lightmap.width, baked.lightmap.height)?;
        let shape = SignalShape {
            scalar_signals: baked.scalar_signals() as u32,
            coefficients: baked.coefficients() as u32,
            rays: baked.relight_directions.len() as u32,
            probes: baked.probes.len() as u32,
        };
        let signals =
            u64::from(shape.scalar_signals) + baked.probes.len() as u64 * baked.coefficients() as u64;
        Ok(Self {
            signals: storage.zeros("signals", RGB_BYTES * signals)?,
            irradiance: storage.zeros("irradiance", RGB_BYTES * baked.receiver_count() as u64)?,
            lightmap_view: lightmap.create_view(&wgpu::TextureViewDescriptor::default()),
            lightmap,
            shape: storage.uniform("signal shape", &shape),
            extents: FrameExtents::new(storage, baked)?,
            work: FrameWork::new(storage, baked)?,
        })
    }
}

/// Bytes of three `f32`.
pub(super) const RGB_BYTES: u64 = 12;

fn new_lightmap(device: &wgpu::Device, width: u32, height: u32) -> Result<wgpu::Texture, GpuError> {
    let limit = device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        return Err(GpuError::LightmapTooLarge { width, height, limit });
    }
    let size = wgpu::Extent3d { width: width.max(1), height: height.max(1), depth_or_array_layers: 1 };
    Ok(device.create_texture(&wgpu::TextureDescriptor {
        label: Some("irradiance lightmap"),
        size,
        mip_level_count: size.max_mips(wgpu::TextureDimension::D2).min(MOST_LEVELS),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: LIGHTMAP_FORMAT,
        usage: TextureUsages::STORAGE_BINDING
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC
            | TextureUsages::COPY_DST,
        view_formats: &[],
    }))
}

/// One level of a texture.
pub(super) fn level_view(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        base_mip_level: level,
        mip_level_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}
