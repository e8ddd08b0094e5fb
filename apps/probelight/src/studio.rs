//! A baked scene that can be lit and looked at, on the GPU or on the CPU.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use clap::ValueEnum;
use probelight_asset::BakedScene;
use probelight_render::gpu::{GpuRenderer, GpuView, LitScene, Shading, ViewOptions};
use probelight_render::{Image, PixelFilter, RenderOptions, RenderOutput, View, render};
use probelight_runtime::Runtime;
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime, Stage};
use probelight_scene::{Camera, Setup};

use crate::backend::Backend;
use crate::console::Console;
use crate::input;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewFlag {
    /// All light
    #[default]
    Full,
    /// Emission, sky behind the scene, direct light of point, spot and directional lights
    Direct,
    /// What the lightmap adds: bounced light, sky light, light of emissive surfaces
    Indirect,
    /// The lightmap itself, without surface colours
    Irradiance,
    /// Base colours (GPU)
    Albedo,
    /// Normals, with the bumps of normal maps if shading is physical (GPU)
    Normals,
    /// The lightmap's texels as a chessboard (GPU)
    LightmapTexels,
    /// A colour for each cluster of receivers (GPU)
    Clusters,
    /// Probes as spheres in their own light (GPU)
    Probes,
    /// Points where light is evaluated, as bright as their surfels (GPU)
    LightSamples,
}

impl ViewFlag {
    /// What the CPU calls it, if it has it.
    fn on_cpu(self) -> Option<RenderOutput> {
        match self {
            Self::Full => Some(RenderOutput::Full),
            Self::Direct => Some(RenderOutput::Direct),
            Self::Indirect => Some(RenderOutput::Indirect),
            Self::Irradiance => Some(RenderOutput::Irradiance),
            _ => None,
        }
    }

    /// What the GPU calls it.
    pub(crate) fn on_gpu(self) -> GpuView {
        match self {
            Self::Full => GpuView::Full,
            Self::Direct => GpuView::Direct,
            Self::Indirect => GpuView::Indirect,
            Self::Irradiance => GpuView::Irradiance,
            Self::Albedo => GpuView::Albedo,
            Self::Normals => GpuView::Normals,
            Self::LightmapTexels => GpuView::LightmapTexels,
            Self::Clusters => GpuView::Clusters,
            Self::Probes => GpuView::Probes,
            Self::LightSamples => GpuView::LightSamples,
        }
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
    pub(crate) view: ViewFlag,
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
        self.view.on_cpu().filter(|_| self.shading == ShadingFlag::Diffuse).context(
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
    runtime: GpuRuntime,
    renderer: GpuRenderer,
}

impl Studio {
    /// Prepares a baked scene.
    pub(crate) fn new(backend: Backend, baked: Arc<BakedScene>) -> anyhow::Result<Self> {
        match backend {
            Backend::Cpu => Ok(Self::Cpu(Box::new(Runtime::new(baked)))),
            Backend::Gpu(gpu) => {
                let GpuDevice { device, queue, .. } = &*gpu;
                let runtime = GpuRuntime::new(device, queue, Arc::clone(&baked), GpuOptions::default())?;
                let (geometry, shadow_maps) = (runtime.geometry(), runtime.shadow_maps());
                let renderer = GpuRenderer::new(device, queue, baked, geometry, shadow_maps)?;
                Ok(Self::Gpu(Box::new(GpuStudio { gpu: *gpu, runtime, renderer })))
            }
        }
    }

    /// Lets the setup's light bounce until nothing changes any more; returns the number of bounces.
    pub(crate) fn light(&mut self, setup: &Setup, console: &Console) -> anyhow::Result<usize> {
        match self {
            Self::Cpu(runtime) => Ok(input::light(runtime, setup, console)),
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
        let times = match self {
            Self::Cpu(runtime) => {
                let times = runtime.step();
                vec![
                    times.light_surfels,
                    times.relight_probes,
                    times.project_clusters,
                    times.gather_receivers,
                    times.dilate_lightmap,
                ]
            }
            Self::Gpu(studio) => {
                let frames = studio.runtime.measure_frames(1, |_, _| Ok(()))?;
                frames.first().map_or(Vec::new(), |frame| frame.stages.to_vec())
            }
        };
        Ok(Stage::ALL.iter().map(|stage| stage.name()).zip(times).collect())
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
        let view = ViewOptions { view: options.view.on_gpu(), shading };
        let image = self.renderer.still(&LitScene::of(&self.runtime), camera, view, options.samples);
        self.gpu.check()?;
        Ok(image?)
    }
}
