//! A colour for each cluster, at the texels of its receivers.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use wgpu::util::DeviceExt;

/// One texel per lightmap texel; grey where there is no receiver.
pub(super) fn texture_view(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    baked: &BakedScene,
) -> wgpu::TextureView {
    let (width, height) = (baked.lightmap.width.max(1), baked.lightmap.height.max(1));
    let descriptor = wgpu::TextureDescriptor {
        label: Some("cluster colours"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let texels = texels(baked, width as usize * height as usize);
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, texels.as_flattened());
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn texels(baked: &BakedScene, count: usize) -> Vec<[u8; 4]> {
    let mut texels = vec![[60, 60, 60, 255]; count];
    for (number, cluster) in (0..).zip(&baked.clusters) {
        for texel in baked.texels(cluster) {
            texels[*texel as usize] = color(number);
        }
    }
    for [texel, source] in &baked.lightmap.dilation {
        texels[*texel as usize] = texels[*source as usize];
    }
    texels
}

/// Hues a golden section apart: neighbours in the order are far from each other in colour.
fn color(cluster: u32) -> [u8; 4] {
    let hue = (cluster as f32 * 0.618_034).fract();
    let channel = |shift: f32| 0.5 + 0.5 * (std::f32::consts::TAU * (hue + shift)).cos();
    let rgb = Vec3::new(channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)) * 0.8 + 0.1;
    let [r, g, b] = rgb.to_array().map(|c| (c * 255.0) as u8);
    [r, g, b, 255]
}
