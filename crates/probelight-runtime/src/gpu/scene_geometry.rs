//! The scene's triangles on the GPU, as far as shadows need them.
//!
//! Every triangle has three vertices of its own. Surfaces are lit by a lightmap whose coordinates belong to the
//! corners of triangles, so few vertices could be shared anyway; and triangles in the order of their materials
//! need no index buffer. Triangles of opaque materials come first: one draw call casts all their shadows.

use std::ops::Range;

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{AlphaMode, Bounds, Scene, Texture};
use wgpu::BufferUsages;
use wgpu::util::DeviceExt;

use super::bindings::{SAMPLER, TEXTURE, UNIFORM, bind, layout};
use super::cast_shadows::AlphaTestRecord;
use super::device::{GpuError, checked};
use super::filled_buffer::filled_buffer;

/// Triangles of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialPart {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Its vertices: three for each of its triangles.
    pub vertices: Range<u32>,
}

/// The triangles of a scene in the memory of a GPU.
#[derive(Debug)]
pub struct SceneGeometry {
    /// Vertex and storage buffer of world positions: three `f32`, metres; 12 bytes.
    pub positions: wgpu::Buffer,
    /// The scene's triangles in the order of their vertices.
    pub triangle_order: Vec<u32>,
    /// Materials that have triangles, opaque ones first.
    pub parts: Vec<MaterialPart>,
    /// The smallest box around all triangles.
    pub bounds: Bounds,
    pub(super) opaque: Range<u32>,
    pub(super) masks: AlphaMasks,
}

/// Where the surfaces of alpha-masked materials have holes.
#[derive(Debug)]
pub(super) struct AlphaMasks {
    /// Vertex buffer of texture coordinates, from the first vertex behind the opaque ones.
    pub(super) uvs: wgpu::Buffer,
    pub(super) layout: wgpu::BindGroupLayout,
    /// Vertices of a material, and how to test them.
    pub(super) parts: Vec<(Range<u32>, wgpu::BindGroup)>,
}

impl SceneGeometry {
    /// Copies a valid scene's triangles.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<Self, GpuError> {
        let (triangle_order, parts) = group_by_material(scene);
        let corners: Vec<Vec3> =
            triangle_order.iter().flat_map(|triangle| scene.corners(*triangle as usize)).collect();
        let opaque_end = parts
            .iter()
            .filter(|part| !is_masked(scene, part.material))
            .map(|part| part.vertices.end)
            .max()
            .unwrap_or(0);
        checked(device, "the scene's triangles", || {
            let (positions, usage) =
                (bytemuck::cast_slice(&corners), BufferUsages::VERTEX | BufferUsages::STORAGE);
            Ok(Self {
                positions: filled_buffer(device, "triangles", positions, usage)?,
                masks: AlphaMasks::new(device, queue, scene, &triangle_order, &parts, opaque_end)?,
                opaque: 0..opaque_end,
                bounds: scene.bounds(),
                triangle_order,
                parts,
            })
        })
    }

    /// How the vertex buffer of positions is laid out: shader location 0.
    pub const POSITION_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    };
}

impl AlphaMasks {
    /// How the vertex buffer of texture coordinates is laid out: shader location 1.
    pub(super) const UV_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
        array_stride: 8,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![1 => Float32x2],
    };

    fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        triangle_order: &[u32],
        parts: &[MaterialPart],
        first_vertex: u32,
    ) -> Result<Self, GpuError> {
        let masked = &triangle_order[first_vertex as usize / 3..];
        let corner_uvs = |triangle: &u32| {
            let triangle = *triangle as usize;
            let set = scene.material(triangle).base_color_texture.map_or(0, |slot| slot.tex_coord);
            [Vec2::ZERO, Vec2::X, Vec2::Y].map(|corner| scene.uv(triangle, corner, set))
        };
        let uvs: Vec<Vec2> = masked.iter().flat_map(corner_uvs).collect();
        let layout = mask_layout(device);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("alpha mask"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let parts = parts
            .iter()
            .filter(|part| part.vertices.start >= first_vertex)
            .map(|part| {
                let group = mask_bind_group(device, queue, scene, part.material, &layout, &sampler);
                (part.vertices.clone(), group)
            })
            .collect();
        let uvs = bytemuck::cast_slice(&uvs);
        let uvs =
            filled_buffer(device, "texture coordinates of masked triangles", uvs, BufferUsages::VERTEX)?;
        Ok(Self { uvs, layout, parts })
    }
}

/// The triangles ordered by material, those of opaque materials first, and each material's share.
fn group_by_material(scene: &Scene) -> (Vec<u32>, Vec<MaterialPart>) {
    let material_of = |triangle: &u32| scene.triangle_material[*triangle as usize];
    let mut order: Vec<u32> = (0..scene.triangles.len() as u32).collect();
    order.sort_by_key(|triangle| (is_masked(scene, material_of(triangle)), material_of(triangle)));
    let mut first = 0;
    let parts = order.chunk_by(|a, b| material_of(a) == material_of(b)).map(|triangles| {
        let vertices = first..first + 3 * triangles.len() as u32;
        first = vertices.end;
        MaterialPart { material: material_of(&triangles[0]), vertices }
    });
    let parts = parts.collect();
    (order, parts)
}

fn is_masked(scene: &Scene, material: u32) -> bool {
    matches!(scene.materials[material as usize].alpha_mode, AlphaMode::Mask { .. })
}

fn mask_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, "alpha mask", [UNIFORM, TEXTURE, SAMPLER].map(|ty| (ty, wgpu::ShaderStages::FRAGMENT)))
}

fn mask_bind_group(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
    material: u32,
    layout: &wgpu::BindGroupLayout,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let material = &scene.materials[material as usize];
    let cutoff = if let AlphaMode::Mask { cutoff } = material.alpha_mode { cutoff } else { 0.0 };
    let test = AlphaTestRecord { factor: material.base_color.w, cutoff, ..AlphaTestRecord::default() };
    let test = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("alpha test"),
        contents: bytemuck::bytes_of(&test),
        usage: BufferUsages::UNIFORM,
    });
    let texture = material.base_color_texture.map(|slot| &scene.textures[slot.texture as usize]);
    let view = alpha_texture(device, queue, texture).create_view(&wgpu::TextureViewDescriptor::default());
    let resources = [
        test.as_entire_binding(),
        wgpu::BindingResource::TextureView(&view),
        wgpu::BindingResource::Sampler(sampler),
    ];
    bind(device, "alpha mask", layout, resources)
}

/// The alpha channel of a texture, or one opaque texel.
fn alpha_texture(device: &wgpu::Device, queue: &wgpu::Queue, texture: Option<&Texture>) -> wgpu::Texture {
    let (width, height) = texture.map_or((1, 1), |texture| (texture.width, texture.height));
    let alphas: Vec<u8> =
        texture.map_or(vec![255], |texture| texture.rgba8.chunks_exact(4).map(|texel| texel[3]).collect());
    let descriptor = wgpu::TextureDescriptor {
        label: Some("alpha mask"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    device.create_texture_with_data(queue, &descriptor, wgpu::util::TextureDataOrder::LayerMajor, &alphas)
}

#[cfg(test)]
mod tests {
    use probelight_scene::Material;

    use super::*;

    #[test]
    fn opaque_triangles_come_first_and_every_triangle_once() {
        let mask = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..Material::default() };
        let scene = Scene {
            materials: vec![mask, Material::default(), Material::default()],
            triangles: vec![[0; 3]; 6],
            triangle_material: vec![2, 0, 1, 0, 2, 1],
            ..Scene::default()
        };
        let (order, parts) = group_by_material(&scene);
        assert_eq!(order, [2, 5, 0, 4, 1, 3]);
        let part = |material, vertices| MaterialPart { material, vertices };
        assert_eq!(parts, [part(1, 0..6), part(2, 6..12), part(0, 12..18)]);
    }
}
