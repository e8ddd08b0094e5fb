//! Draws the picture, and another one beside it, as the view has them, into a texture for the window.

use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use half::f16;
use probelight_math::glam::Vec3;
use probelight_render::gpu::{Coloring, GpuView, PictureTarget, Presenter, Shown, ViewOptions};
use probelight_render::{DisplayImage, ToneMap};
use probelight_runtime::gpu::readback::read_texture_async;
use probelight_runtime::gpu::{GpuDevice, GpuError};

use crate::scene::live_scene::LiveScene;
use crate::scene::reference_picture::ReferencePicture;
use crate::state::view_state::{Compare, ViewState};

/// Format of the window's textures: bytes as the screen has them.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Pictures of one size.
pub struct Screen {
    gpu: GpuDevice,
    presenter: Presenter,
    own: PictureTarget,
    other: PictureTarget,
    reference: Option<UploadedReference>,
    shown: wgpu::Texture,
    texture: Option<TextureId>,
}

struct UploadedReference {
    passes: u32,
    view: wgpu::TextureView,
}

impl Screen {
    /// Black, of the smallest size.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn new(gpu: &GpuDevice) -> Result<Self, GpuError> {
        Ok(Self {
            presenter: Presenter::new(&gpu.device, &gpu.queue, FORMAT),
            own: PictureTarget::new(&gpu.device, 1, 1)?,
            other: PictureTarget::new(&gpu.device, 1, 1)?,
            reference: None,
            shown: new_shown(gpu, 1, 1),
            texture: None,
            gpu: gpu.clone(),
        })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.shown.width(), self.shown.height())
    }

    /// Follows the window's size, pixels. Returns whether it changed.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`]; the size stays.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<bool, GpuError> {
        let largest = self.gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = (width.clamp(1, largest), height.clamp(1, largest));
        if (width, height) == self.size() {
            return Ok(false);
        }
        self.own = PictureTarget::new(&self.gpu.device, width, height)?;
        self.other = PictureTarget::new(&self.gpu.device, 1, 1)?;
        self.shown = new_shown(&self.gpu, width, height);
        Ok(true)
    }

    /// The window's name for the picture.
    pub fn texture(&mut self, window: &RenderState, was_resized: bool) -> TextureId {
        let view = self.shown.create_view(&wgpu::TextureViewDescriptor::default());
        let filter = wgpu::FilterMode::Linear;
        match self.texture {
            Some(texture) if !was_resized => texture,
            Some(texture) => {
                let mut renderer = window.renderer.write();
                renderer.update_egui_texture_from_wgpu_texture(&window.device, &view, filter, texture);
                texture
            }
            None => {
                let texture = window.renderer.write().register_native_texture(&window.device, &view, filter);
                *self.texture.insert(texture)
            }
        }
    }

    /// Draws what the view shows at an exposure; so much of it is still without indirect light.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn draw(
        &mut self,
        live: &mut LiveScene,
        view: &ViewState,
        ev: f32,
        fade: f32,
        reference: Option<&ReferencePicture>,
    ) -> Result<(), GpuError> {
        live.draw(&self.own, &view.camera, view.options);
        let needs_direct = view.compare == Compare::WithoutIndirect || fade > 0.0;
        if needs_direct {
            let (width, height) = self.size();
            if (self.other.texture().width(), self.other.texture().height()) != (width, height) {
                self.other = PictureTarget::new(&self.gpu.device, width, height)?;
            }
            live.draw(&self.other, &view.camera, ViewOptions { view: GpuView::Direct, ..view.options });
        }
        if view.compare == Compare::Reference {
            self.upload(reference);
        }
        let other = match view.compare {
            Compare::Reference => self.reference.as_ref().map(|reference| &reference.view),
            _ if needs_direct => Some(self.other.view()),
            _ => None,
        };
        let is_divided = view.compare != Compare::Nothing && other.is_some();
        let coloring = match view.coloring {
            Coloring::Difference if !is_divided => Coloring::Natural,
            coloring => coloring,
        };
        let shown = Shown {
            other,
            divider: if is_divided && coloring != Coloring::Difference { view.divider } else { 0.0 },
            fade,
            coloring,
            marks: view.marks,
            ..Shown::new(&self.own, view.options.view, ToneMap::of_ev(ev))
        };
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = self.shown.create_view(&wgpu::TextureViewDescriptor::default());
        self.presenter.present(&mut encoder, &shown, &target);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The picture as it is shown. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read(&self) -> Result<DisplayImage, GpuError> {
        let GpuDevice { device, queue, .. } = &self.gpu;
        probelight_runtime::gpu::readback::read_texture(device, queue, &self.shown)
            .map(|bytes| displayed(self.size(), &bytes))
    }

    /// The picture as it is shown, once the GPU has drawn it.
    pub fn read_async(&self) -> impl Future<Output = Result<DisplayImage, GpuError>> + use<> {
        let (GpuDevice { device, queue, .. }, shown, size) =
            (self.gpu.clone(), self.shown.clone(), self.size());
        async move { Ok(displayed(size, &read_texture_async(&device, &queue, &shown).await?)) }
    }

    /// Uploads the reference if it has grown.
    fn upload(&mut self, reference: Option<&ReferencePicture>) {
        let Some(reference) = reference else { return self.reference = None };
        let passes = reference.passes();
        if self.reference.as_ref().is_some_and(|uploaded| uploaded.passes == passes) {
            return;
        }
        self.reference = reference
            .mean()
            .map(|(width, radiance)| UploadedReference { passes, view: upload(&self.gpu, width, &radiance) });
    }
}

/// A picture of texels.
fn displayed((width, height): (u32, u32), bytes: &[u8]) -> DisplayImage {
    let pixels = bytes.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2]]).collect();
    DisplayImage { width, height, pixels }
}

fn new_shown(gpu: &GpuDevice, width: u32, height: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("what the window shows"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn upload(gpu: &GpuDevice, width: u32, radiance: &[Vec3]) -> wgpu::TextureView {
    let height = (radiance.len() as u32 / width.max(1)).max(1);
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("reference"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let half = |radiance: &Vec3| radiance.min(Vec3::splat(65504.0)).extend(1.0).to_array().map(f16::from_f32);
    let texels: Vec<[f16; 4]> = radiance.iter().map(half).collect();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&texels), layout, texture.size());
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
