//! Materials as shaders read them.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec3;
use probelight_runtime::SurfaceColors;
use probelight_runtime::gpu::bindings::{SAMPLER, TEXTURE, UNIFORM, bind, layout};
use probelight_scene::{AlphaMode, Material, Scene, TextureSlot};

use super::material_textures::{Encoding, MaterialTextures};

/// `Material` in `material.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MaterialRecord {
    pub(super) base_color: [f32; 4], //   0
    pub(super) emission: [f32; 3],   //    16
    pub(super) metallic: f32,        //         28
    pub(super) roughness: f32,       //        32
    pub(super) normal_scale: f32,    //     36
    pub(super) alpha_cutoff: f32,    //     40
    pub(super) second_uv_sets: u32,  //   44
}

/// Bytes between materials in their buffer: WebGPU's alignment of what is bound as a uniform.
const STRIDE: usize = 256;

/// All materials of a scene.
#[derive(Debug)]
pub(super) struct Materials {
    records: Vec<MaterialRecord>,
    buffer: wgpu::Buffer,
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) bind_groups: Vec<wgpu::BindGroup>,
}

impl Materials {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Self {
        let types = [UNIFORM, SAMPLER, TEXTURE, TEXTURE, TEXTURE, TEXTURE, TEXTURE];
        let layout = layout(device, "material", types.map(|ty| (ty, wgpu::ShaderStages::FRAGMENT)));
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("materials"),
            size: (scene.materials.len() * STRIDE) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        // As fine as it gets along a slanted surface, where one mip level would blur.
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("materials"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: 16,
            ..wgpu::SamplerDescriptor::default()
        });
        let mut textures = MaterialTextures::new(device, queue, &scene.textures);
        let bind_group = |(index, material)| {
            let record = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &buffer,
                offset: (index * STRIDE) as u64,
                size: wgpu::BufferSize::new(size_of::<MaterialRecord>() as u64),
            });
            let views = material_views(&mut textures, material);
            let fixed = [record, wgpu::BindingResource::Sampler(&sampler)];
            let views = views.iter().map(wgpu::BindingResource::TextureView);
            bind(device, "material", &layout, fixed.into_iter().chain(views))
        };
        let bind_groups = scene.materials.iter().enumerate().map(bind_group).collect();
        Self { records: Vec::new(), buffer, layout, bind_groups }
    }

    /// Uploads the materials with their present colours if these changed.
    pub(super) fn set_colors(&mut self, queue: &wgpu::Queue, scene: &Scene, colors: &[SurfaceColors]) {
        let records: Vec<_> = scene.materials.iter().zip(colors).map(|(m, c)| record(m, c)).collect();
        if records == self.records {
            return;
        }
        let mut bytes = vec![0; records.len() * STRIDE];
        for (slot, record) in bytes.chunks_exact_mut(STRIDE).zip(&records) {
            slot[..size_of::<MaterialRecord>()].copy_from_slice(bytemuck::bytes_of(record));
        }
        queue.write_buffer(&self.buffer, 0, &bytes);
        self.records = records;
    }
}

fn record(material: &Material, colors: &SurfaceColors) -> MaterialRecord {
    let uses_second_set = |(bit, slot): (u32, Option<TextureSlot>)| {
        u32::from(slot.is_some_and(|slot| slot.tex_coord == 1)) << bit
    };
    MaterialRecord {
        base_color: colors.base_color.extend(material.base_color.w).to_array(),
        emission: Vec3::to_array(&colors.emission),
        metallic: material.metallic,
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque => 0.0,
        },
        second_uv_sets: (0..).zip(material.texture_slots()).map(uses_second_set).sum(),
    }
}

/// The textures in the order of their bindings.
fn material_views(textures: &mut MaterialTextures, material: &Material) -> [wgpu::TextureView; 5] {
    [
        textures.view(material.base_color_texture, Encoding::Srgb),
        textures.view(material.metallic_roughness_texture, Encoding::Linear),
        textures.normal_view(material.normal_texture),
        textures.view(material.occlusion_texture, Encoding::Linear),
        textures.view(material.emissive_texture, Encoding::Srgb),
    ]
}
