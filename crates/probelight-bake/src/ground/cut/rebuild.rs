//! A scene from the pieces of its triangles.
//!
//! Two triangles beside each other must have the same points on their shared edge, or the unwrapper would
//! see a border there. So the points that cuts leave on an edge are collected from both sides, made one where
//! they are closer than the tolerance, and given to every triangle with that edge.

use std::collections::HashMap;

use probelight_math::glam::{DVec2, DVec3, Vec3};
use probelight_scene::Scene;
use rayon::prelude::*;

use super::pieces::{Frame, Pieces};
use super::{CutScene, Division, Limits};

/// Points closer to an edge than this share of its length lie on it: far above the rounding of `f64`.
const ON_EDGE: f64 = 1e-9;

/// Positions of an edge's ends, smaller first, as bits: equal for all triangles that have the edge.
pub(super) type EdgeKey = [[u32; 3]; 2];

/// Where a vertex of a new triangle comes from.
#[derive(Clone, Copy, Debug)]
enum Place {
    Corner(usize),
    /// On the edge after a corner, at a share of the way from the edge's smaller end.
    Edge(usize, f64),
    /// Barycentric weights.
    Inside(DVec3),
}

/// What becomes of one triangle.
struct NewTriangles {
    corners: Vec<[Place; 3]>,
    seams: Vec<[bool; 3]>,
}

/// Builds the scene of the divided triangles.
pub(super) fn rebuild(scene: &Scene, divisions: &[Division], limits: &Limits) -> CutScene {
    let edge_points = collect_edge_points(scene, divisions, limits.tolerance);
    let mut of_triangle: Vec<Option<&Division>> = vec![None; scene.triangles.len()];
    for division in divisions {
        of_triangle[division.triangle as usize] = Some(division);
    }
    let replacements: Vec<Option<NewTriangles>> = of_triangle
        .par_iter()
        .enumerate()
        .map(|(triangle, division)| replace(scene, triangle, *division, &edge_points, limits))
        .collect();
    let mut builder = Builder::new(scene);
    for (triangle, replacement) in replacements.iter().enumerate() {
        builder.add(triangle, replacement.as_ref());
    }
    builder.cut
}

/// The key of the edge after corner `k`, and whether the edge runs from its larger to its smaller end.
pub(super) fn edge_key(corners: [Vec3; 3], k: usize) -> (EdgeKey, bool) {
    // Adding zero turns -0 into 0.
    let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let [a, b] = [bits(corners[k]), bits(corners[(k + 1) % 3])];
    if a <= b { ([a, b], false) } else { ([b, a], true) }
}

/// The points that cuts leave on each edge, as ascending shares of the way from the smaller end.
fn collect_edge_points(scene: &Scene, divisions: &[Division], tolerance: f64) -> HashMap<EdgeKey, Vec<f64>> {
    let mut shares: HashMap<EdgeKey, Vec<f64>> = HashMap::new();
    let mut lengths: HashMap<EdgeKey, f64> = HashMap::new();
    for Division { triangle, pieces, .. } in divisions {
        let corners = scene.corners(*triangle as usize);
        for point in &pieces.points[3..] {
            if let Some((k, share)) = place_on_edge(&pieces.points, *point) {
                let (key, reversed) = edge_key(corners, k);
                shares.entry(key).or_default().push(if reversed { 1.0 - share } else { share });
                lengths.insert(key, pieces.points[k].distance(pieces.points[(k + 1) % 3]));
            }
        }
    }
    for (key, shares) in &mut shares {
        shares.sort_by(f64::total_cmp);
        let smallest_step = tolerance / lengths[key];
        shares.dedup_by(|next, kept| *next - *kept < smallest_step);
    }
    shares
}

/// The edge of the triangle on which a point lies, and its share of the way along it.
fn place_on_edge(points: &[DVec2], point: DVec2) -> Option<(usize, f64)> {
    (0..3).find_map(|k| {
        let edge = points[(k + 1) % 3] - points[k];
        let relative = point - points[k];
        let length_squared = edge.length_squared();
        (edge.perp_dot(relative).abs() <= ON_EDGE * length_squared)
            .then(|| (k, edge.dot(relative) / length_squared))
    })
}

/// The triangles that take a triangle's place; `None` if it stays as it is.
fn replace(
    scene: &Scene,
    triangle: usize,
    division: Option<&Division>,
    edge_points: &HashMap<EdgeKey, Vec<f64>>,
    limits: &Limits,
) -> Option<NewTriangles> {
    let corners = scene.corners(triangle);
    let edges = [0, 1, 2].map(|k| edge_key(corners, k));
    let shares = edges.map(|(key, _)| edge_points.get(&key));
    if division.is_none() && shares.iter().all(Option::is_none) {
        return None;
    }
    let mut pieces = division.map_or_else(
        || {
            let frame = Frame::of(corners);
            Pieces::whole(corners.map(|p| frame.plane_from_world(p)))
        },
        |division| division.pieces.clone(),
    );
    let mut places = place_points(&pieces, edges.map(|edge| edge.1), shares);
    for (k, (_, reversed)) in edges.into_iter().enumerate() {
        let mut missing = shares[k].into_iter().flatten().copied().collect::<Vec<f64>>();
        missing.retain(|share| {
            !places.iter().any(|place| matches!(place, Place::Edge(edge, own) if edge == &k && own == share))
        });
        for share in missing {
            insert_edge_point(&mut pieces, &mut places, k, share, reversed);
        }
    }
    triangulate(&pieces, &places, division, limits)
}

/// Finds where the points of a triangle's pieces lie; points on its edges move to the shared ones.
fn place_points(pieces: &Pieces, reversed: [bool; 3], shares: [Option<&Vec<f64>>; 3]) -> Vec<Place> {
    let points = &pieces.points;
    let [a, b, c] = [points[0], points[1], points[2]];
    let area = (b - a).perp_dot(c - a);
    let inside = |p: DVec2| {
        let weights = DVec2::new((p - a).perp_dot(c - a), (b - a).perp_dot(p - a)) / area;
        Place::Inside(DVec3::new(1.0 - weights.x - weights.y, weights.x, weights.y))
    };
    let new = points[3..].iter().map(|point| {
        let Some((k, share)) = place_on_edge(points, *point) else { return inside(*point) };
        let share = if reversed[k] { 1.0 - share } else { share };
        let shared = shares[k].into_iter().flatten().take_while(|s| **s <= share).last();
        Place::Edge(k, shared.copied().unwrap_or(share))
    });
    (0..3).map(Place::Corner).chain(new).collect()
}

/// Gives a triangle a point that a neighbour has on their shared edge.
fn insert_edge_point(pieces: &mut Pieces, places: &mut Vec<Place>, k: usize, share: f64, reversed: bool) {
    let from_start = |share: f64| if reversed { 1.0 - share } else { share };
    let share_of = |place: &Place| match *place {
        Place::Corner(corner) if corner == k => Some(0.0),
        Place::Corner(corner) if corner == (k + 1) % 3 => Some(1.0),
        Place::Edge(edge, share) if edge == k => Some(from_start(share)),
        _ => None,
    };
    let wanted = from_start(share);
    let on_edge = || places.iter().enumerate().filter_map(|(i, place)| Some((share_of(place)?, i as u32)));
    let before = on_edge().filter(|p| p.0 < wanted).max_by(|a, b| a.0.total_cmp(&b.0));
    let after = on_edge().filter(|p| p.0 > wanted).min_by(|a, b| a.0.total_cmp(&b.0));
    if let (Some((_, before)), Some((_, after))) = (before, after) {
        let point = pieces.points[k].lerp(pieces.points[(k + 1) % 3], wanted);
        pieces.insert_on_edge(before, after, point);
        places.push(Place::Edge(k, share));
    }
}

/// Triangles of all pieces, and which of their edges stand under a wall.
fn triangulate(
    pieces: &Pieces,
    places: &[Place],
    division: Option<&Division>,
    limits: &Limits,
) -> Option<NewTriangles> {
    let mut new = NewTriangles { corners: Vec::new(), seams: Vec::new() };
    for ring in &pieces.polygons {
        for corners in pieces.triangulate(ring)? {
            let points = corners.map(|p| pieces.points[p as usize]);
            let is_seam = |k: usize| {
                let mut cuts = division.iter().flat_map(|division| &division.cuts);
                cuts.any(|cut| cut.covers(points[k], points[(k + 1) % 3], 2.0 * limits.tolerance))
            };
            new.corners.push(corners.map(|p| places[p as usize]));
            new.seams.push([is_seam(0), is_seam(1), is_seam(2)]);
        }
    }
    Some(new)
}

/// Appends triangles and vertices to a scene.
struct Builder<'a> {
    from: &'a Scene,
    cut: CutScene,
    /// Vertices on edges, by the vertices at the edge's ends (smaller position first) and share.
    on_edges: HashMap<(u32, u32, u64), u32>,
}

impl<'a> Builder<'a> {
    fn new(from: &'a Scene) -> Self {
        let mut scene = Scene { triangles: Vec::new(), triangle_material: Vec::new(), ..from.clone() };
        scene.sources.triangles.clear();
        Self { from, cut: CutScene { scene, seams: Vec::new() }, on_edges: HashMap::new() }
    }

    fn add(&mut self, triangle: usize, replacement: Option<&NewTriangles>) {
        let Some(new) = replacement else {
            self.push(triangle, self.from.triangles[triangle], [false; 3]);
            return;
        };
        let mut inside = HashMap::new();
        for (places, seams) in new.corners.iter().zip(&new.seams) {
            let vertices = places.map(|place| self.vertex(triangle, place, &mut inside));
            self.push(triangle, vertices, *seams);
        }
    }

    fn push(&mut self, triangle: usize, vertices: [u32; 3], seams: [bool; 3]) {
        let scene = &mut self.cut.scene;
        scene.triangles.push(vertices);
        if scene.area(scene.triangles.len() - 1) <= 0.0 {
            // Rounding its corners to f32 has left nothing of it.
            scene.triangles.pop();
            return;
        }
        scene.triangle_material.push(self.from.triangle_material[triangle]);
        scene.sources.triangles.extend(self.from.sources.triangles.get(triangle));
        self.cut.seams.push(seams);
    }

    fn vertex(&mut self, triangle: usize, place: Place, inside: &mut HashMap<[u64; 2], u32>) -> u32 {
        let corners = self.from.triangles[triangle];
        match place {
            Place::Corner(k) => corners[k],
            Place::Edge(k, share) => {
                let (_, reversed) = edge_key(self.from.corners(triangle), k);
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let (a, b) = if reversed { (b, a) } else { (a, b) };
                if let Some(known) = self.on_edges.get(&(a, b, share.to_bits())) {
                    return *known;
                }
                let vertex = self.mix(&[(a, 1.0 - share), (b, share)]);
                self.on_edges.insert((a, b, share.to_bits()), vertex);
                vertex
            }
            Place::Inside(weights) => {
                let key = [weights.y.to_bits(), weights.z.to_bits()];
                if let Some(known) = inside.get(&key) {
                    return *known;
                }
                let [a, b, c] = corners;
                let vertex = self.mix(&[(a, weights.x), (b, weights.y), (c, weights.z)]);
                inside.insert(key, vertex);
                vertex
            }
        }
    }

    /// Appends a weighted mean of vertices.
    fn mix(&mut self, parts: &[(u32, f64)]) -> u32 {
        let scene = &mut self.cut.scene;
        let first = parts[0].0 as usize;
        let position: DVec3 = parts.iter().map(|(v, w)| scene.positions[*v as usize].as_dvec3() * *w).sum();
        let normal: DVec3 = parts.iter().map(|(v, w)| scene.normals[*v as usize].as_dvec3() * *w).sum();
        let tangent: DVec3 =
            parts.iter().map(|(v, w)| scene.tangents[*v as usize].truncate().as_dvec3() * *w).sum();
        let uv0: DVec2 = parts.iter().map(|(v, w)| scene.uv0[*v as usize].as_dvec2() * *w).sum();
        scene.positions.push(position.as_vec3());
        scene.normals.push(normal.as_vec3().normalize_or(scene.normals[first]));
        let sign = scene.tangents[first].w;
        scene.tangents.push(tangent.as_vec3().normalize_or(scene.tangents[first].truncate()).extend(sign));
        scene.uv0.push(uv0.as_vec2());
        if !scene.uv1.is_empty() {
            let uv1: DVec2 = parts.iter().map(|(v, w)| scene.uv1[*v as usize].as_dvec2() * *w).sum();
            scene.uv1.push(uv1.as_vec2());
        }
        scene.positions.len() as u32 - 1
    }
}
