//! Metallic-roughness materials.

use std::collections::HashMap;

use gltf::Document;
use gltf::texture::{TextureTransform, WrappingMode};
use probelight_math::glam::{Mat2, Vec2, Vec3, Vec4};
use serde_json::Value;

use super::resources::Resources;
use super::{Reason, Warnings, images};
use crate::{AlphaMode, Material, Texture, TextureSlot};

/// Most bytes of decoded textures in one scene.
const MAX_TEXTURE_BYTES: u64 = 4 << 30;

const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

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

    /// Whether no point of the material's surfaces can pass its alpha test: a texture only lowers alpha.
    pub(super) fn lets_everything_through(&self, material: u32) -> bool {
        let material = &self.materials[material as usize];
        matches!(material.alpha_mode, AlphaMode::Mask { cutoff } if material.base_color.w < cutoff)
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

    /// First scale, then rotation (counter-clockwise in images whose v points down), then offset.
    fn new(scale: Vec2, rotation: f32, offset: Vec2) -> Self {
        let (sin, cos) = rotation.sin_cos();
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        Self { matrix: rotation * Mat2::from_diagonal(scale), offset }
    }

    fn from_extension(extension: &TextureTransform<'_>) -> Self {
        Self::new(extension.scale().into(), extension.rotation(), extension.offset().into())
    }

    /// Missing and malformed members have their default value.
    fn from_json(extension: &Value) -> Self {
        let number = |json: &Value| json.as_f64().map(|number| number as f32);
        let vector = |name: &str, default: Vec2| {
            let member = |i: usize| extension.get(name)?.get(i).and_then(number);
            Vec2::new(member(0).unwrap_or(default.x), member(1).unwrap_or(default.y))
        };
        let rotation = extension.get("rotation").and_then(number).unwrap_or(0.0);
        Self::new(vector("scale", Vec2::ONE), rotation, vector("offset", Vec2::ZERO))
    }

    pub(super) fn apply(&self, uv: Vec2) -> Vec2 {
        self.matrix * uv + self.offset
    }
}

/// Refuses numbers that no viewer could make sense of: an exponent too large for a number becomes infinite.
fn check_factors(material: &Material) -> Result<(), Reason> {
    let cutoff = match material.alpha_mode {
        AlphaMode::Opaque => 0.0,
        AlphaMode::Mask { cutoff } => cutoff,
    };
    let scalars = [material.metallic, material.roughness, material.normal_scale, cutoff];
    let is_finite = material.base_color.is_finite()
        && material.emission.is_finite()
        && scalars.iter().all(|factor| factor.is_finite());
    if is_finite {
        Ok(())
    } else {
        Err("it has a factor that is not finite; correct it and export again".into())
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
    fn from_info(info: &gltf::texture::Info<'a>) -> Self {
        let transform = info.texture_transform();
        Self {
            texture: info.texture(),
            tex_coord: transform.as_ref().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord()),
            transform: transform.map_or(UvTransform::IDENTITY, |t| UvTransform::from_extension(&t)),
        }
    }

    /// Normal and occlusion textures, whose transform the crate leaves as JSON.
    fn from_json(texture: gltf::Texture<'a>, tex_coord: u32, extension: Option<&Value>) -> Self {
        let tex_coord = extension
            .and_then(|json| json.get("texCoord"))
            .and_then(Value::as_u64)
            .map_or(tex_coord, |set| u32::try_from(set).unwrap_or(u32::MAX));
        Self {
            texture,
            tex_coord,
            transform: extension.map_or(UvTransform::IDENTITY, UvTransform::from_json),
        }
    }

    fn normal(info: &gltf::material::NormalTexture<'a>) -> Self {
        Self::from_json(info.texture(), info.tex_coord(), info.extension_value(TEXTURE_TRANSFORM))
    }

    fn occlusion(info: &gltf::material::OcclusionTexture<'a>) -> Self {
        Self::from_json(info.texture(), info.tex_coord(), info.extension_value(TEXTURE_TRANSFORM))
    }
}

/// The transform that a material's textures agree on, for each set of texture coordinates.
type AgreedTransforms = [Option<UvTransform>; 2];

impl Importer<'_> {
    fn material(&mut self, source: &gltf::Material<'_>) -> Result<(Material, [UvTransform; 2]), Reason> {
        let pbr = source.pbr_metallic_roughness();
        let mut transforms = AgreedTransforms::default();
        let mut slot = |from: Option<SlotSource<'_>>| self.slot(from, &mut transforms);
        let mut material = Material {
            name: source.name().unwrap_or_default().into(),
            base_color: Vec4::from(pbr.base_color_factor()),
            base_color_texture: slot(pbr.base_color_texture().map(|t| SlotSource::from_info(&t)))?,
            metallic: pbr.metallic_factor(),
            roughness: pbr.roughness_factor(),
            metallic_roughness_texture: slot(
                pbr.metallic_roughness_texture().map(|t| SlotSource::from_info(&t)),
            )?,
            normal_texture: slot(source.normal_texture().map(|t| SlotSource::normal(&t)))?,
            normal_scale: source.normal_texture().map_or(1.0, |t| t.scale()),
            occlusion_texture: slot(source.occlusion_texture().map(|t| SlotSource::occlusion(&t)))?,
            emission: Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0),
            emissive_texture: slot(source.emissive_texture().map(|t| SlotSource::from_info(&t)))?,
            alpha_mode: self.alpha_mode(source),
            double_sided: source.double_sided(),
        };
        check_factors(&material)
            .map_err(|reason| format!("materials[{}]: {reason}", source.index().unwrap_or_default()))?;
        self.clamp_factors(&mut material);
        Ok((material, transforms.map(|transform| transform.unwrap_or(UvTransform::IDENTITY))))
    }

    /// Keeps factors in the range the specification gives them: an albedo above 1 would create energy.
    fn clamp_factors(&mut self, material: &mut Material) {
        let given = material.clone();
        material.base_color = given.base_color.clamp(Vec4::ZERO, Vec4::ONE);
        material.metallic = given.metallic.clamp(0.0, 1.0);
        material.roughness = given.roughness.clamp(0.0, 1.0);
        material.emission = given.emission.clamp(Vec3::ZERO, Vec3::MAX);
        if let (AlphaMode::Mask { cutoff }, AlphaMode::Mask { cutoff: given }) =
            (&mut material.alpha_mode, given.alpha_mode)
        {
            *cutoff = given.max(0.0);
        }
        if *material != given {
            self.warnings
                .add("materials with factors out of range, clamped as viewers do; check their colours", 1);
        }
    }

    fn alpha_mode(&mut self, source: &gltf::Material<'_>) -> AlphaMode {
        match source.alpha_mode() {
            gltf::material::AlphaMode::Opaque => AlphaMode::Opaque,
            gltf::material::AlphaMode::Mask => {
                AlphaMode::Mask { cutoff: source.alpha_cutoff().unwrap_or(0.5) }
            }
            gltf::material::AlphaMode::Blend => {
                self.warnings.add(
                    "alpha-blended materials, cut out at alpha 0.5 instead; give them an alpha mask to choose where",
                    1,
                );
                AlphaMode::Mask { cutoff: 0.5 }
            }
        }
    }

    fn slot(
        &mut self,
        source: Option<SlotSource<'_>>,
        transforms: &mut AgreedTransforms,
    ) -> Result<Option<TextureSlot>, Reason> {
        let Some(source) = source else { return Ok(None) };
        // Other crates of an app may have made it an option.
        let image: Option<gltf::Image<'_>> = source.texture.source().into();
        let Some(image) = image.filter(images::is_there) else {
            self.warnings
                .add("textures without a PNG, JPEG or WebP image, left out; convert their images", 1);
            return Ok(None);
        };
        let Some(transform) = transforms.get_mut(source.tex_coord as usize) else {
            self.warnings.add(
                "textures with a third or later set of texture coordinates, left out; move them to the first two",
                1,
            );
            return Ok(None);
        };
        if *transform.get_or_insert(source.transform) != source.transform {
            self.warnings.add(
                "texture transforms that differ within a material, taken from its first texture; apply them to its images",
                1,
            );
        }
        let sampler = source.texture.sampler();
        if [sampler.wrap_s(), sampler.wrap_t()].iter().any(|mode| *mode != WrappingMode::Repeat) {
            self.warnings.add(
                "textures that clamp or mirror, repeated instead; keep their coordinates within 0 to 1",
                1,
            );
        }
        let texture = self.texture(&image)?;
        Ok(Some(TextureSlot { texture, tex_coord: source.tex_coord }))
    }

    /// Decodes an image the first time it is used.
    fn texture(&mut self, image: &gltf::Image<'_>) -> Result<u32, Reason> {
        if let Some(texture) = self.texture_of_image.get(&image.index()) {
            return Ok(*texture);
        }
        let held = self.textures.iter().map(|texture| texture.rgba8.len() as u64).sum::<u64>();
        self.textures.push(images::decode_image(image, self.resources, MAX_TEXTURE_BYTES - held)?);
        let texture = self.textures.len() as u32 - 1;
        self.texture_of_image.insert(image.index(), texture);
        Ok(texture)
    }
}
