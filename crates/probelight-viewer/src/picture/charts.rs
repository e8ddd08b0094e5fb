//! Charts of the lightmap: triangles that are unwrapped in one piece.

use std::collections::HashMap;

use probelight_asset::{LightmapFace, LightmapLayout, NONE};
use probelight_math::glam::{UVec2, Vec2};

/// How far a chart's light reaches beyond its triangles, texels.
const REACH: f32 = 0.75;

/// Of each texel, the number of the chart that lies on it, or [`NONE`].
pub fn charts_of_texels(lightmap: &LightmapLayout) -> Vec<u32> {
    let faces: Vec<&LightmapFace> = lightmap.faces.iter().filter(|face| face.is_lit()).collect();
    let size = UVec2::new(lightmap.width, lightmap.height);
    let mut charts = vec![NONE; (size.x * size.y) as usize];
    for (face, chart) in faces.iter().zip(charts_of_faces(&faces)) {
        for texel in texels_on(face, size) {
            charts[(texel.y * size.x + texel.x) as usize] = chart;
        }
    }
    charts
}

/// The chart of each face: faces that share a corner are one piece. Charts are counted in the order of their first face.
fn charts_of_faces(faces: &[&LightmapFace]) -> Vec<u32> {
    let mut parents: Vec<usize> = (0..faces.len()).collect();
    let mut first_at = HashMap::<[u32; 2], usize>::new();
    for (number, face) in faces.iter().enumerate() {
        for corner in face.corners {
            let other = *first_at.entry(corner.to_array().map(f32::to_bits)).or_insert(number);
            let [a, b] = [number, other].map(|face| root(&mut parents, face));
            parents[a.max(b)] = a.min(b);
        }
    }
    let mut numbers = HashMap::<usize, u32>::new();
    (0..faces.len())
        .map(|face| {
            let next = numbers.len() as u32;
            *numbers.entry(root(&mut parents, face)).or_insert(next)
        })
        .collect()
}

/// The first face of the piece that a face is known to belong to.
fn root(parents: &mut [usize], face: usize) -> usize {
    let mut at = face;
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

/// Texels whose middle is on a face, or next to it.
fn texels_on(face: &LightmapFace, size: UVec2) -> impl Iterator<Item = UVec2> {
    let [a, b, c] = face.corners;
    let low = (a.min(b).min(c) - REACH).max(Vec2::ZERO).as_uvec2();
    let high = ((a.max(b).max(c) + REACH).max(Vec2::ZERO).ceil().as_uvec2()).min(size);
    let turn = (b - a).perp_dot(c - a).signum();
    let is_on = move |texel: &UVec2| {
        let middle = texel.as_vec2() + 0.5;
        let inside =
            |from: Vec2, to: Vec2| turn * (to - from).normalize_or_zero().perp_dot(middle - from) >= -REACH;
        inside(a, b) && inside(b, c) && inside(c, a)
    };
    (low.y..high.y).flat_map(move |y| (low.x..high.x).map(move |x| UVec2::new(x, y))).filter(is_on)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(corners: [[f32; 2]; 3]) -> LightmapFace {
        LightmapFace { corners: corners.map(Vec2::from) }
    }

    #[test]
    fn triangles_that_touch_are_one_chart() {
        let square = [face([[2.0, 2.0], [6.0, 2.0], [6.0, 6.0]]), face([[2.0, 2.0], [6.0, 6.0], [2.0, 6.0]])];
        let apart = face([[10.0, 2.0], [10.0, 6.0], [14.0, 6.0]]);
        let faces = [square[0], apart, square[1]].into();
        let lightmap = LightmapLayout { width: 16, height: 8, faces, ..LightmapLayout::default() };
        let charts = charts_of_texels(&lightmap);
        let at = |x: usize, y: usize| charts[y * 16 + x];
        assert!((2..6).all(|x| (2..6).all(|y| at(x, y) == 0)), "the square is whole");
        assert_eq!((at(10, 5), at(13, 5)), (1, 1));
        assert_eq!((at(8, 4), at(13, 2), at(0, 0)), (NONE, NONE, NONE));
    }
}
