//! Draws depth from the views of lights, for [`shadow_maps`](super::shadow_maps).

use bytemuck::{Pod, Zeroable};

use super::scene_geometry::{AlphaMasks, SceneGeometry};
use super::shaders;
use super::shadow_maps::uniform_entry;

/// Format of the maps.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// When a masked surface exists: `AlphaTest` in `cast_shadows.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct AlphaTestRecord {
    /// Factor on the mask.
    pub(super) factor: f32, //      0
    /// The least product that is solid.
    pub(super) cutoff: f32, //      4
    /// Fills the record.
    pub(super) unused: [f32; 2], // 8
}

/// The pipelines that draw depth.
#[derive(Debug)]
pub(super) struct Caster {
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    views: wgpu::BindGroup,
}

impl Caster {
    /// Compiles them for views in `view_buffer`.
    pub(super) fn new(device: &wgpu::Device, geometry: &SceneGeometry, view_buffer: &wgpu::Buffer) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow views"),
            entries: &[uniform_entry(1, wgpu::ShaderStages::VERTEX)],
        });
        let views = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow views"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 1, resource: view_buffer.as_entire_binding() }],
        });
        let module = shaders::module(device, "cast_shadows", &shaders::cast_shadows());
        Self {
            opaque: cast_pipeline(device, &module, &[&layout], false),
            masked: cast_pipeline(device, &module, &[&layout, &geometry.masks.layout], true),
            views,
        }
    }

    /// Draws one view's depth.
    pub(super) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        geometry: &SceneGeometry,
        layer: &wgpu::TextureView,
        view: u32,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow map"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: layer,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.opaque);
        pass.set_bind_group(0, &self.views, &[]);
        pass.set_vertex_buffer(0, geometry.positions.slice(..));
        if !geometry.opaque.is_empty() {
            pass.draw(geometry.opaque.clone(), view..view + 1);
        }
        if geometry.masks.parts.is_empty() {
            return;
        }
        let first_masked = geometry.opaque.end;
        pass.set_pipeline(&self.masked);
        pass.set_vertex_buffer(0, geometry.positions.slice(u64::from(first_masked) * 12..));
        pass.set_vertex_buffer(1, geometry.masks.uvs.slice(..));
        for (vertices, mask) in &geometry.masks.parts {
            pass.set_bind_group(1, mask, &[]);
            pass.draw(vertices.start - first_masked..vertices.end - first_masked, view..view + 1);
        }
    }
}

fn cast_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layouts: &[&wgpu::BindGroupLayout],
    is_masked: bool,
) -> wgpu::RenderPipeline {
    let layouts: Vec<_> = layouts.iter().map(|layout| Some(*layout)).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("cast shadows"),
        bind_group_layouts: &layouts,
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let buffers = [SceneGeometry::POSITION_LAYOUT, AlphaMasks::UV_LAYOUT];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("cast shadows"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(if is_masked { "cast_masked" } else { "cast_opaque" }),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: if is_masked { &buffers } else { &buffers[..1] },
        },
        // Both sides cast: walls may be single sheets.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: is_masked.then_some(wgpu::FragmentState {
            module,
            entry_point: Some("cut_holes"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}
