//! What a GPU cannot hold, and light that cannot be, are refused by name.
#![cfg(all(feature = "cpu", feature = "gpu", feature = "blocking"))]

#[path = "support/gpu.rs"]
mod gpu;
mod support;

use probelight_math::glam::Vec3;
use probelight_runtime::gpu::{GpuError, GpuOptions, GpuRuntime};
use probelight_scene::{Light, Lighting};
use support::{SMALL, checked, random_room};

#[test]
fn arrays_that_cannot_be_divided_are_refused() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let options = GpuOptions { largest_buffer: Some(1000), ..GpuOptions::default() };
    let refused = GpuRuntime::new(&gpu.device, &gpu.queue, checked(random_room(SMALL)), options);
    assert!(matches!(refused, Err(GpuError::TooLarge { limit: 1000, .. })));
}

/// A device that can bind little refuses a scene by name, before a driver has to.
#[test]
fn devices_with_small_limits_refuse_large_arrays() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let open = |limit: u64| {
        let required_limits =
            wgpu::Limits { max_storage_buffer_binding_size: limit, ..wgpu::Limits::default() };
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..wgpu::DeviceDescriptor::default() };
        pollster::block_on(gpu.adapter.request_device(&descriptor)).unwrap()
    };
    let baked = checked(random_room(SMALL));
    let (device, queue) = open(100);
    let refused = GpuRuntime::new(&device, &queue, baked.clone(), GpuOptions::default()).unwrap_err();
    assert!(matches!(refused, GpuError::TooLarge { content: "triangles", limit: 100, .. }), "{refused}");
    let (device, queue) = open(1000);
    let refused = GpuRuntime::new(&device, &queue, baked.clone(), GpuOptions::default()).unwrap_err();
    assert!(matches!(refused, GpuError::TooLarge { limit: 1000, .. }), "{refused}");
    let (device, queue) = open(1 << 20);
    GpuRuntime::new(&device, &queue, baked, GpuOptions::default()).unwrap();
}

#[test]
fn light_that_cannot_be_is_refused() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let baked = checked(random_room(SMALL));
    let mut runtime = GpuRuntime::new(&gpu.device, &gpu.queue, baked, GpuOptions::default()).unwrap();
    let before = runtime.lighting().clone();
    let light = Light::Point { position: Vec3::ZERO, intensity: Vec3::NAN, range: None };
    let wrong = Lighting { lights: vec![light], ..Lighting::default() };
    assert!(matches!(runtime.set_lighting(wrong), Err(GpuError::Input(_))));
    assert_eq!(*runtime.lighting(), before);
}
