//! Compute shaders and what is bound to them.

use wgpu::{BindGroup, BindGroupLayout, BindingResource, ComputePass};

use super::shaders;
use super::stage_shaders::Shader;

/// Most workgroups along one dimension: WebGPU's guaranteed limit.
const MOST_WORKGROUPS: u32 = 65_535;

/// A compute shader, ready to run.
#[derive(Debug)]
pub(super) struct Kernel {
    label: &'static str,
    pipeline: wgpu::ComputePipeline,
}

impl Kernel {
    /// Compiles a shader. Its bind groups have the layouts given, or else those that the shader implies.
    pub(super) fn new(device: &wgpu::Device, shader: &Shader, layouts: Option<&[&BindGroupLayout]>) -> Self {
        let label = shader.entry_point;
        let layout = layouts.map(|layouts| {
            let layouts: Vec<_> = layouts.iter().copied().map(Some).collect();
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &layouts,
                immediate_size: 0,
            })
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: layout.as_ref(),
            module: &shaders::module(device, label, &shader.source()),
            entry_point: Some(label),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { label, pipeline }
    }

    /// Binds resources to the bindings 0, 1, … of a group.
    pub(super) fn bind(&self, device: &wgpu::Device, group: u32, resources: &[BindingResource]) -> BindGroup {
        self.bind_at(device, group, (0..).zip(resources.iter().cloned()))
    }

    /// Binds resources to bindings of a group by number.
    pub(super) fn bind_at<'a>(
        &self,
        device: &wgpu::Device,
        group: u32,
        resources: impl IntoIterator<Item = (u32, BindingResource<'a>)>,
    ) -> BindGroup {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<wgpu::BindGroupEntry> = resources.into_iter().map(entry).collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.pipeline.get_bind_group_layout(group),
            entries: &entries,
        })
    }

    /// Runs as many workgroups, or up to two dimensions of them where one cannot hold so many: shaders compare
    /// their `linear_workgroup` with the number of their tasks.
    pub(super) fn run(&self, pass: &mut ComputePass, groups: &[&BindGroup], workgroups: usize) {
        if workgroups == 0 {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, *group, &[]);
        }
        let rows = workgroups.div_ceil(MOST_WORKGROUPS as usize);
        pass.dispatch_workgroups(workgroups.div_ceil(rows) as u32, rows as u32, 1);
    }

    /// Runs `width × height` workgroups.
    pub(super) fn run_2d(&self, pass: &mut ComputePass, group: &BindGroup, width: u32, height: u32) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(width, height, 1);
    }
}

/// Bindings of whole buffers.
pub(super) fn whole<'a>(buffers: &[&'a wgpu::Buffer]) -> Vec<wgpu::BindingResource<'a>> {
    buffers.iter().map(|buffer| buffer.as_entire_binding()).collect()
}
