//! Exposure and tone map on the GPU: from a linear picture to a window, or to any 8-bit texture.

use bytemuck::{Pod, Zeroable};

use super::picture_target::PictureTarget;
use super::shaders;
use super::view::GpuView;
use crate::ToneMap;

/// `Display` in `tone_map.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct DisplayRecord {
    pub(super) exposure: f32,     //     0
    pub(super) has_curve: u32,    //    4
    pub(super) encodes_srgb: u32, // 8
    pub(super) unused: u32,       //      12
}

/// Shows pictures on targets of one format.
#[derive(Debug)]
pub struct Presenter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    display: wgpu::Buffer,
    encodes_srgb: bool,
}

impl Presenter {
    /// For targets of `format`, such as that of a window's surface.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let module = shaders::module(device, "tone map", shaders::tone_map());
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("tone map"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("display_color"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let display = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("display"),
            size: size_of::<DisplayRecord>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            device: device.clone(),
            queue: queue.clone(),
            pipeline,
            display,
            encodes_srgb: !format.is_srgb(),
        }
    }

    /// Shows a finished picture of `view` on `target`, which has the picture's size. One picture may be shown
    /// per submission.
    pub fn present(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        picture: &PictureTarget,
        view: GpuView,
        tone_map: ToneMap,
        target: &wgpu::TextureView,
    ) {
        let record = DisplayRecord {
            exposure: if view.is_light() { tone_map.scale } else { 1.0 },
            has_curve: u32::from(view.is_light()),
            encodes_srgb: u32::from(self.encodes_srgb),
            unused: 0,
        };
        self.queue.write_buffer(&self.display, 0, bytemuck::bytes_of(&record));
        let picture = wgpu::BindingResource::TextureView(&picture.resolved_view);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("tone map"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.display.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: picture },
            ],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tone map"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
