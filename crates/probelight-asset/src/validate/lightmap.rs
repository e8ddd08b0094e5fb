//! The lightmap: a size that fits its use, texels that are written once.

use probelight_math::glam::Vec2;

use crate::{BakedParts, NONE};

/// Lightmaps up to this size may be empty: 4 Mi texels.
const FREE_LIGHTMAP_TEXELS: u64 = 1 << 22;

/// A larger lightmap must use at least one texel in this many, so that a small file cannot demand a huge
/// image.
const MAX_TEXELS_PER_USED_TEXEL: u64 = 64;

impl BakedParts {
    /// Number of lightmap texels.
    pub(super) fn texel_count(&self) -> u64 {
        u64::from(self.lightmap.width) * u64::from(self.lightmap.height)
    }

    pub(super) fn check_lightmap(&self) -> Result<(), String> {
        let map = &self.lightmap;
        let (texels, triangles) = (self.texel_count(), self.scene.triangles.len());
        let used = (self.receiver_texels.len() + map.dilation.len()) as u64;
        ensure!(
            texels > 0
                && texels < u64::from(NONE)
                && texels <= FREE_LIGHTMAP_TEXELS.max(used * MAX_TEXELS_PER_USED_TEXEL),
            "a lightmap of {} × {} texels for {used} used ones",
            map.width,
            map.height
        );
        ensure!(
            map.pages > 0 && map.height.is_multiple_of(map.pages),
            "{} lightmap pages in a height of {} texels",
            map.pages,
            map.height
        );
        ensure!(map.faces.len() >= triangles, "{} lit faces for {triangles} triangles", map.faces.len());
        ensure!(
            map.back_faces.len() == triangles,
            "{} back faces for {triangles} triangles",
            map.back_faces.len()
        );
        for (t, face) in map.back_faces.iter().enumerate() {
            ensure!(
                *face == NONE || (triangles..map.faces.len()).contains(&(*face as usize)),
                "triangle {t} has the back face {face}, which does not exist"
            );
        }
        self.check_faces()
    }

    /// Faces lie in the lightmap, each in one page.
    fn check_faces(&self) -> Result<(), String> {
        let map = &self.lightmap;
        let size = Vec2::new(map.width as f32, map.height as f32);
        let page_height = map.page_height() as f32;
        for (f, face) in map.faces.iter().enumerate() {
            let inside = |corner: &Vec2| corner.cmpge(Vec2::ZERO).all() && corner.cmple(size).all();
            ensure!(face.corners.iter().all(inside), "lit face {f} leaves the lightmap");
            let [a, b, c] = face.corners.map(|corner| corner.y);
            let page_top = (a.min(b).min(c) / page_height).floor() * page_height;
            ensure!(a.max(b).max(c) <= page_top + page_height, "lit face {f} leaves its page");
        }
        Ok(())
    }

    /// No texel is written twice, and dilation copies from receivers. Relies on the lightmap's size being
    /// sane.
    pub(super) fn check_texels(&self) -> Result<(), String> {
        let texels = self.texel_count();
        let mut is_receiver = vec![false; texels as usize];
        for (r, texel) in self.receiver_texels.iter().enumerate() {
            ensure!(u64::from(*texel) < texels, "receiver {r} has texel {texel} of {texels}");
            let taken = std::mem::replace(&mut is_receiver[*texel as usize], true);
            ensure!(!taken, "receiver {r} shares texel {texel} with another");
        }
        let mut is_dilated = vec![false; texels as usize];
        for (d, [texel, source]) in self.lightmap.dilation.iter().enumerate() {
            ensure!(
                u64::from(*texel.max(source)) < texels,
                "dilation {d} copies texel {source} to {texel} of {texels}"
            );
            ensure!(is_receiver[*source as usize], "dilation {d} copies texel {source}, not a receiver's");
            ensure!(!is_receiver[*texel as usize], "dilation {d} overwrites texel {texel} of a receiver");
            let taken = std::mem::replace(&mut is_dilated[*texel as usize], true);
            ensure!(!taken, "dilation {d} writes texel {texel} a second time");
        }
        Ok(())
    }
}
