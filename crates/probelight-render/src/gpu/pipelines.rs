//! The pipelines of a picture and what shaders bind.

use probelight_runtime::gpu::SceneGeometry;
use probelight_runtime::gpu::bindings::{SAMPLER, STORAGE, TEXTURE, UNIFORM, bind, layout};
use probelight_scene::{AlphaMode, Material};

use super::markers::Markers;
use super::picture_target::{DEPTH_FORMAT, PICTURE_FORMAT, SAMPLES};
use super::{shaders, surface_attributes};

/// How each kind of thing is drawn.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) surface: SurfacePipelines,
    pub(super) surface_with_objects: SurfacePipelines,
    pub(super) object: SurfacePipelines,
    pub(super) sky: wgpu::RenderPipeline,
    pub(super) spheres: wgpu::RenderPipeline,
    pub(super) discs: wgpu::RenderPipeline,
    marker_layout: wgpu::BindGroupLayout,
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
    pub(super) fn new(
        device: &wgpu::Device,
        [lights, frame, material, grid]: [&wgpu::BindGroupLayout; 4],
    ) -> Self {
        let marker_layout = marker_layout(device);
        let surface = shaders::module(device, "surface", shaders::surface());
        let objects = shaders::module(device, "objects", shaders::objects());
        let sky = shaders::module(device, "sky", shaders::sky());
        let markers = shaders::module(device, "markers", shaders::markers());
        let attributes = [SceneGeometry::POSITION_LAYOUT, surface_attributes::LAYOUT];
        let drawn = |module, entries, layouts: &[_]| Drawn {
            module,
            entries,
            layouts: layouts.to_vec(),
            attributes: &[],
            has_depth: true,
            is_masked: false,
        };
        let surface_layouts = [Some(lights), Some(frame), Some(material), Some(grid)];
        let marker_layouts = [None, Some(frame), Some(&marker_layout)];
        let surfaces = |module, [vertex, opaque, masked]: [&'static str; 3]| {
            let drawn =
                Drawn { attributes: &attributes, ..drawn(module, [vertex, opaque], &surface_layouts) };
            SurfacePipelines {
                opaque: drawn.pipeline(device),
                masked: Drawn { is_masked: true, entries: [vertex, masked], ..drawn }.pipeline(device),
            }
        };
        let with_objects =
            ["surface_vertex", "surface_color_with_objects", "masked_surface_color_with_objects"];
        Self {
            surface: surfaces(&surface, ["surface_vertex", "surface_color", "masked_surface_color"]),
            surface_with_objects: surfaces(&surface, with_objects),
            object: surfaces(&objects, ["object_vertex", "object_color", "masked_object_color"]),
            sky: Drawn { has_depth: false, ..drawn(&sky, ["sky_vertex", "sky_color"], &[None, Some(frame)]) }
                .pipeline(device),
            spheres: drawn(&markers, ["sphere_vertex", "sphere_color"], &marker_layouts).pipeline(device),
            discs: drawn(&markers, ["disc_vertex", "disc_color"], &marker_layouts).pipeline(device),
            marker_layout,
        }
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
