//! What a material shows of where its light comes from.

use probelight_scene::{Material, Scene, Texture};

/// Roughness of the glossiest dielectric that counts as matt: its highlight is at most 2 % as bright as what a white
/// diffuse surface reflects of the same light, 0.04 / (4 α²) with α the square of the roughness.
const MATT_ROUGHNESS: f32 = 0.85;

/// How a surface takes up soft light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Finish {
    /// Evenly: the lightmap says all.
    Matt,
    /// By the bumps of a normal map.
    Bumpy,
    /// With highlights, and by bumps if it has any.
    Glossy,
}

impl Finish {
    /// Those of all materials.
    pub(super) fn of_all(scene: &Scene) -> Vec<Self> {
        scene.materials.iter().map(|material| Self::of(material, &scene.textures)).collect()
    }

    fn of(material: &Material, textures: &[Texture]) -> Self {
        let slot = material.metallic_roughness_texture;
        let texels =
            slot.and_then(|slot| textures.get(slot.texture as usize)).map(|it| it.rgba8.as_chunks().0);
        let is_matt = |[_, roughness, metallic, _]: &[u8; 4]| {
            let roughness = material.roughness * f32::from(*roughness) / 255.0;
            roughness >= MATT_ROUGHNESS && material.metallic * f32::from(*metallic) == 0.0
        };
        if !texels.unwrap_or(&[[255; 4]]).iter().all(is_matt) {
            return Self::Glossy;
        }
        if material.normal_texture.is_some() { Self::Bumpy } else { Self::Matt }
    }
}

#[cfg(test)]
mod tests {
    use probelight_scene::TextureSlot;

    use super::*;

    const SLOT: Option<TextureSlot> = Some(TextureSlot { texture: 0, tex_coord: 0 });

    #[test]
    fn a_single_glossy_texel_makes_a_material_glossy() {
        let texture = |rgba8: &[u8]| {
            let width = rgba8.len() as u32 / 4;
            [Texture { name: String::new(), width, height: 1, rgba8: rgba8.into() }]
        };
        let (rough, polished, metal) = ([9, 255, 0, 255], [9, 100, 0, 255], [9, 255, 1, 255]);
        let plain = Material { metallic: 0.0, ..Material::default() };
        let textured = Material { metallic_roughness_texture: SLOT, ..Material::default() };
        let bumpy = |material: &Material| Material { normal_texture: SLOT, ..material.clone() };
        let of =
            |material: &Material, texels: [[u8; 4]; 2]| Finish::of(material, &texture(texels.as_flattened()));
        assert_eq!(of(&plain, [polished; 2]), Finish::Matt);
        assert_eq!(of(&bumpy(&plain), [polished; 2]), Finish::Bumpy);
        assert_eq!(of(&Material { roughness: 0.8, ..plain }, [rough; 2]), Finish::Glossy);
        assert_eq!(of(&Material::default(), [rough; 2]), Finish::Glossy, "glTF's default is metal");
        assert_eq!(of(&textured, [rough; 2]), Finish::Matt);
        assert_eq!(of(&bumpy(&textured), [rough; 2]), Finish::Bumpy);
        for glossy in [polished, metal] {
            assert_eq!(of(&bumpy(&textured), [rough, glossy]), Finish::Glossy);
        }
        assert_eq!(of(&Material { metallic: 0.0, ..textured }, [rough, metal]), Finish::Matt);
    }
}
