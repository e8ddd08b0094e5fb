//! WGSL sources. A shader is the files that it needs, one after another.

use probelight_runtime::gpu::shaders::{GRID, LIGHTS, OBJECT_SPHERES, PLACEMENTS, SHADOW_MAPS};

const FRAME: &str = include_str!("../shaders/frame.wgsl");
const MATERIAL: &str = include_str!("../shaders/material.wgsl");
const BRDF: &str = include_str!("../shaders/brdf.wgsl");
const SOFT_LIGHT: &str = include_str!("../shaders/soft_light.wgsl");
const SURFACE: &str = include_str!("../shaders/surface.wgsl");

/// Surfaces of the scene.
pub(super) fn surface() -> String {
    [LIGHTS, SHADOW_MAPS, GRID, OBJECT_SPHERES, FRAME, MATERIAL, BRDF, SOFT_LIGHT, SURFACE].concat()
}

/// Objects.
pub(super) fn objects() -> String {
    [&surface(), PLACEMENTS, include_str!("../shaders/objects.wgsl")].concat()
}

/// The sky behind the scene.
pub(super) fn sky() -> String {
    [FRAME, include_str!("../shaders/sky.wgsl")].concat()
}

/// Probes and light samples.
pub(super) fn markers() -> String {
    [FRAME, include_str!("../shaders/markers.wgsl")].concat()
}

/// From radiance to a screen.
pub(super) fn tone_map() -> String {
    include_str!("../shaders/tone_map.wgsl").into()
}

/// Compiles a shader.
pub(super) fn module(device: &wgpu::Device, label: &str, source: String) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}
