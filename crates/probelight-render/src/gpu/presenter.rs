//! Exposure, tone map and false colours on the GPU: from a linear picture, or two beside each other, to a window, or to any
//! 8-bit texture.

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
    pub(super) coloring: u32,     //     12
    pub(super) divider: f32,      //      16
    pub(super) fade: f32,         //         20
    pub(super) marks: u32,        //        24
    pub(super) unused: u32,       //       28
}

/// What the colours of a picture of light stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Coloring {
    /// As one would see it.
    #[default]
    Natural = 0,
    /// Stops below and above middle grey: blue six below, over green, grey, yellow, to red six above.
    Stops = 1,
    /// Difference from the other picture: red where this one is brighter, blue where it is darker, full from half of it on.
    Difference = 2,
}

/// A finished picture and how it is shown.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The picture.
    pub picture: &'a PictureTarget,
    /// What it shows.
    pub view: GpuView,
    /// How bright.
    pub tone_map: ToneMap,
    /// Another picture of the same, of any size, linear; itself if there is none.
    pub other: Option<&'a wgpu::TextureView>,
    /// Left of this share of the width the other picture is shown.
    pub divider: f32,
    /// Share of the other picture in the rest.
    pub fade: f32,
    /// In which colours.
    pub coloring: Coloring,
    /// Whether pixels are marked that are no number (magenta), negative (cyan) or too bright (red stripes).
    pub marks: bool,
}

impl<'a> Shown<'a> {
    /// All of a picture, as one would see it.
    pub fn new(picture: &'a PictureTarget, view: GpuView, tone_map: ToneMap) -> Self {
        Self {
            picture,
            view,
            tone_map,
            other: None,
            divider: 0.0,
            fade: 0.0,
            coloring: Coloring::Natural,
            marks: false,
        }
    }
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

    /// Shows a picture on `target`, which has the picture's size. One picture may be shown per submission.
    pub fn present(&self, encoder: &mut wgpu::CommandEncoder, shown: &Shown, target: &wgpu::TextureView) {
        let record = DisplayRecord {
            exposure: if shown.view.is_light() { shown.tone_map.scale } else { 1.0 },
            has_curve: u32::from(shown.view.is_light()),
            encodes_srgb: u32::from(self.encodes_srgb),
            coloring: shown.coloring as u32,
            divider: shown.divider * shown.picture.texture().width() as f32,
            fade: shown.fade,
            marks: u32::from(shown.marks),
            unused: 0,
        };
        self.queue.write_buffer(&self.display, 0, bytemuck::bytes_of(&record));
        let picture = &shown.picture.resolved_view;
        let other = wgpu::BindingResource::TextureView(shown.other.unwrap_or(picture));
        let picture = wgpu::BindingResource::TextureView(picture);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("tone map"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.display.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: picture },
                wgpu::BindGroupEntry { binding: 2, resource: other },
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
