//! Shader sources. Files are joined by concatenation: a shader is the files that it needs, one after another.

/// Analytic lights: `lights`, `illuminate`. Bind group 0 of whatever uses them.
pub const LIGHTS: &str = include_str!("../shaders/lights.wgsl");

/// Shadows: `light_visibility`. Goes behind [`LIGHTS`]; bind group 0.
pub const SHADOW_MAPS: &str = include_str!("../shaders/shadow_maps.wgsl");

/// Objects: `Placement`, `placed_point`, `placed_direction`.
pub const PLACEMENTS: &str = include_str!("../shaders/placements.wgsl");

/// Light in free space: `light_in_air`, `irradiance_from`, `lamp_of`. Bind group 3 of whatever uses it.
pub const GRID: &str = include_str!("../shaders/grid.wgsl");

/// What objects make of soft light: `object_influence`. Goes behind [`GRID`]; bind group 3.
pub const OBJECT_SPHERES: &str = include_str!("../shaders/object_spheres.wgsl");

/// The shader that draws shadow maps.
pub(super) fn cast_shadows() -> String {
    [LIGHTS, SHADOW_MAPS, PLACEMENTS, include_str!("../shaders/cast_shadows.wgsl")].concat()
}

/// Compiles a shader.
pub(super) fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}
