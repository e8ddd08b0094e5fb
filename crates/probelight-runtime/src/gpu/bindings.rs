//! Bind groups whose resources have the bindings 0, 1, … in their order, and the layouts of such groups.

/// A buffer that shaders only read.
pub const STORAGE: wgpu::BindingType = buffer(wgpu::BufferBindingType::Storage { read_only: true });

/// A small buffer, the same for all of a draw or dispatch.
pub const UNIFORM: wgpu::BindingType = buffer(wgpu::BufferBindingType::Uniform);

/// A picture that can be filtered.
pub const TEXTURE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// A sampler that filters.
pub const SAMPLER: wgpu::BindingType = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);

const fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// A layout of bindings 0, 1, …, each with the shaders that see it.
pub fn layout(
    device: &wgpu::Device,
    label: &str,
    types: impl IntoIterator<Item = (wgpu::BindingType, wgpu::ShaderStages)>,
) -> wgpu::BindGroupLayout {
    let entry =
        |(binding, (ty, visibility))| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = (0..).zip(types).map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Binds resources to the bindings 0, 1, … of a group.
pub fn bind<'a>(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
