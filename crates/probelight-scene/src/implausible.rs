//! What is valid and probably not meant: surfaces too white to be real.

use probelight_math::glam::{Vec2, Vec3};

use crate::{Material, Scene, Texture};

/// Fresh snow reflects about 90 % of the light, the whitest paints a few percent more.
const LARGEST_REAL_ALBEDO: f32 = 0.95;

/// Places along each side of a texture at which its mean is estimated.
const SAMPLES_PER_SIDE: u32 = 64;

impl Scene {
    /// How many of the materials that are used reflect more than anything real.
    pub(crate) fn materials_too_white(&self) -> usize {
        let mut is_used = vec![false; self.materials.len()];
        self.triangle_material.iter().for_each(|material| is_used[*material as usize] = true);
        let used = self.materials.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        used.filter(|(material, _)| self.mean_albedo(material).max_element() > LARGEST_REAL_ALBEDO).count()
    }

    fn mean_albedo(&self, material: &Material) -> Vec3 {
        let factor = material.base_color.truncate();
        match material.base_color_texture {
            Some(slot) if factor.max_element() > LARGEST_REAL_ALBEDO => {
                factor * mean_color(&self.textures[slot.texture as usize])
            }
            _ => factor,
        }
    }
}

/// Mean linear colour of an sRGB texture, from places spread evenly over it.
fn mean_color(texture: &Texture) -> Vec3 {
    let [columns, rows] = [texture.width, texture.height].map(|side| side.min(SAMPLES_PER_SIDE));
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let color = |(column, row): (u32, u32)| {
        let uv = Vec2::new((column as f32 + 0.5) / columns as f32, (row as f32 + 0.5) / rows as f32);
        texture.sample_srgb(uv).truncate()
    };
    places.map(color).sum::<Vec3>() / (columns * rows) as f32
}
