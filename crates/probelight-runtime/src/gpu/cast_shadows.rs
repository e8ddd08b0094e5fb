//! Draws depth from the views of lights, for [`shadow_maps`](super::shadow_maps).

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::bindings::{STORAGE, UNIFORM};
use super::moving_geometry::MovingGeometry;
use super::scene_geometry::{AlphaMasks, SceneGeometry};
use super::shaders;

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
    scene: CastPipelines,
    objects: CastPipelines,
    views: wgpu::BindGroup,
    view_buffer: wgpu::Buffer,
    object_layout: wgpu::BindGroupLayout,
    object_count: wgpu::Buffer,
}

#[derive(Debug)]
struct CastPipelines {
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

impl Caster {
    /// Compiles them for views in `view_buffer`.
    pub(super) fn new(device: &wgpu::Device, geometry: &SceneGeometry, view_buffer: &wgpu::Buffer) -> Self {
        let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX,
            ty,
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow views"),
            entries: &[entry((1, UNIFORM))],
        });
        let object_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow views and objects"),
            entries: &[(1, UNIFORM), (4, STORAGE), (5, UNIFORM)].map(entry),
        });
        let views = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow views"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 1, resource: view_buffer.as_entire_binding() }],
        });
        let module = shaders::module(device, "cast_shadows", &shaders::cast_shadows());
        let pipelines = |views: &wgpu::BindGroupLayout, [opaque, masked]: [&str; 2]| CastPipelines {
            opaque: cast_pipeline(device, &module, &[views], opaque, false),
            masked: cast_pipeline(device, &module, &[views, &geometry.masks.layout], masked, true),
        };
        Self {
            scene: pipelines(&layout, ["cast_opaque", "cast_masked"]),
            objects: pipelines(&object_layout, ["cast_opaque_object", "cast_masked_object"]),
            views,
            view_buffer: view_buffer.clone(),
            object_count: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("number of objects"),
                size: 16,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            object_layout,
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
        let mut pass = depth_pass(encoder, layer, wgpu::LoadOp::Clear(0.0));
        pass.set_bind_group(0, &self.views, &[]);
        self.scene.draw(&mut pass, geometry, view..view + 1);
    }

    /// What [`draw_objects`](Self::draw_objects) needs to know of the objects.
    pub(super) fn bind_objects(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        moving: &MovingGeometry,
    ) -> wgpu::BindGroup {
        queue.write_buffer(&self.object_count, 0, bytemuck::bytes_of(&[moving.count, 0, 0, 0]));
        let buffers = [(1, &self.view_buffer), (4, &moving.placements), (5, &self.object_count)];
        let entries = buffers
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow views and objects"),
            layout: &self.object_layout,
            entries: &entries,
        })
    }

    /// Draws the depth of all objects over one view's.
    pub(super) fn draw_objects(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        moving: &MovingGeometry,
        bound: &wgpu::BindGroup,
        layer: &wgpu::TextureView,
        view: u32,
    ) {
        let mut pass = depth_pass(encoder, layer, wgpu::LoadOp::Load);
        pass.set_bind_group(0, bound, &[]);
        for model in &moving.models {
            let first = view * moving.count;
            let instances = first + model.objects.start..first + model.objects.end;
            self.objects.draw(&mut pass, &model.geometry, instances);
        }
    }
}

impl CastPipelines {
    fn draw(&self, pass: &mut wgpu::RenderPass, geometry: &SceneGeometry, instances: Range<u32>) {
        pass.set_pipeline(&self.opaque);
        pass.set_vertex_buffer(0, geometry.positions.slice(..));
        if !geometry.opaque.is_empty() {
            pass.draw(geometry.opaque.clone(), instances.clone());
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
            pass.draw(vertices.start - first_masked..vertices.end - first_masked, instances.clone());
        }
    }
}

fn depth_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    layer: &wgpu::TextureView,
    load: wgpu::LoadOp<f32>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("shadow map"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: layer,
            depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    })
}

fn cast_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layouts: &[&wgpu::BindGroupLayout],
    entry_point: &str,
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
            entry_point: Some(entry_point),
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
