//! The pipelines of a picture and what shaders bind.

use std::sync::OnceLock;

use probelight_runtime::gpu::SceneGeometry;
use probelight_runtime::gpu::bindings::{SAMPLER, STORAGE, TEXTURE, UNIFORM, bind, layout};
use probelight_scene::{AlphaMode, Material};

use super::markers::Markers;
use super::picture_target::{DEPTH_FORMAT, PICTURE_FORMAT, SAMPLES};
use super::{shaders, surface_attributes};

/// How each kind of thing is drawn.
#[derive(Debug)]
pub(super) struct Pipelines {
    surfaces: [OnceLock<SurfacePipelines>; SurfaceShader::COUNT],
    surface_module: wgpu::ShaderModule,
    object_module: wgpu::ShaderModule,
    /// Lights, frame, material, grid.
    layouts: [wgpu::BindGroupLayout; 4],
    pub(super) sky: wgpu::RenderPipeline,
    pub(super) spheres: wgpu::RenderPipeline,
    pub(super) discs: wgpu::RenderPipeline,
    marker_layout: wgpu::BindGroupLayout,
}

/// How the light on a surface is found.
#[derive(Clone, Copy, Debug)]
pub(super) enum SurfaceShader {
    /// In the lightmap.
    Plain,
    /// In the lightmap, with objects around.
    WithObjects,
    /// In lightmap and grid, by a normal map's bumps, with objects around.
    Bumpy,
    /// The same, with gloss.
    Glossy,
    /// In the grid: of objects.
    Object,
}

impl SurfaceShader {
    const COUNT: usize = Self::Object as usize + 1;

    /// Names of the vertex and the fragment shaders, for opaque and for alpha-masked materials.
    fn entries(self) -> [&'static str; 3] {
        match self {
            Self::Plain => ["surface_vertex", "surface_color", "masked_surface_color"],
            Self::WithObjects => {
                ["surface_vertex", "surface_color_with_objects", "masked_surface_color_with_objects"]
            }
            Self::Bumpy => ["surface_vertex", "bumpy_surface_color", "masked_bumpy_surface_color"],
            Self::Glossy => ["surface_vertex", "glossy_surface_color", "masked_glossy_surface_color"],
            Self::Object => ["object_vertex", "object_color", "masked_object_color"],
        }
    }
}

/// For opaque and for alpha-masked materials.
#[derive(Debug)]
pub(super) struct SurfacePipelines {
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

impl SurfacePipelines {
    /// That for a material.
    pub(super) fn of(&self, material: &Material) -> &wgpu::RenderPipeline {
        if matches!(material.alpha_mode, AlphaMode::Mask { .. }) { &self.masked } else { &self.opaque }
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: [&wgpu::BindGroupLayout; 4]) -> Self {
        let marker_layout = marker_layout(device);
        let sky = shaders::module(device, "sky", shaders::sky());
        let markers = shaders::module(device, "markers", shaders::markers());
        let drawn = |module, entries, layouts: &[_]| Drawn {
            module,
            entries,
            layouts: layouts.to_vec(),
            attributes: &[],
            has_depth: true,
            is_masked: false,
        };
        let [_, frame, ..] = layouts;
        let marker_layouts = [None, Some(frame), Some(&marker_layout)];
        Self {
            surfaces: Default::default(),
            surface_module: shaders::module(device, "surface", shaders::surface()),
            object_module: shaders::module(device, "objects", shaders::objects()),
            layouts: layouts.map(wgpu::BindGroupLayout::clone),
            sky: Drawn { has_depth: false, ..drawn(&sky, ["sky_vertex", "sky_color"], &[None, Some(frame)]) }
                .pipeline(device),
            spheres: drawn(&markers, ["sphere_vertex", "sphere_color"], &marker_layouts).pipeline(device),
            discs: drawn(&markers, ["disc_vertex", "disc_color"], &marker_layouts).pipeline(device),
            marker_layout,
        }
    }

    /// What draws surfaces by a shader; made when it is first asked for, as compilers take long over some.
    pub(super) fn surface(&self, device: &wgpu::Device, shader: SurfaceShader) -> &SurfacePipelines {
        self.surfaces[shader as usize].get_or_init(|| {
            let [vertex, opaque, masked] = shader.entries();
            let is_object = matches!(shader, SurfaceShader::Object);
            let drawn = Drawn {
                module: if is_object { &self.object_module } else { &self.surface_module },
                entries: [vertex, opaque],
                layouts: self.layouts.iter().map(Some).collect(),
                attributes: &[SceneGeometry::POSITION_LAYOUT, surface_attributes::LAYOUT],
                has_depth: true,
                is_masked: false,
            };
            SurfacePipelines {
                opaque: drawn.pipeline(device),
                masked: Drawn { is_masked: true, entries: [vertex, masked], ..drawn }.pipeline(device),
            }
        })
    }

    /// What the shaders of markers read.
    pub(super) fn marker_group(
        &self,
        device: &wgpu::Device,
        markers: &Markers,
        signals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let resources = [markers.buffer.as_entire_binding(), signals.as_entire_binding()];
        bind(device, "markers", &self.marker_layout, resources)
    }
}

/// What the pipelines of a picture differ in.
#[derive(Clone)]
struct Drawn<'a> {
    module: &'a wgpu::ShaderModule,
    /// Names of the vertex and the fragment shader.
    entries: [&'a str; 2],
    layouts: Vec<Option<&'a wgpu::BindGroupLayout>>,
    attributes: &'a [wgpu::VertexBufferLayout<'a>],
    /// Whether it hides what is behind it.
    has_depth: bool,
    /// Whether alpha is the share of the pixel's samples that are covered.
    is_masked: bool,
}

impl Drawn<'_> {
    fn pipeline(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.entries[1]),
            bind_group_layouts: &self.layouts,
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let compare =
            if self.has_depth { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Always };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.entries[1]),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some(self.entries[0]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.attributes,
            },
            // Light meets both sides, so both are shown.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.has_depth),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: SAMPLES,
                alpha_to_coverage_enabled: self.is_masked,
                ..wgpu::MultisampleState::default()
            },
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(self.entries[1]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(PICTURE_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Layout of bind group 1: camera, sky, lightmap, triangles, places of objects.
pub(super) fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let fragment = [UNIFORM, TEXTURE, SAMPLER, TEXTURE, STORAGE, STORAGE].map(|ty| (ty, BOTH_STAGES));
    // With the places of objects, fragment shaders would bind more storage buffers than WebGPU guarantees.
    let vertex = [(STORAGE, wgpu::ShaderStages::VERTEX)];
    layout(device, "frame", fragment.into_iter().chain(vertex))
}

fn marker_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, "markers", [(STORAGE, BOTH_STAGES); 2])
}

const BOTH_STAGES: wgpu::ShaderStages = wgpu::ShaderStages::VERTEX_FRAGMENT;
