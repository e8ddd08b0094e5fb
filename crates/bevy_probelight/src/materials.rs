//! The scene's materials and textures as Bevy's.

use std::collections::BTreeMap;

use bevy::asset::{Handle, RenderAssetUsages};
use bevy::color::{Color, LinearRgba};
use bevy::image::{Image, ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::material::AlphaMode;
use bevy::pbr::StandardMaterial;
use bevy::render::render_resource::{Extent3d, Face, TextureDimension, TextureFormat};
use probelight_scene::{AlphaMode as SceneAlphaMode, Scene, TextureSlot};

use crate::mipmaps::with_smaller_levels;
use crate::scene::AssetSink;

/// Makes the materials of a scene; each texture becomes an image once, or twice if it is read both as colour and as data.
pub(crate) struct MaterialMaker<'a> {
    scene: &'a Scene,
    images: BTreeMap<(u32, bool), Handle<Image>>,
}

impl<'a> MaterialMaker<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self { scene, images: BTreeMap::new() }
    }

    /// The material of that number.
    pub(crate) fn make(&mut self, index: usize, sink: &mut impl AssetSink) -> StandardMaterial {
        let material = &self.scene.materials[index];
        let [r, g, b, a] = material.base_color.to_array();
        let [er, eg, eb] = material.emission.to_array();
        let mut image = |slot: Option<TextureSlot>, is_srgb| Some(self.image(slot?.texture, is_srgb, sink));
        StandardMaterial {
            base_color: Color::linear_rgba(r, g, b, a),
            base_color_texture: image(material.base_color_texture, true),
            emissive: LinearRgba::rgb(er, eg, eb),
            emissive_exposure_weight: 1.0,
            emissive_texture: image(material.emissive_texture, true),
            metallic: material.metallic,
            perceptual_roughness: material.roughness,
            metallic_roughness_texture: image(material.metallic_roughness_texture, false),
            normal_map_texture: image(material.normal_texture, false),
            occlusion_texture: image(material.occlusion_texture, false),
            alpha_mode: match material.alpha_mode {
                SceneAlphaMode::Opaque => AlphaMode::Opaque,
                SceneAlphaMode::Mask { cutoff } => AlphaMode::Mask(cutoff),
            },
            // Backs that can be seen are triangles of their own.
            double_sided: false,
            cull_mode: Some(Face::Back),
            ..StandardMaterial::default()
        }
    }

    fn image(&mut self, texture: u32, is_srgb: bool, sink: &mut impl AssetSink) -> Handle<Image> {
        let scene = self.scene;
        let make = || {
            let label = format!("Texture{texture}{}", if is_srgb { "" } else { "Linear" });
            sink.image(label, new_image(&scene.textures[texture as usize], is_srgb))
        };
        self.images.entry((texture, is_srgb)).or_insert_with(make).clone()
    }
}

fn new_image(texture: &probelight_scene::Texture, is_srgb: bool) -> Image {
    let size = Extent3d { width: texture.width, height: texture.height, depth_or_array_layers: 1 };
    let format = if is_srgb { TextureFormat::Rgba8UnormSrgb } else { TextureFormat::Rgba8Unorm };
    let (bytes, levels) = with_smaller_levels(texture.width, texture.height, &texture.rgba8, is_srgb);
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::default());
    image.texture_descriptor.mip_level_count = levels;
    image.data = Some(bytes);
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 8,
        ..ImageSamplerDescriptor::default()
    });
    image
}
