//! A fingerprint of what light can meet.

use bytemuck::cast_slice;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use xxhash_rust::xxh3::Xxh3Default;

use crate::{AlphaMode, Material, Scene, TextureSlot};

impl Scene {
    /// 64-bit xxHash (XXH3) of geometry, materials and textures; names, lights, cameras and warnings do not
    /// count. Equal scenes have equal hashes on every machine.
    pub fn content_hash(&self) -> u64 {
        let mut hash = ContentHash(Xxh3Default::new());
        hash.bytes(cast_slice::<Vec3, u8>(&self.positions));
        hash.bytes(cast_slice::<Vec3, u8>(&self.normals));
        hash.bytes(cast_slice::<Vec4, u8>(&self.tangents));
        hash.bytes(cast_slice::<Vec2, u8>(&self.uv0));
        hash.bytes(cast_slice::<Vec2, u8>(&self.uv1));
        hash.bytes(cast_slice::<[u32; 3], u8>(&self.triangles));
        hash.bytes(cast_slice::<u32, u8>(&self.triangle_material));
        for material in &self.materials {
            hash.material(material);
        }
        for texture in &self.textures {
            hash.words(&[texture.width, texture.height]);
            hash.bytes(&texture.rgba8);
        }
        hash.0.digest()
    }
}

struct ContentHash(Xxh3Default);

impl ContentHash {
    /// Bytes after their length, so that neighbouring arrays cannot be confused.
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    fn words(&mut self, words: &[u32]) {
        self.bytes(cast_slice(words));
    }

    fn numbers(&mut self, numbers: &[f32]) {
        self.bytes(cast_slice(numbers));
    }

    fn material(&mut self, material: &Material) {
        let cutoff = match material.alpha_mode {
            AlphaMode::Opaque => -1.0,
            AlphaMode::Mask { cutoff } => cutoff,
        };
        self.numbers(&material.base_color.to_array());
        self.numbers(&material.emission.to_array());
        self.numbers(&[material.metallic, material.roughness, material.normal_scale, cutoff]);
        self.words(&[u32::from(material.double_sided)]);
        for slot in material.texture_slots() {
            self.slot(slot);
        }
    }

    fn slot(&mut self, slot: Option<TextureSlot>) {
        match slot {
            Some(slot) => self.words(&[slot.texture, slot.tex_coord]),
            None => self.words(&[]),
        }
    }
}
