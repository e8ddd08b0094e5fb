//! Where in the lightmap the light of each triangle lies.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::Vec2;

/// Where the light of each triangle lies in the lightmap.
///
/// The lightmap is a stack of pages, layers of `width × page_height` texels. Texel (x, y) of page p has the index
/// `(p · page_height + y) · width + x` and its centre at (x + ½, y + ½). As the pages lie one behind the other, they are
/// also one image of `width × height` texels; corners of faces are in its coordinates. No face reaches from one page
/// to another.
#[derive(Clone, Debug, Default)]
pub struct LightmapLayout {
    /// Width, texels.
    pub width: u32,
    /// Height of all pages together, texels.
    pub height: u32,
    /// Number of pages.
    pub pages: u32,
    /// Lightmap faces: the front face of triangle t is `faces[t]`, which may be [unlit](LightmapFace::is_lit);
    /// back faces with light of their own follow.
    pub faces: Vec<LightmapFace>,
    /// Per triangle the index of its back face in `faces`, or [`crate::NONE`].
    pub back_faces: Vec<u32>,
    /// Texels without a receiver that bilinear lookups touch: (texel, texel to copy from), the source always
    /// a receiver of the same chart.
    pub dilation: Vec<[u32; 2]>,
}

/// Lightmap coordinates of a triangle's three corners, in texels of the image of all pages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightmapFace {
    /// Corner coordinates, in the order of the triangle's corners.
    pub corners: [Vec2; 3],
}

impl LightmapLayout {
    /// Height of each page, texels.
    pub fn page_height(&self) -> u32 {
        self.height / self.pages.max(1)
    }

    /// The face of one side of a triangle; `None` if that side has no light of its own.
    #[inline]
    pub fn face(&self, triangle: u32, is_back_face: bool) -> Option<&LightmapFace> {
        let face = if is_back_face { *self.back_faces.get(triangle as usize)? } else { triangle };
        self.faces.get(face as usize).filter(|face| face.is_lit())
    }

    /// Where the light of one side of a triangle lies, texels, at barycentric weights of its second and third
    /// corner; `None` if that side has no light of its own.
    #[inline]
    pub fn position(&self, triangle: u32, is_back_face: bool, barycentric: Vec2) -> Option<Vec2> {
        Some(self.face(triangle, is_back_face)?.position(barycentric))
    }

    /// The texel at [`position`](Self::position), if there is one.
    #[inline]
    pub fn texel(&self, triangle: u32, is_back_face: bool, barycentric: Vec2) -> Option<u32> {
        Some(self.texel_at(self.position(triangle, is_back_face, barycentric)?))
    }

    /// The texel at a position, texels.
    #[inline]
    pub fn texel_at(&self, position: Vec2) -> u32 {
        let position = position.max(Vec2::ZERO);
        let (x, y) = (position.x as u32, position.y as u32);
        y.min(self.height.saturating_sub(1)) * self.width + x.min(self.width.saturating_sub(1))
    }
}

impl LightmapFace {
    /// Whether the face has light of its own. The corners of unlit faces (the insides of solids) are all zero.
    #[inline]
    pub fn is_lit(&self) -> bool {
        self.corners != [Vec2::ZERO; 3]
    }

    /// Lightmap position at barycentric weights of the second and third corner, texels.
    #[inline]
    pub fn position(&self, barycentric: Vec2) -> Vec2 {
        let [a, b, c] = self.corners;
        a + (b - a) * barycentric.x + (c - a) * barycentric.y
    }

    /// Points of a regular grid that lie on the face, so many along the edge of a texel: position in the lightmap, texels, and
    /// barycentric weights of the second and third corner.
    pub fn points(&self, per_edge: u32) -> impl Iterator<Item = (Vec2, Vec2)> {
        let [a, b, c] = self.corners;
        let (scale, ab, ac) = (per_edge as f32, b - a, c - a);
        let low = (a.min(b).min(c) * scale).floor();
        let high = (a.max(b).max(c) * scale).ceil();
        let row = move |y: u32| {
            (low.x as u32..high.x as u32).map(move |x| (Vec2::new(x as f32, y as f32) + 0.5) / scale)
        };
        (low.y as u32..high.y as u32).flat_map(row).filter_map(move |position| {
            let from_a = position - a;
            let weights = Vec2::new(from_a.perp_dot(ac), ab.perp_dot(from_a)) / ab.perp_dot(ac);
            (weights.min_element() >= 0.0 && weights.element_sum() <= 1.0).then_some((position, weights))
        })
    }

    /// Area in the lightmap, texels.
    pub fn area(&self) -> f32 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).perp_dot(c - a).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_cover_a_face_evenly() {
        let face = LightmapFace { corners: [Vec2::new(1.2, 3.4), Vec2::new(7.9, 4.0), Vec2::new(2.0, 9.7)] };
        let points: Vec<_> = face.points(8).collect();
        assert!((points.len() as f32 / 64.0 / face.area() - 1.0).abs() < 0.01, "{}", points.len());
        for (position, weights) in points {
            assert!(face.position(weights).abs_diff_eq(position, 1e-4));
        }
        assert_eq!(LightmapFace::default().points(8).count(), 0);
    }
}
