//! The stages on a device of your own, in a command encoder of your own, and the lightmap in a shader of your own.
//!
//! `cargo run --release -p probelight-runtime --example own_device -- room.plight`
//!
//! Without a file it makes a room of random numbers, which has no light in free space. A small copy of the scene moves
//! through it as an object: it casts shadows, and a shader here looks at the light that it gets. The other one looks at the lightmap in its middle; a renderer
//! would use the corners of `LightmapLayout::faces` as texture coordinates, divided by the lightmap's size.

#![expect(clippy::print_stdout, reason = "this is its output")]

use std::error::Error;
use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::FrameInput;
use probelight_runtime::gpu::{GpuOptions, GpuRuntime, readback, shaders};
use probelight_runtime::synthetic::{SyntheticSize, synthetic_room};
use probelight_scene::{Light, Lighting, Object, Placement, Sky};

const SHADER: &str = "
@group(0) @binding(0) var lightmap: texture_2d<f32>;
@group(0) @binding(1) var bilinear: sampler;
@group(0) @binding(2) var<storage, read_write> looked_at: vec4f;

@compute @workgroup_size(1)
fn look() {
    looked_at = textureSampleLevel(lightmap, bilinear, vec2f(0.5), 0.0);
}
";

/// Goes behind the runtime's own [`shaders::GRID`], whose bind group is number 3.
const SHADER_IN_AIR: &str = "
struct Place { position: vec4f, irradiance: vec4f }
@group(0) @binding(0) var<storage, read_write> place: Place;

@compute @workgroup_size(1)
fn look_in_air() {
    let up = vec3f(0.0, 1.0, 0.0);
    var light = light_in_air(place.position.xyz, up);
    place.irradiance = vec4f(irradiance_from(&light, up), 0.0);
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let (device, queue) = open_device()?;
    let baked = match std::env::args_os().nth(1) {
        Some(path) => BakedScene::read(path.as_ref())?,
        None => BakedScene::new(synthetic_room(SyntheticSize::hybrid(20_000)))?,
    };
    let scene = Arc::clone(&baked.scene);
    let mut runtime = GpuRuntime::new(&device, &queue, Arc::new(baked), GpuOptions::default())?;
    runtime.set_base_color(0, Vec3::new(0.8, 0.3, 0.2))?;

    let looked_at = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("looked at"),
        size: 16,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let (pipeline, group) = new_look(&device, runtime.lightmap_view(), &looked_at);

    let bounds = scene.bounds();
    let small = |position| Placement { scale: 0.05, ..Placement::at(position) };
    let object = runtime.objects_mut().insert(Object::new(scene, small(bounds.min))?);
    let place = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("place in the air"),
        size: 32,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let (pipeline_in_air, group_in_air) = new_look_in_air(&device, &runtime, &place);

    for hour in 0..6 {
        // The sun goes down; the light in the room follows, one bounce a frame.
        let direction = Vec3::new(0.3 * hour as f32 - 0.9, -0.8, 0.2).normalize();
        let sun = Light::Directional { direction, irradiance: Vec3::splat(4.0 - 0.5 * hour as f32) };
        let sky = Sky::Uniform(Vec3::new(0.2, 0.3, 0.5) * (1.0 - 0.15 * hour as f32));
        runtime.set_lighting(Lighting { lights: vec![sun], sky, ..Lighting::default() })?;

        let position = bounds.min.lerp(bounds.max, 0.2 + 0.1 * hour as f32);
        runtime.objects_mut().place(object, small(position))?;
        queue.write_buffer(&place, 0, bytemuck::bytes_of(&position.extend(1.0)));

        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        runtime.encode(&FrameInput::default(), &mut encoder);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_pipeline(&pipeline_in_air);
        pass.set_bind_group(0, &group_in_air, &[]);
        pass.set_bind_group(3, runtime.grid().bind_group(), &[]);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        queue.submit([encoder.finish()]);

        // Only to print it: a renderer leaves everything on the GPU.
        let light: Vec<f32> = readback::read_buffer(&device, &queue, &looked_at)?;
        let in_air: Vec<f32> = readback::read_buffer(&device, &queue, &place)?;
        println!("hour {hour}: {:.3?} W/m², the object {:.3?} from above", &light[..3], &in_air[4..7]);
    }
    Ok(())
}

/// A device as any program may have one: WebGPU's default limits, no features.
fn open_device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    Ok(pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?)
}

/// A shader that samples the lightmap like any other texture.
fn new_look(
    device: &wgpu::Device,
    lightmap: &wgpu::TextureView,
    looked_at: &wgpu::Buffer,
) -> (wgpu::ComputePipeline, wgpu::BindGroup) {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("look"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("look"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("look"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            entry(0, wgpu::BindingResource::TextureView(lightmap)),
            entry(1, wgpu::BindingResource::Sampler(&sampler)),
            entry(2, looked_at.as_entire_binding()),
        ],
    });
    (pipeline, group)
}

/// A shader that reads the grid.
fn new_look_in_air(
    device: &wgpu::Device,
    runtime: &GpuRuntime,
    place: &wgpu::Buffer,
) -> (wgpu::ComputePipeline, wgpu::BindGroup) {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("look in air"),
        source: wgpu::ShaderSource::Wgsl([shaders::GRID, SHADER_IN_AIR].concat().into()),
    });
    let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("look in air"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("look in air"),
        bind_group_layouts: &[Some(&own), None, None, Some(runtime.grid().bind_group_layout())],
        ..wgpu::PipelineLayoutDescriptor::default()
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("look in air"),
        layout: Some(&layout),
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("look in air"),
        layout: &own,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: place.as_entire_binding() }],
    });
    (pipeline, group)
}
