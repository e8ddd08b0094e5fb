//! Further seams, so that no chart reaches around the end of a wall.
//!
//! The unwrapper never divides connected coplanar faces: where a wall ends at a door, the floor on both its
//! sides stays one chart, with the seam as a slit of no width inside it. Here faces on both sides of a seam
//! are declared opponents, faces are joined into groups across their longest edges first, and an edge that
//! would bring opponents together becomes a seam as well.

use std::collections::HashMap;

use probelight_math::glam::Vec3;
use probelight_scene::Scene;

use super::rebuild::{EdgeKey, edge_key};
use super::{CutScene, Limits};

/// Faces whose normals differ by more (cosine) never share a chart, whose faces keep within 30° of its mean.
const MIN_COSINE: f32 = 0.5;

/// Most faces looked at beyond one seam edge.
const MAX_VISITED: usize = 64;

/// Most faces of one edge that are looked at.
const MAX_FACES_OF_EDGE: usize = 32;

/// The face beyond each edge, if it may share a chart.
type Neighbours = Vec<[Option<u32>; 3]>;

/// Adds the seams that keep the two sides of every seam in different charts, and drops those where charts
/// end anyway: on open borders and sharp creases.
pub(super) fn close_seams(cut: &mut CutScene, limits: &Limits) {
    let CutScene { scene, seams } = cut;
    if seams.iter().flatten().all(|is_seam| !is_seam) {
        return;
    }
    let neighbours = find_neighbours(scene);
    for (seams, neighbours) in seams.iter_mut().zip(&neighbours) {
        *seams = [0, 1, 2].map(|k| seams[k] && neighbours[k].is_some());
    }
    let seam_edges = (0..seams.len() as u32)
        .flat_map(|face| (0..3).map(move |k| (face, k)))
        .filter(|(face, k)| seams[*face as usize][*k]);
    let mut groups = Groups::new(scene.triangles.len());
    for (face, k) in seam_edges {
        for opponent in faces_beyond(scene, &neighbours, face, k, limits) {
            groups.oppose(face, opponent);
        }
    }
    for (face, k, other) in edges_longest_first(scene, &neighbours, seams) {
        groups.join(face, other);
        if groups.of(face) != groups.of(other) {
            seams[face as usize][k] = true;
        }
    }
}

/// Pairs faces that continue each other across an edge. The wall on it may have the very same edge.
fn find_neighbours(scene: &Scene) -> Neighbours {
    let mut edges: HashMap<EdgeKey, Vec<(usize, usize, bool)>> = HashMap::new();
    for face in 0..scene.triangles.len() {
        for k in 0..3 {
            let (key, reversed) = edge_key(scene.corners(face), k);
            edges.entry(key).or_default().push((face, k, reversed));
        }
    }
    let mut neighbours = vec![[None; 3]; scene.triangles.len()];
    for sides in edges.into_values() {
        let sides = &sides[..sides.len().min(MAX_FACES_OF_EDGE)];
        let (forward, backward): (Vec<_>, Vec<_>) = sides.iter().partition(|side| !side.2);
        for (f, i, _) in forward {
            for &(g, j, _) in &backward {
                let is_free = neighbours[f][i].is_none() && neighbours[g][j].is_none();
                if is_free && scene.geometric_normal(f).dot(scene.geometric_normal(g)) > MIN_COSINE {
                    neighbours[f][i] = Some(g as u32);
                    neighbours[g][j] = Some(f as u32);
                }
            }
        }
    }
    neighbours
}

/// Connected faces within reach of an edge of `face`, on the edge's other side.
fn faces_beyond(scene: &Scene, neighbours: &Neighbours, face: u32, k: usize, limits: &Limits) -> Vec<u32> {
    let corners = scene.corners(face as usize);
    let edge = [corners[k], corners[(k + 1) % 3]];
    let outwards = (edge[1] - edge[0]).cross(scene.geometric_normal(face as usize));
    let is_near = |other: u32| {
        let corners = scene.corners(other as usize);
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        outwards.dot(centre - edge[0]) > 0.0
            && (0..3).any(|i| {
                let distance = edge_distance(edge, [corners[i], corners[(i + 1) % 3]]);
                f64::from(distance) < limits.reach
            })
    };
    let mut found: Vec<u32> = neighbours[face as usize][k].into_iter().collect();
    let mut next = 0;
    while next < found.len() && found.len() < MAX_VISITED {
        for neighbour in neighbours[found[next] as usize].into_iter().flatten() {
            if neighbour != face && !found.contains(&neighbour) && is_near(neighbour) {
                found.push(neighbour);
            }
        }
        next += 1;
    }
    found
}

/// Distance between two edges that do not cross.
fn edge_distance(a: [Vec3; 2], b: [Vec3; 2]) -> f32 {
    let to_edge = |point: Vec3, [from, to]: [Vec3; 2]| {
        let edge = to - from;
        let share = (point - from).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE);
        point.distance(from + edge * share.clamp(0.0, 1.0))
    };
    to_edge(a[0], b).min(to_edge(a[1], b)).min(to_edge(b[0], a)).min(to_edge(b[1], a))
}

/// Edges between two faces that are no seam: (face, corner, other face).
fn edges_longest_first(
    scene: &Scene,
    neighbours: &Neighbours,
    seams: &[[bool; 3]],
) -> Vec<(u32, usize, u32)> {
    let mut edges = Vec::new();
    for (face, beyond) in neighbours.iter().enumerate() {
        for (k, other) in beyond.iter().enumerate() {
            let Some(other) = *other else { continue };
            let other_side = neighbours[other as usize].iter().position(|n| *n == Some(face as u32));
            let is_seam = seams[face][k] || other_side.is_some_and(|j| seams[other as usize][j]);
            if other > face as u32 && !is_seam {
                let corners = scene.corners(face);
                edges.push((corners[k].distance_squared(corners[(k + 1) % 3]), (face as u32, k, other)));
            }
        }
    }
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    edges.into_iter().map(|(_, edge)| edge).collect()
}

/// Disjoint sets of faces, some of which must stay apart.
struct Groups {
    parent: Vec<u32>,
    /// Of each group's root: faces that must not join it.
    opponents: Vec<Vec<u32>>,
}

impl Groups {
    fn new(faces: usize) -> Self {
        Self { parent: (0..faces as u32).collect(), opponents: vec![Vec::new(); faces] }
    }

    /// The root of a face's group.
    fn of(&mut self, face: u32) -> u32 {
        let mut root = face;
        while self.parent[root as usize] != root {
            let grandparent = self.parent[self.parent[root as usize] as usize];
            self.parent[root as usize] = grandparent;
            root = grandparent;
        }
        root
    }

    fn oppose(&mut self, a: u32, b: u32) {
        self.opponents[a as usize].push(b);
        self.opponents[b as usize].push(a);
    }

    /// Joins two groups unless they are opponents.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        let fewer = |s: &Self, x: u32| s.opponents[x as usize].len();
        let (small, large) = if fewer(self, a) <= fewer(self, b) { (a, b) } else { (b, a) };
        if a == b {
            return;
        }
        let opponents = std::mem::take(&mut self.opponents[small as usize]);
        if opponents.iter().any(|face| self.of(*face) == large) {
            self.opponents[small as usize] = opponents;
        } else {
            self.opponents[large as usize].extend(opponents);
            self.parent[small as usize] = large;
        }
    }
}

/// Faces beside each other with a seam between them.
#[cfg(test)]
pub(super) fn pairs_across_seams(cut: &CutScene) -> Vec<(u32, u32)> {
    let neighbours = find_neighbours(&cut.scene);
    let edges = (0..cut.seams.len()).flat_map(|face| (0..3).map(move |k| (face, k)));
    let seams = edges.filter(|(face, k)| cut.seams[*face][*k]);
    seams.filter_map(|(face, k)| Some((face as u32, neighbours[face][k]?))).collect()
}

/// Per face the group of faces that it is connected with across edges that are no seam.
#[cfg(test)]
pub(super) fn groups_without_seams(cut: &CutScene) -> Vec<u32> {
    let neighbours = find_neighbours(&cut.scene);
    let mut groups = Groups::new(cut.scene.triangles.len());
    for (face, _, other) in edges_longest_first(&cut.scene, &neighbours, &cut.seams) {
        groups.join(face, other);
    }
    (0..cut.scene.triangles.len() as u32).map(|face| groups.of(face)).collect()
}
