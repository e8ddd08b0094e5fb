//! What the vertices of the scene's triangles carry besides their positions.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, LightmapFace, NONE};
use probelight_math::glam::{Vec2, Vec4};
use probelight_runtime::gpu::filled_buffer::filled_buffer;
use probelight_runtime::gpu::{GpuError, SceneGeometry};
use probelight_scene::Scene;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct CornerRecord {
    /// Texture coordinates of both sets.
    uv: [f32; 4], //                 0
    /// Vertex normal, as a fraction of 32767.
    normal: [i16; 4], //            16
    /// Tangent and the bitangent's sign, as a fraction of 32767.
    tangent: [i16; 4], //           24
    /// The triangle's own normal, as a fraction of 32767.
    face_normal: [i16; 4], //       32
}

/// How the vertex buffer is laid out, in slot 1 after the positions.
pub(super) const LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<CornerRecord>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        1 => Float32x4,
        2 => Snorm16x4,
        3 => Snorm16x4,
        4 => Snorm16x4,
    ],
};

/// The vertex buffer, in the order of the geometry's triangles.
///
/// # Errors
/// [`GpuError::TooLarge`] if the device cannot hold it.
pub(super) fn vertex_buffer(
    device: &wgpu::Device,
    scene: &Scene,
    geometry: &SceneGeometry,
) -> Result<wgpu::Buffer, GpuError> {
    let corners: Vec<CornerRecord> =
        geometry.triangle_order.iter().flat_map(|triangle| corners_of(scene, *triangle)).collect();
    let bytes = bytemuck::cast_slice(&corners);
    filled_buffer(device, "attributes of triangles", bytes, wgpu::BufferUsages::VERTEX)
}

fn corners_of(scene: &Scene, triangle: u32) -> [CornerRecord; 3] {
    let face_normal = snorm16(scene.geometric_normal(triangle as usize).extend(0.0));
    std::array::from_fn(|corner| {
        let vertex = scene.triangles[triangle as usize][corner] as usize;
        let uv0 = scene.uv0[vertex];
        let uv1 = scene.uv1.get(vertex).copied().unwrap_or(uv0);
        CornerRecord {
            uv: [uv0.x, uv0.y, uv1.x, uv1.y],
            normal: snorm16(scene.normals[vertex].extend(0.0)),
            tangent: snorm16(scene.tangents[vertex]),
            face_normal,
        }
    })
}

/// Corners of each triangle's front and back face in the lightmap, texels, in the order of the geometry's triangles;
/// −1 without light of its own.
///
/// # Errors
/// [`GpuError::TooLarge`] if shaders cannot bind it: from 2.8 million triangles on with WebGPU's guaranteed limits.
pub(super) fn lightmap_faces(
    device: &wgpu::Device,
    baked: &BakedScene,
    geometry: &SceneGeometry,
) -> Result<wgpu::Buffer, GpuError> {
    let faces_of = |triangle: &u32| {
        let triangle = *triangle as usize;
        let back_face = baked.lightmap.back_faces.get(triangle).copied().unwrap_or(NONE);
        [triangle, back_face as usize].map(|face| positions(baked.lightmap.faces.get(face)))
    };
    let faces: Vec<[[Vec2; 3]; 2]> = geometry.triangle_order.iter().map(faces_of).collect();
    let bytes = bytemuck::cast_slice(faces.as_flattened().as_flattened());
    filled_buffer(device, "lightmap faces", bytes, wgpu::BufferUsages::STORAGE)
}

fn positions(face: Option<&LightmapFace>) -> [Vec2; 3] {
    face.filter(|face| face.is_lit()).map_or([Vec2::NEG_ONE; 3], |face| face.corners)
}

fn snorm16(value: Vec4) -> [i16; 4] {
    (value.clamp(Vec4::NEG_ONE, Vec4::ONE) * 32767.0).to_array().map(|v| v.round() as i16)
}
