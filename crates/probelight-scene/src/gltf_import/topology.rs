//! Which vertices make up which triangle.

use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::{Mode, Semantic};

use super::Reason;
use super::accessors::Elements;
use super::resources::Resources;

/// Most triangles of a flattened scene: about 4 GB of them and their vertices.
pub(super) const MAX_TRIANGLES: usize = 20_000_000;

/// How many triangles a primitive says it has; none for points and lines.
pub(super) fn claimed_triangles(source: &gltf::Primitive<'_>) -> usize {
    let corners = source.indices().or_else(|| source.get(&Semantic::Positions));
    let count = corners.map_or(0, |accessor| accessor.count());
    match source.mode() {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
        Mode::Triangles => count / 3,
        Mode::TriangleStrip | Mode::TriangleFan => count.saturating_sub(2),
    }
}

/// The vertex of each corner, checked to exist.
pub(super) fn corner_indices(
    source: &gltf::Primitive<'_>,
    vertex_count: usize,
    resources: &Resources<'_>,
) -> Result<Vec<u32>, Reason> {
    let Some(accessor) = source.indices() else { return Ok((0..vertex_count as u32).collect()) };
    if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("accessors[{}]: indices must be unsigned integers", accessor.index()));
    }
    let elements = Elements::new(&accessor, Dimensions::Scalar, resources)?.backed(&accessor)?;
    let indices: Vec<u32> = (0..elements.count).map(|i| elements.index(i)).collect();
    match indices.iter().find(|index| **index as usize >= vertex_count) {
        Some(index) => Err(format!("index {index} is out of range: there are {vertex_count} vertices")),
        None => Ok(indices),
    }
}

/// Triangles of a list, strip or fan, wound like their first one; none of points and lines.
pub(super) fn triangles_from_mode(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let rim = corners.get(1..).unwrap_or_default();
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
        Mode::Triangles => corners.as_chunks().0.to_vec(),
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => rim.windows(2).map(|w| [corners[0], w[0], w[1]]).collect(),
    }
}

/// Only the vertices that triangles use, and the triangles renumbered to them.
pub(super) fn compact(triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut vertices = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let position = |v: u32| vertices.partition_point(|other| *other < v) as u32;
    let renumbered = triangles.iter().map(|triangle| triangle.map(position)).collect();
    (vertices, renumbered)
}

/// Three vertices of its own for each triangle.
pub(super) fn unshared(triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let renumbered = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    (triangles.as_flattened().to_vec(), renumbered)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_keep_their_front_face_and_fans_their_hub() {
        assert_eq!(triangles_from_mode(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangles_from_mode(Mode::TriangleFan, &[7, 1, 2, 3]), [[7, 1, 2], [7, 2, 3]]);
        assert_eq!(triangles_from_mode(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
        for mode in [Mode::TriangleFan, Mode::TriangleStrip, Mode::Triangles] {
            assert!(triangles_from_mode(mode, &[]).is_empty());
        }
        assert!(triangles_from_mode(Mode::LineStrip, &[0, 1, 2]).is_empty());
    }

    #[test]
    fn compacting_keeps_only_used_vertices_in_order() {
        assert_eq!(compact(&[[9, 4, 6], [6, 4, 2]]), (vec![2, 4, 6, 9], vec![[3, 1, 2], [2, 1, 0]]));
        assert_eq!(unshared(&[[1, 2, 3], [3, 2, 1]]).0, [1, 2, 3, 3, 2, 1]);
    }
}
