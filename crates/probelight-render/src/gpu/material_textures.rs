//! Textures with all their mip levels.

use std::collections::HashMap;

use probelight_math::color::{linear_from_srgb, srgb_from_linear};
use probelight_scene::{Texture, TextureSlot};
use wgpu::util::DeviceExt;

/// What the bytes of a texture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Encoding {
    /// Colour is sRGB-encoded, alpha linear.
    Srgb,
    /// Numbers.
    Linear,
}

/// Textures that were uploaded already.
pub(super) struct MaterialTextures<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    textures: &'a [Texture],
    uploaded: HashMap<(Option<u32>, Encoding), wgpu::TextureView>,
}

impl<'a> MaterialTextures<'a> {
    pub(super) fn new(device: &'a wgpu::Device, queue: &'a wgpu::Queue, textures: &'a [Texture]) -> Self {
        Self { device, queue, textures, uploaded: HashMap::new() }
    }

    /// The texture of a slot, or one white texel.
    pub(super) fn view(&mut self, slot: Option<TextureSlot>, encoding: Encoding) -> wgpu::TextureView {
        let index = slot.map(|slot| slot.texture);
        let upload = || {
            let white = Texture { name: String::new(), width: 1, height: 1, rgba8: vec![255; 4].into() };
            let texture = index.map_or(&white, |index| &self.textures[index as usize]);
            upload(self.device, self.queue, texture, encoding)
        };
        self.uploaded.entry((index, encoding)).or_insert_with(upload).clone()
    }

    /// The normal map of a slot, or one texel without bumps.
    pub(super) fn normal_view(&mut self, slot: Option<TextureSlot>) -> wgpu::TextureView {
        if slot.is_some() {
            return self.view(slot, Encoding::Linear);
        }
        let flat = Texture { name: String::new(), width: 1, height: 1, rgba8: [128, 128, 255, 255].into() };
        upload(self.device, self.queue, &flat, Encoding::Linear)
    }
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &Texture,
    encoding: Encoding,
) -> wgpu::TextureView {
    let mut levels = mip_levels(texture, encoding);
    // What is larger than a GPU must be able to hold starts at a coarser level.
    let limit = device.limits().max_texture_dimension_2d;
    let too_large = levels.iter().take_while(|level| level.width.max(level.height) > limit).count();
    levels.drain(..too_large);
    let size = wgpu::Extent3d { width: levels[0].width, height: levels[0].height, depth_or_array_layers: 1 };
    let bytes: Vec<u8> = levels.iter().flat_map(|level| level.rgba8.iter().copied()).collect();
    let descriptor = wgpu::TextureDescriptor {
        label: Some(&texture.name),
        size,
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: match encoding {
            Encoding::Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
            Encoding::Linear => wgpu::TextureFormat::Rgba8Unorm,
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, &bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The texture and its halves down to one texel; means are taken of linear values.
fn mip_levels(texture: &Texture, encoding: Encoding) -> Vec<Texture> {
    let decode: [f32; 256] = std::array::from_fn(|code| {
        let value = code as f32 / 255.0;
        if encoding == Encoding::Srgb { linear_from_srgb(value) } else { value }
    });
    let mut levels = vec![texture.clone()];
    while let Some(finer) = levels.last().filter(|level| level.width.max(level.height) > 1) {
        levels.push(halved(finer, encoding, &decode));
    }
    levels
}

fn halved(finer: &Texture, encoding: Encoding, decode: &[f32; 256]) -> Texture {
    let (width, height) = ((finer.width / 2).max(1), (finer.height / 2).max(1));
    let texel = |x: u32, y: u32, channel: usize| {
        let (x, y) = (x.min(finer.width - 1) as usize, y.min(finer.height - 1) as usize);
        let code = finer.rgba8[(y * finer.width as usize + x) * 4 + channel];
        if channel == 3 { f32::from(code) / 255.0 } else { decode[usize::from(code)] }
    };
    let mut rgba8 = Vec::with_capacity(width as usize * height as usize * 4);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (2 * y, 2 * x))) {
        for channel in 0..4 {
            let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            let mean = corners.iter().map(|(x, y)| texel(*x, *y, channel)).sum::<f32>() / 4.0;
            let is_encoded = encoding == Encoding::Srgb && channel < 3;
            let value = if is_encoded { srgb_from_linear(mean) } else { mean };
            rgba8.push((value * 255.0).round() as u8);
        }
    }
    Texture { name: String::new(), width, height, rgba8: rgba8.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_down_to_one_texel_and_keep_the_mean() {
        let rgba8 =
            (0..5 * 2).flat_map(|i| if i % 2 == 0 { [255, 0, 10, 255] } else { [0, 0, 10, 1] }).collect();
        let texture = Texture { name: String::new(), width: 5, height: 2, rgba8 };
        let levels = mip_levels(&texture, Encoding::Srgb);
        let sizes: Vec<_> = levels.iter().map(|level| (level.width, level.height)).collect();
        assert_eq!(sizes, [(5, 2), (2, 1), (1, 1)]);
        // Half of the light, which is encoded as 188, not as half of 255.
        assert_eq!(*levels[2].rgba8, [188, 0, 10, 128]);
        assert_eq!(mip_levels(&texture, Encoding::Linear)[2].rgba8[0], 128);
    }
}
