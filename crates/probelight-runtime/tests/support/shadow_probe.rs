//! Asks the shadow maps about single points.

use probelight_math::glam::Vec3;
use probelight_runtime::gpu::readback::read_buffer;
use probelight_runtime::gpu::{
    GpuDevice, MovingGeometry, SceneGeometry, ShadowMapOptions, ShadowMaps, shaders,
};
use probelight_scene::{Camera, Light, Scene};
use wgpu::util::DeviceExt;

/// A point on one side of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
}

const KERNEL: &str = "
@group(1) @binding(0) var<storage, read> samples: array<array<vec4f, 2>>;
@group(1) @binding(1) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3u) {
    let count = arrayLength(&samples);
    if id.x < count {
        let sample = samples[id.x];
        visibility[id.y * count + id.x] = light_visibility_for_eye(lights.list[id.y], sample[0].xyz, sample[1].xyz);
    }
}
";

/// Visibility of each light from each sample, light by light, as the shadow maps have it.
pub(crate) fn map_visibility(
    gpu: &GpuDevice,
    scene: &Scene,
    lights: &[Light],
    samples: &[Sample],
    options: ShadowMapOptions,
) -> Vec<Vec<f32>> {
    visibility_for(gpu, scene, lights, samples, options, None)
}

/// The same for a picture of a camera.
pub(crate) fn visibility_for(
    gpu: &GpuDevice,
    scene: &Scene,
    lights: &[Light],
    samples: &[Sample],
    options: ShadowMapOptions,
    eye: Option<&Camera>,
) -> Vec<Vec<f32>> {
    let GpuDevice { device, queue, .. } = gpu;
    let geometry = SceneGeometry::new(device, queue, scene).unwrap();
    let mut maps = ShadowMaps::new(device, &geometry, options).unwrap();
    maps.set_lights(device, queue, &geometry, lights).unwrap();

    let packed: Vec<[[f32; 4]; 2]> =
        samples.iter().map(|s| [s.position, s.normal].map(|v| v.extend(0.0).to_array())).collect();
    let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&packed),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let output = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: (lights.len() * samples.len() * 4) as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let (pipeline, group) = kernel(device, &maps, &input, &output);

    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    maps.encode(&mut encoder, &geometry);
    if let Some(eye) = eye {
        let nothing_moves = MovingGeometry::new(device);
        maps.fit_to_eye(device, queue, &mut encoder, &geometry, &nothing_moves, eye);
    }
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, maps.bind_group(), &[]);
    pass.set_bind_group(1, &group, &[]);
    pass.dispatch_workgroups(samples.len().div_ceil(64) as u32, lights.len() as u32, 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    let visibility: Vec<f32> = read_buffer(device, queue, &output).unwrap();
    visibility.chunks_exact(samples.len()).map(<[f32]>::to_vec).collect()
}

fn kernel(
    device: &wgpu::Device,
    maps: &ShadowMaps,
    input: &wgpu::Buffer,
    output: &wgpu::Buffer,
) -> (wgpu::ComputePipeline, wgpu::BindGroup) {
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[entry(0, true), entry(1, false)],
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
        ],
    });
    let source = [shaders::LIGHTS, shaders::SHADOW_MAPS, KERNEL].concat();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(maps.bind_group_layout()), Some(&layout)],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("probe"),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("probe"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    (pipeline, group)
}
