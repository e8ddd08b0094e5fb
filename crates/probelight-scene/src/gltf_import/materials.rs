//! Metallic-roughness materials.

use std::collections::HashMap;

use gltf::Document;
use gltf::texture::{TextureTransform, WrappingMode};
use probelight_math::glam::{Mat2, Vec2, Vec3, Vec4};

use super::resources::Resources;
use super::{Reason, Warnings, images};
use crate::{AlphaMode, Material, Texture, TextureSlot};

/// Most bytes of decoded textures in one scene.
const MAX_TEXTURE_BYTES: usize = 4 << 30;

/// All materials of a document. The last one is glTF's default, for primitives without a material.
pub(super) struct Materials {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// For each material, the transform of its texture coordinates 0 and 1 (`KHR_texture_transform`).
    pub(super) uv_transforms: Vec<[UvTransform; 2]>,
}

impl Materials {
    /// The material's position in `materials`.
    pub(super) fn index_of(&self, material: &gltf::Material<'_>) -> u32 {
        material.index().unwrap_or(self.materials.len() - 1) as u32
    }
}

/// An affine map of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvTransform {
    matrix: Mat2,
    offset: Vec2,
}

impl UvTransform {
    const IDENTITY: Self = Self { matrix: Mat2::IDENTITY, offset: Vec2::ZERO };

    /// Offset, then rotation, then scale, as `KHR_texture_transform` orders them.
    fn new(transform: &TextureTransform<'_>) -> Self {
        let (sin, cos) = transform.rotation().sin_cos();
        let scale = Vec2::from(transform.scale());
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        Self { matrix: rotation * Mat2::from_diagonal(scale), offset: Vec2::from(transform.offset()) }
    }

    pub(super) fn apply(&self, uv: Vec2) -> Vec2 {
        self.matrix * uv + self.offset
    }
}

/// Converts all materials and decodes the images they use.
pub(super) fn import_materials(
    document: &Document,
    resources: &Resources<'_>,
    warnings: &mut Warnings,
) -> Result<Materials, Reason> {
    let mut importer =
        Importer { resources, warnings, textures: Vec::new(), texture_of_image: HashMap::new() };
    let mut materials = Vec::new();
    let mut uv_transforms = Vec::new();
    for material in document.materials() {
        let (material, transforms) = importer.material(&material)?;
        materials.push(material);
        uv_transforms.push(transforms);
    }
    materials.push(Material { name: "default".into(), ..Material::default() });
    uv_transforms.push([UvTransform::IDENTITY; 2]);
    Ok(Materials { materials, textures: importer.textures, uv_transforms })
}

struct Importer<'a> {
    resources: &'a Resources<'a>,
    warnings: &'a mut Warnings,
    textures: Vec<Texture>,
    texture_of_image: HashMap<usize, u32>,
}

/// One slot's reference to a texture.
struct SlotSource<'a> {
    texture: gltf::Texture<'a>,
    tex_coord: u32,
    transform: UvTransform,
}

impl<'a> SlotSource<'a> {
    fn new(info: &gltf::texture::Info<'a>) -> Self {
        let transform = info.texture_transform();
        Self {
            texture: info.texture(),
            tex_coord: transform.as_ref().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord()),
            transform: transform.map_or(UvTransform::IDENTITY, |t| UvTransform::new(&t)),
        }
    }
}

impl Importer<'_> {
    fn material(&mut self, source: &gltf::Material<'_>) -> Result<(Material, [UvTransform; 2]), Reason> {
        let pbr = source.pbr_metallic_roughness();
        let mut transforms = [None; 2];
        let base_color = pbr.base_color_texture().map(|info| SlotSource::new(&info));
        let metallic_roughness = pbr.metallic_roughness_texture().map(|info| SlotSource::new(&info));
        let emissive = source.emissive_texture().map(|info| SlotSource::new(&info));
        // The crate knows the transform of these two only as unparsed JSON.
        let normal = source.normal_texture();
        let normal_source = normal.as_ref().map(|info| SlotSource {
            texture: info.texture(),
            tex_coord: info.tex_coord(),
            transform: UvTransform::IDENTITY,
        });
        let occlusion = source.occlusion_texture().map(|info| SlotSource {
            texture: info.texture(),
            tex_coord: info.tex_coord(),
            transform: UvTransform::IDENTITY,
        });
        let material = Material {
            name: source.name().unwrap_or_default().into(),
            base_color: Vec4::from(pbr.base_color_factor()),
            base_color_texture: self.slot(base_color, &mut transforms)?,
            metallic: pbr.metallic_factor(),
            roughness: pbr.roughness_factor(),
            metallic_roughness_texture: self.slot(metallic_roughness, &mut transforms)?,
            normal_texture: self.slot(normal_source, &mut transforms)?,
            normal_scale: normal.map_or(1.0, |info| info.scale()),
            occlusion_texture: self.slot(occlusion, &mut transforms)?,
            emission: Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0),
            emissive_texture: self.slot(emissive, &mut transforms)?,
            alpha_mode: self.alpha_mode(source),
            double_sided: source.double_sided(),
        };
        Ok((material, transforms.map(|transform| transform.unwrap_or(UvTransform::IDENTITY))))
    }

    fn alpha_mode(&mut self, source: &gltf::Material<'_>) -> AlphaMode {
        match source.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => {
                AlphaMode::Mask { cutoff: source.alpha_cutoff().unwrap_or(0.5) }
            }
            gltf::material::AlphaMode::Blend => {
                self.warnings.add("alpha-blended materials, cut out at alpha 0.5 instead", 1);
                AlphaMode::Mask { cutoff: 0.5 }
            }
        }
    }

    fn slot(
        &mut self,
        source: Option<SlotSource<'_>>,
        transforms: &mut [Option<UvTransform>; 2],
    ) -> Result<Option<TextureSlot>, Reason> {
        let Some(source) = source else { return Ok(None) };
        let Some(image) = source.texture.source() else {
            self.warnings.add("textures without a PNG or JPEG image, left out", 1);
            return Ok(None);
        };
        let Some(transform) = transforms.get_mut(source.tex_coord as usize) else {
            self.warnings.add("textures with a third or later set of texture coordinates, left out", 1);
            return Ok(None);
        };
        if *transform.get_or_insert(source.transform) != source.transform {
            self.warnings
                .add("texture transforms that differ within a material, taken from its first texture", 1);
        }
        let sampler = source.texture.sampler();
        if [sampler.wrap_s(), sampler.wrap_t()].iter().any(|mode| *mode != WrappingMode::Repeat) {
            self.warnings.add("textures that clamp or mirror, repeated instead", 1);
        }
        let texture = self.texture(&image)?;
        Ok(Some(TextureSlot { texture, tex_coord: source.tex_coord }))
    }

    /// Decodes an image the first time it is used.
    fn texture(&mut self, image: &gltf::Image<'_>) -> Result<u32, Reason> {
        if let Some(texture) = self.texture_of_image.get(&image.index()) {
            return Ok(*texture);
        }
        self.textures.push(images::decode_image(image, self.resources)?);
        if self.textures.iter().map(|texture| texture.rgba8.len()).sum::<usize>() > MAX_TEXTURE_BYTES {
            return Err(format!("its textures decode to more than {} GiB", MAX_TEXTURE_BYTES >> 30));
        }
        let texture = self.textures.len() as u32 - 1;
        self.texture_of_image.insert(image.index(), texture);
        Ok(texture)
    }
}
