//! Unwrapping the lit faces into lightmap charts.
//!
//! The unwrapper (`uvunwrap`) guarantees charts that neither overlap nor flip and keep their padding
//! free, so that a bilinear lookup in one chart never touches a texel that another one needs.

use probelight_asset::{LightmapFace, NONE};
use probelight_math::glam::Vec2;
use probelight_scene::Scene;
use probelight_trace::{Hit, Progress};
use uvunwrap::{Density, MeshInput, Options, Packing};

use crate::BakeError;
use crate::air::LitSides;

/// Largest angle between a face and its chart's mean normal, degrees. Receivers take the face's own normal,
/// so this only bounds how far a texel's neighbours may turn away.
const MAX_CHART_ANGLE: f32 = 30.0;

/// Texels kept free around each chart; charts are twice as far apart, so that the texels that bilinear
/// lookups in two charts touch are never the same.
const PADDING: u32 = 2;

/// Largest page edge, texels: that of the textures that every GPU has. One page holds 67 million texels.
const MAX_PAGE_SIZE: u32 = 8192;

/// Charts narrower than this fit into one texel, with room for rounding, texels.
const NARROW: f32 = 0.98;

/// Lit faces laid out in one stacked image.
#[derive(Clone, Debug)]
pub(crate) struct Atlas {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pages: u32,
    /// Front faces in triangle order, then lit back faces.
    pub(crate) faces: Vec<LightmapFace>,
    /// Triangle of each face.
    pub(crate) face_triangles: Vec<u32>,
    /// Chart of each face; [`NONE`] for unlit faces and those too thin to have one.
    pub(crate) face_charts: Vec<u32>,
    /// Per triangle its back face's index in `faces`, or [`NONE`].
    pub(crate) back_faces: Vec<u32>,
}

impl Atlas {
    /// Whether a face is the back of its triangle.
    pub(crate) fn is_back_face(&self, face: u32) -> bool {
        face as usize >= self.back_faces.len()
    }

    /// The face on one side of a triangle, or [`NONE`] if its back is unlit.
    pub(crate) fn face_of(&self, triangle: u32, is_back_face: bool) -> u32 {
        if is_back_face { self.back_faces[triangle as usize] } else { triangle }
    }

    /// The lightmap texel at a hit, on the side that was hit; [`NONE`] if that side has no light of its own.
    pub(crate) fn texel_of_hit(&self, hit: &Hit) -> u32 {
        let face = self.face_of(hit.triangle, hit.is_back_face);
        if face == NONE || self.face_charts[face as usize] == NONE {
            return NONE;
        }
        self.texel_at(self.faces[face as usize].position(hit.barycentric))
    }

    /// Smallest and largest corner of each chart, texels.
    pub(crate) fn chart_bounds(&self) -> Vec<(Vec2, Vec2)> {
        bounds_of_charts(&self.faces, &self.face_charts)
    }

    /// The texel at a position in the lightmap, texels.
    pub(crate) fn texel_at(&self, position: Vec2) -> u32 {
        let position = position.max(Vec2::ZERO);
        let (x, y) = ((position.x as u32).min(self.width - 1), (position.y as u32).min(self.height - 1));
        y * self.width + x
    }
}

/// Lays out the lit faces at `texels_per_meter`, parting charts at the `seams` (see [`crate::ground::cut`]). Front faces
/// without light keep their place in the list, but have no chart.
pub(crate) fn unwrap_faces(
    scene: &Scene,
    lit_sides: &LitSides,
    seams: &[[bool; 3]],
    use_uv1: bool,
    texels_per_meter: f32,
    progress: &dyn Progress,
) -> Result<Atlas, BakeError> {
    let positions: Vec<[f32; 3]> = scene.positions.iter().map(|p| p.to_array()).collect();
    let uv1: Vec<[f32; 2]> = scene.uv1.iter().map(|uv| uv.to_array()).collect();
    let front: Vec<u32> = scene.triangles.iter().flatten().copied().collect();
    let mut back_faces = vec![NONE; scene.triangles.len()];
    let mut face_triangles: Vec<u32> = (0..scene.triangles.len() as u32).collect();
    let mut back = Vec::new();
    let mut back_seams = Vec::new();
    for (t, &[a, b, c]) in scene.triangles.iter().enumerate() {
        if lit_sides.back(t) {
            back_faces[t] = face_triangles.len() as u32;
            face_triangles.push(t as u32);
            back.extend([a, c, b]);
            let [ab, bc, ca] = seams[t];
            back_seams.push([ca, bc, ab]);
        }
    }
    let hidden: Vec<bool> = (0..scene.triangles.len()).map(|t| !lit_sides.front(t)).collect();
    let mut meshes = vec![MeshInput {
        ignored_faces: Some(&hidden),
        seams: Some(seams),
        ..MeshInput::new(&positions, &front)
    }];
    if !back.is_empty() {
        meshes.push(MeshInput { seams: Some(&back_seams), ..MeshInput::new(&positions, &back) });
    }
    if use_uv1 && !uv1.is_empty() {
        for mesh in &mut meshes {
            mesh.existing_uvs = Some(&uv1);
        }
    }
    let layout = generate(&meshes, texels_per_meter, progress)?;

    let mut faces = Vec::with_capacity(face_triangles.len());
    let mut face_charts = Vec::with_capacity(face_triangles.len());
    for (m, mesh) in layout.meshes.iter().enumerate() {
        for corners in mesh.indices.as_chunks::<3>().0 {
            let vertices = corners.map(|c| &mesh.vertices[c as usize]);
            let mut texels = vertices.map(|v| {
                let page_top = (v.page.unwrap_or(0) * layout.height) as f32;
                let size = Vec2::new(layout.width as f32, layout.height as f32);
                Vec2::from(v.uv) * size + Vec2::new(0.0, page_top)
            });
            if m == 1 {
                // Back faces were handed over with their second and third corner swapped.
                texels.swap(1, 2);
            }
            let is_hidden = m == 0 && hidden[faces.len()];
            let chart = vertices[0].chart.filter(|_| !is_hidden);
            faces.push(LightmapFace { corners: if chart.is_some() { texels } else { [Vec2::ZERO; 3] } });
            face_charts.push(chart.unwrap_or(NONE));
        }
    }
    keep_in_one_texel(&mut faces, &face_charts);
    Ok(Atlas {
        width: layout.width,
        height: layout.height * layout.page_count,
        pages: layout.page_count,
        faces,
        face_triangles,
        face_charts,
        back_faces,
    })
}

/// Moves charts that are narrower than a texel to its middle, so that they do not take two: by half a texel at most,
/// and the texels that lookups touch stay the chart's own.
fn keep_in_one_texel(faces: &mut [LightmapFace], face_charts: &[u32]) {
    let bounds = bounds_of_charts(faces, face_charts);
    for (face, chart) in faces.iter_mut().zip(face_charts) {
        let Some((low, high)) = bounds.get(*chart as usize) else { continue };
        let middle = 0.5 * (*low + *high);
        let is_narrow = (*high - *low).cmplt(Vec2::splat(NARROW));
        let shift = Vec2::select(is_narrow, middle.floor() + 0.5 - middle, Vec2::ZERO);
        face.corners.iter_mut().for_each(|corner| *corner += shift);
    }
}

/// Smallest and largest corner of each chart, texels.
fn bounds_of_charts(faces: &[LightmapFace], face_charts: &[u32]) -> Vec<(Vec2, Vec2)> {
    let charts =
        face_charts.iter().filter(|chart| **chart != NONE).max().map_or(0, |last| *last as usize + 1);
    let mut bounds = vec![(Vec2::INFINITY, Vec2::NEG_INFINITY); charts];
    let with_chart = |(face, chart): (_, &u32)| (*chart != NONE).then_some((face, *chart as usize));
    for (face, chart) in faces.iter().zip(face_charts).filter_map(with_chart) {
        let (low, high) = &mut bounds[chart];
        for corner in face.corners {
            (*low, *high) = (low.min(corner), high.max(corner));
        }
    }
    bounds
}

/// Runs the unwrapper on as many pages as needed.
fn generate(
    meshes: &[MeshInput<'_>],
    texels_per_meter: f32,
    progress: &dyn Progress,
) -> Result<uvunwrap::Atlas, BakeError> {
    let mut options = Options {
        max_chart_angle: MAX_CHART_ANGLE,
        padding: PADDING,
        packing: Packing::Fast,
        max_chart_size: MAX_PAGE_SIZE - 2 * PADDING,
        ..Options::default()
    };
    let mut unwrap = |page_size| {
        options.density = Density::Fixed { texels_per_unit: texels_per_meter, page_size };
        uvunwrap::generate_with_progress(meshes, &options, |_| !progress.is_cancelled()).map_err(
            |e| match e {
                uvunwrap::Error::Cancelled => BakeError::Cancelled,
                other => BakeError::Atlas { reason: format!("{other}; try a lower texel density") },
            },
        )
    };
    let single = unwrap(None)?;
    if single.width.max(single.height) <= MAX_PAGE_SIZE {
        return Ok(single);
    }
    unwrap(Some(MAX_PAGE_SIZE))
}

/// Barycentric weights of the second and third corner.
pub(crate) fn barycentric_of(point: Vec2, [a, b, c]: [Vec2; 3]) -> Vec2 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let area = ab.perp_dot(ac);
    if area == 0.0 {
        return Vec2::splat(1.0 / 3.0);
    }
    Vec2::new(ap.perp_dot(ac), ab.perp_dot(ap)) / area
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_charts_move_into_one_texel_as_a_whole() {
        let face = |x: f32, y: f32, size: f32| LightmapFace {
            corners: [Vec2::ZERO, Vec2::X, Vec2::Y].map(|corner| Vec2::new(x, y) + corner * size),
        };
        // A chart of two faces across a border between texels, a wide one, and a face without chart.
        let before = [face(4.7, 9.0, 0.3), face(4.9, 9.2, 0.4), face(20.6, 30.7, 5.0), face(0.0, 0.0, 0.0)];
        let mut faces = before;
        keep_in_one_texel(&mut faces, &[1, 1, 0, NONE]);
        let corners = || faces[..2].iter().flat_map(|face| face.corners);
        assert!(corners().all(|corner| corner.floor() == Vec2::new(5.0, 9.0)), "{faces:?}");
        let shifts: Vec<Vec2> = (0..2).map(|face| faces[face].corners[0] - before[face].corners[0]).collect();
        assert!(shifts[0].abs_diff_eq(shifts[1], 1e-5) && shifts[0].abs().max_element() <= 0.5);
        assert_eq!(faces[2..], before[2..]);
    }
}
