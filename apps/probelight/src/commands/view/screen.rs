//! A window's surface, and the picture on its way there.

use std::sync::Arc;

use anyhow::Context;
use probelight_render::gpu::{PictureTarget, Presenter};
use probelight_runtime::gpu::GpuDevice;
use winit::dpi::PhysicalSize;
use winit::window::Window;

/// What a window shows.
pub(super) struct Screen {
    pub(super) window: Arc<Window>,
    pub(super) picture: PictureTarget,
    pub(super) presenter: Presenter,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
}

impl Screen {
    pub(super) fn new(gpu: &GpuDevice, window: Arc<Window>) -> anyhow::Result<Self> {
        let surface = gpu.instance.create_surface(Arc::clone(&window))?;
        let size = limited(gpu, window.inner_size());
        let configuration =
            surface.get_default_config(&gpu.adapter, size.width, size.height).with_context(|| {
                format!(
                    "the GPU {:?} cannot draw in windows: choose another by --adapter, or use \
                     `probelight render`",
                    gpu.info.name
                )
            })?;
        surface.configure(&gpu.device, &configuration);
        Ok(Self {
            picture: PictureTarget::new(&gpu.device, size.width, size.height)?,
            presenter: Presenter::new(&gpu.device, &gpu.queue, configuration.format),
            window,
            surface,
            configuration,
        })
    }

    /// Width and height of the picture, pixels.
    pub(super) fn size(&self) -> (u32, u32) {
        (self.configuration.width, self.configuration.height)
    }

    /// Follows the window's size.
    pub(super) fn resize(&mut self, gpu: &GpuDevice, size: PhysicalSize<u32>) -> anyhow::Result<()> {
        let PhysicalSize { width, height } = limited(gpu, size);
        if (width, height) != self.size() {
            (self.configuration.width, self.configuration.height) = (width, height);
            self.picture = PictureTarget::new(&gpu.device, width, height)?;
            self.surface.configure(&gpu.device, &self.configuration);
        }
        Ok(())
    }

    /// What the next frame is shown on; `None` if there is nothing to see it now, as on a hidden window.
    pub(super) fn next_texture(&mut self, gpu: &GpuDevice) -> anyhow::Result<Option<wgpu::SurfaceTexture>> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => return Ok(Some(texture)),
            Current::Outdated => {}
            Current::Lost => self.surface = gpu.instance.create_surface(Arc::clone(&self.window))?,
            Current::Timeout | Current::Occluded | Current::Validation => return Ok(None),
        }
        self.surface.configure(&gpu.device, &self.configuration);
        Ok(None)
    }
}

/// A size that the GPU can draw: at least a pixel, which a minimised window may not have.
fn limited(gpu: &GpuDevice, size: PhysicalSize<u32>) -> PhysicalSize<u32> {
    let largest = gpu.device.limits().max_texture_dimension_2d;
    PhysicalSize::new(size.width.clamp(1, largest), size.height.clamp(1, largest))
}
