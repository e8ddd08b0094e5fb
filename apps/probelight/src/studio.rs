//! A baked scene that can be lit and looked at, on the GPU or on the CPU.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use probelight_asset::BakedScene;
use probelight_render::gpu::{GpuRenderer, GpuView, LitScene, Shading, ViewOptions};
use probelight_render::{Image, PixelFilter, RenderOptions, RenderOutput, View, render};
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime, ShadowMapOptions};
use probelight_runtime::{FrameInput, ObjectId, Objects, Runtime, Stage};
use probelight_scene::{Camera, Setup};

use crate::backend::Backend;
use crate::console::Console;
use crate::input;
use crate::movers::Movers;

/// Reads a view by its name.
pub(crate) fn view_parser() -> impl TypedValueParser<Value = GpuView> {
    let value = |view: GpuView| {
        let needs = if on_cpu(view).is_none() { " (GPU)" } else { "" };
        PossibleValue::new(view.name()).help(format!("{}{needs}", view.description().trim_end_matches('.')))
    };
    // The parser lets no other name pass.
    PossibleValuesParser::new(GpuView::ALL.map(value)).map(|name| GpuView::by_name(&name).unwrap_or_default())
}

/// What the CPU calls a view, if it has it.
fn on_cpu(view: GpuView) -> Option<RenderOutput> {
    match view {
        GpuView::Full => Some(RenderOutput::Full),
        GpuView::Direct => Some(RenderOutput::Direct),
        GpuView::Indirect => Some(RenderOutput::Indirect),
        GpuView::Irradiance => Some(RenderOutput::Irradiance),
        _ => None,
    }
}

/// How surfaces reflect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShadingFlag {
    /// Evenly, as the path tracer has it
    #[default]
    Diffuse,
    /// glTF's metallic-roughness model with normal maps (GPU)
    Physical,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PictureOptions {
    pub(crate) view: GpuView,
    pub(crate) shading: ShadingFlag,
    /// Samples per pixel.
    pub(crate) samples: u32,
    pub(crate) filter: PixelFilter,
}

impl PictureOptions {
    /// Whether only a GPU can make the picture.
    pub(crate) fn needs_gpu(&self) -> bool {
        self.on_cpu().is_err()
    }

    /// What the CPU calls it.
    fn on_cpu(&self) -> anyhow::Result<RenderOutput> {
        on_cpu(self.view).filter(|_| self.shading == ShadingFlag::Diffuse).context(
            "the CPU can show only diffuse surfaces, full, direct or indirect light, and irradiance: \
             use --backend gpu (a driver in software will do)",
        )
    }

    /// Whether the backend can make the picture; else what to do.
    pub(crate) fn check(&self, backend: &Backend) -> anyhow::Result<()> {
        match backend {
            Backend::Cpu => self.on_cpu().map(|_| ()),
            Backend::Gpu(_) => Ok(()),
        }
    }
}

/// A scene, its light, and what draws it.
pub(crate) enum Studio {
    Cpu(Box<Runtime>),
    Gpu(Box<GpuStudio>),
}

/// All on a GPU.
pub(crate) struct GpuStudio {
    gpu: GpuDevice,
    pub(crate) runtime: GpuRuntime,
    renderer: GpuRenderer,
}

impl Studio {
    /// Prepares a baked scene.
    pub(crate) fn new(backend: Backend, baked: Arc<BakedScene>) -> anyhow::Result<Self> {
        match backend {
            Backend::Cpu => Ok(Self::Cpu(Box::new(Runtime::new(baked)))),
            Backend::Gpu(gpu) => {
                let GpuDevice { device, queue, .. } = &*gpu;
                let shadow_maps = ShadowMapOptions { for_eye: true, ..ShadowMapOptions::default() };
                let options = GpuOptions { shadow_maps, ..GpuOptions::default() };
                let runtime = GpuRuntime::new(device, queue, Arc::clone(&baked), options)?;
                let (geometry, shadow_maps, grid) =
                    (runtime.geometry(), runtime.shadow_maps(), runtime.grid());
                let renderer = GpuRenderer::new(device, queue, baked, geometry, shadow_maps, grid)?;
                Ok(Self::Gpu(Box::new(GpuStudio { gpu: *gpu, runtime, renderer })))
            }
        }
    }

    /// Puts objects into the scene; returns their handles.
    pub(crate) fn enter(&mut self, movers: &Movers, console: &Console) -> anyhow::Result<Vec<ObjectId>> {
        movers.note_missing_grid(self.baked(), console);
        let ids = movers.enter(self.objects_mut())?;
        if let Self::Gpu(studio) = self {
            studio.runtime.upload_objects()?;
        }
        Ok(ids)
    }

    fn baked(&self) -> &BakedScene {
        match self {
            Self::Cpu(runtime) => runtime.baked(),
            Self::Gpu(studio) => studio.runtime.baked(),
        }
    }

    /// What moves through the scene.
    pub(crate) fn objects_mut(&mut self) -> &mut Objects {
        match self {
            Self::Cpu(runtime) => runtime.objects_mut(),
            Self::Gpu(studio) => studio.runtime.objects_mut(),
        }
    }

    /// Lets the setup's light bounce until nothing changes any more; returns the number of bounces.
    pub(crate) fn light(&mut self, setup: &Setup, console: &Console) -> anyhow::Result<usize> {
        match self {
            Self::Cpu(runtime) => input::light(runtime, setup, console),
            Self::Gpu(studio) => input::light_on_gpu(&mut studio.runtime, setup, console),
        }
    }

    /// What the camera sees.
    pub(crate) fn picture(
        &mut self,
        camera: &Camera,
        options: &PictureOptions,
        console: &Console,
    ) -> anyhow::Result<Image> {
        match self {
            Self::Cpu(runtime) => {
                let output = options.on_cpu()?;
                let PictureOptions { samples, filter, .. } = *options;
                let options = RenderOptions { output, samples, filter };
                Ok(render(View::of(runtime), camera, &options, console)?)
            }
            Self::Gpu(studio) => studio.picture(camera, options, console),
        }
    }

    /// Computes one frame; returns its stages and how long they took.
    pub(crate) fn frame(&mut self) -> anyhow::Result<Vec<(&'static str, Duration)>> {
        let (timings, is_on_cpu) = match self {
            Self::Cpu(runtime) => (runtime.step(&FrameInput::default()), true),
            Self::Gpu(studio) => {
                let frames = studio.runtime.measure_frames(1, |_, _| Ok(()))?;
                (frames.first().copied().unwrap_or_default(), false)
            }
        };
        let stages = Stage::ALL.into_iter().filter(|stage| stage.is_on_cpu() || !is_on_cpu);
        Ok(stages.map(|stage| (stage.name(), timings.stages[stage])).collect())
    }
}

impl GpuStudio {
    fn picture(
        &mut self,
        camera: &Camera,
        options: &PictureOptions,
        console: &Console,
    ) -> anyhow::Result<Image> {
        if options.filter != PixelFilter::Box {
            console.note("the GPU weighs samples evenly: --filter is left aside (--backend cpu has it)");
        }
        let shading = match options.shading {
            ShadingFlag::Diffuse => Shading::Diffuse,
            ShadingFlag::Physical => Shading::Physical,
        };
        let view = ViewOptions { view: options.view, shading };
        if self.renderer.shows_whole_grid(view) {
            self.runtime.step(&FrameInput { whole_grid: true, ..FrameInput::default() });
        }
        let GpuDevice { device, queue, .. } = &self.gpu;
        let mut encoder = device.create_command_encoder(&Default::default());
        self.runtime.fit_shadows(camera, &mut encoder);
        queue.submit([encoder.finish()]);
        let image = self.renderer.still(&LitScene::of(&self.runtime), camera, view, options.samples);
        self.gpu.check()?;
        Ok(image?)
    }
}
