//! The picture while it is drawn, and its pixels.

use probelight_runtime::gpu::GpuError;
use probelight_runtime::gpu::device::checked;

/// Format of linear pictures: what can be drawn with several samples per pixel everywhere.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Samples per pixel: what WebGPU guarantees.
pub(super) const SAMPLES: u32 = 4;

/// Images that a picture of a certain size is drawn with.
#[derive(Debug)]
pub struct PictureTarget {
    pub(super) samples: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    pub(super) resolved_view: wgpu::TextureView,
    resolved: wgpu::Texture,
}

impl PictureTarget {
    /// For pictures of `width × height` pixels.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], or [`GpuError::Refused`] for a picture without pixels or wider than the GPU can
    /// draw.
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Result<Self, GpuError> {
        let texture = |label, format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let readable = attachment | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        checked(device, "the picture", || {
            let resolved = texture("picture", PICTURE_FORMAT, 1, readable);
            Ok(Self {
                samples: view(&texture("samples of the picture", PICTURE_FORMAT, SAMPLES, attachment)),
                depth: view(&texture("depth of the picture", DEPTH_FORMAT, SAMPLES, attachment)),
                resolved_view: view(&resolved),
                resolved,
            })
        })
    }

    /// The finished picture for shaders and for [`Shown::other`](super::presenter::Shown::other).
    pub fn view(&self) -> &wgpu::TextureView {
        &self.resolved_view
    }

    /// The finished picture, linear, with [`PICTURE_FORMAT`].
    pub fn texture(&self) -> &wgpu::Texture {
        &self.resolved
    }

    /// Copies the finished picture from the GPU. Waits for it.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    #[cfg(feature = "blocking")]
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<crate::Image, GpuError> {
        use half::f16;
        use probelight_math::glam::Vec3;

        let bytes = probelight_runtime::gpu::readback::read_texture(device, queue, &self.resolved)?;
        let half = |texel: &[u8], channel: usize| {
            f16::from_le_bytes([texel[2 * channel], texel[2 * channel + 1]]).to_f32()
        };
        let pixel = |texel: &[u8]| Vec3::from([0, 1, 2].map(|channel| half(texel, channel)));
        let pixels = bytes.chunks_exact(8).map(pixel).collect();
        Ok(crate::Image { width: self.resolved.width(), height: self.resolved.height(), pixels })
    }
}
