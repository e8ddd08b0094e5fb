//! A colour for each cluster, or for each receiver, at the texels of its receivers.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;

/// Where there is no receiver.
const NOWHERE: [u8; 4] = [60, 60, 60, 255];

/// One texel per lightmap texel.
pub(super) fn texture(device: &wgpu::Device, baked: &BakedScene) -> wgpu::Texture {
    let (width, height) = (baked.lightmap.width.max(1), baked.lightmap.height.max(1));
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("cluster colours"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Gives each of the lightmap's receivers a colour, linear, 0 to 1: `color(cluster, receiver)`, both counted from 0.
pub(super) fn write(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    baked: &BakedScene,
    color: impl Fn(u32, u32) -> Vec3,
) {
    let mut texels = vec![NOWHERE; texture.width() as usize * texture.height() as usize];
    for (cluster, receiver, texel) in baked.receivers_with_texels() {
        let [r, g, b] = color(cluster, receiver).to_array().map(|c| (c * 255.0) as u8);
        texels[texel as usize] = [r, g, b, 255];
    }
    for [texel, source] in &baked.lightmap.dilation {
        texels[*texel as usize] = texels[*source as usize];
    }
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * texture.width()),
        rows_per_image: None,
    };
    queue.write_texture(texture.as_image_copy(), texels.as_flattened(), layout, texture.size());
}

/// Hues a golden section apart: neighbours in the order are far from each other in colour.
pub(super) fn color_of_number(number: u32) -> Vec3 {
    let hue = (number as f32 * 0.618_034).fract();
    let channel = |shift: f32| 0.5 + 0.5 * (std::f32::consts::TAU * (hue + shift)).cos();
    Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)) * 0.8 + 0.1
}
