//! Shader sources. Files are joined by concatenation: a shader is the files that it needs, one after another.

/// Analytic lights: `lights`, `illuminate`. Bind group 0 of whatever uses them.
pub const LIGHTS: &str = include_str!("../shaders/lights.wgsl");

/// Shadows: `light_visibility`. Goes behind [`LIGHTS`]; bind group 0.
pub const SHADOW_MAPS: &str = include_str!("../shaders/shadow_maps.wgsl");

/// The shader that draws shadow maps.
pub(super) fn cast_shadows() -> String {
    [LIGHTS, SHADOW_MAPS, include_str!("../shaders/cast_shadows.wgsl")].concat()
}

/// Compiles a shader.
pub(super) fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}
