//! A coarse voxel grid of the scene, flood-filled into open regions.

use probelight_math::glam::{IVec3, UVec3, Vec3};
use probelight_scene::{Bounds, Scene};

/// What a voxel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Voxel {
    /// Some triangle passes through.
    Occupied,
    /// Empty, connected to the outside of the scene's box.
    Outside,
    /// Empty, enclosed by occupied voxels: a closed room, or the inside of a solid.
    Enclosed,
}

/// Voxels around a scene, with one empty layer on every side.
pub(crate) struct VoxelGrid {
    origin: Vec3,
    cell: f32,
    size: UVec3,
    voxels: Vec<Voxel>,
}

/// Largest number of voxels; the cells grow until the scene fits.
const MAX_VOXELS: f64 = 16e6;

impl VoxelGrid {
    /// Voxelises the scene with cubes of about `cell` metres and floods the empty ones from outside.
    pub(crate) fn new(scene: &Scene, cell: f32) -> Self {
        let bounds = scene.bounds();
        let volume = bounds.size().max(Vec3::splat(cell)).as_dvec3().element_product();
        let cell = cell.max((volume / MAX_VOXELS).cbrt() as f32);
        let size = (bounds.size() / cell).ceil().as_uvec3() + UVec3::splat(3);
        let origin = bounds.min - Vec3::splat(1.5 * cell);
        let mut grid =
            Self { origin, cell, size, voxels: vec![Voxel::Enclosed; size.element_product() as usize] };
        for triangle in 0..scene.triangles.len() {
            grid.mark_triangle(scene.corners(triangle));
        }
        grid.flood_from_outside();
        grid
    }

    fn index(&self, at: UVec3) -> usize {
        ((at.z * self.size.y + at.y) * self.size.x + at.x) as usize
    }

    /// Centre of a voxel, metres.
    fn centre(&self, at: UVec3) -> Vec3 {
        self.origin + (at.as_vec3() + 0.5) * self.cell
    }

    fn mark_triangle(&mut self, corners: [Vec3; 3]) {
        let bounds = Bounds::of(corners);
        let low = ((bounds.min - self.origin) / self.cell).floor().max(Vec3::ZERO).as_uvec3();
        let high = ((bounds.max - self.origin) / self.cell).floor().as_uvec3().min(self.size - 1);
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let at = UVec3::new(x, y, z);
                    if box_overlaps_triangle(self.centre(at), Vec3::splat(self.cell * 0.5), corners) {
                        let index = self.index(at);
                        self.voxels[index] = Voxel::Occupied;
                    }
                }
            }
        }
    }

    fn flood_from_outside(&mut self) {
        let mut stack = vec![UVec3::ZERO];
        self.voxels[0] = Voxel::Outside;
        while let Some(at) = stack.pop() {
            for step in [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z] {
                let next = at.as_ivec3() + step;
                if next.cmplt(IVec3::ZERO).any() || next.cmpge(self.size.as_ivec3()).any() {
                    continue;
                }
                let index = self.index(next.as_uvec3());
                if self.voxels[index] == Voxel::Enclosed {
                    self.voxels[index] = Voxel::Outside;
                    stack.push(next.as_uvec3());
                }
            }
        }
    }

    /// Centres of the empty voxels within `reach` voxels of an occupied one, in grid order, and whether
    /// each is connected to the outside.
    pub(crate) fn empty_near_surfaces(&self, reach: u32) -> Vec<(Vec3, bool)> {
        let near = self.dilate_occupied(reach);
        let mut found = Vec::new();
        for z in 0..self.size.z {
            for y in 0..self.size.y {
                for x in 0..self.size.x {
                    let at = UVec3::new(x, y, z);
                    let index = self.index(at);
                    if near[index] && self.voxels[index] != Voxel::Occupied {
                        found.push((self.centre(at), self.voxels[index] == Voxel::Outside));
                    }
                }
            }
        }
        found
    }

    /// Marks all voxels within `reach` steps along each axis of an occupied one (a separable box filter).
    fn dilate_occupied(&self, reach: u32) -> Vec<bool> {
        let mut marked: Vec<bool> = self.voxels.iter().map(|v| *v == Voxel::Occupied).collect();
        let strides = [1, self.size.x as usize, (self.size.x * self.size.y) as usize];
        for (axis, stride) in strides.into_iter().enumerate() {
            for _ in 0..reach {
                let before = marked.clone();
                for (i, mark) in marked.iter_mut().enumerate() {
                    let along = i / stride % self.size[axis] as usize;
                    let low = along > 0 && before[i - stride];
                    let high = along + 1 < self.size[axis] as usize && before[i + stride];
                    *mark |= low || high;
                }
            }
        }
        marked
    }
}

/// Separating-axis test of an axis-aligned box with half edges `half` against a triangle (Akenine-Möller 2001).
pub(crate) fn box_overlaps_triangle(centre: Vec3, half: Vec3, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p - centre);
    let separates = |axis: Vec3| {
        let (pa, pb, pc) = (axis.dot(a), axis.dot(b), axis.dot(c));
        let radius = half.dot(axis.abs());
        pa.min(pb).min(pc) > radius || pa.max(pb).max(pc) < -radius
    };
    let edges = [b - a, c - b, a - c];
    !Vec3::AXES.into_iter().any(separates)
        && !separates((b - a).cross(c - a))
        && !Vec3::AXES.into_iter().any(|axis| edges.into_iter().any(|edge| separates(axis.cross(edge))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad_box(min: Vec3, max: Vec3) -> Vec<[Vec3; 3]> {
        let corner = |i: u32| {
            Vec3::select(probelight_math::glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max, min)
        };
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|t| t.map(corner))
            .collect()
    }

    fn scene_of(triangles: &[[Vec3; 3]]) -> Scene {
        let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        Scene {
            triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            positions,
            ..Scene::default()
        }
    }

    #[test]
    fn a_closed_box_encloses_its_inside() {
        let grid = VoxelGrid::new(&scene_of(&quad_box(Vec3::ZERO, Vec3::splat(4.0))), 0.5);
        let empty = grid.empty_near_surfaces(100);
        let is_inside = |p: Vec3| p.cmpgt(Vec3::ZERO).all() && p.cmplt(Vec3::splat(4.0)).all();
        assert!(empty.iter().any(|(p, _)| is_inside(*p)));
        assert!(empty.iter().all(|(p, outside)| is_inside(*p) != *outside));
    }

    #[test]
    fn an_open_box_does_not() {
        let mut triangles = quad_box(Vec3::ZERO, Vec3::splat(4.0));
        triangles.truncate(10);
        let grid = VoxelGrid::new(&scene_of(&triangles), 0.5);
        assert!(grid.empty_near_surfaces(100).iter().all(|(_, outside)| *outside));
    }
}
