//! Cutting large triangles along the walls that stand on them.
//!
//! A level's floor is often one triangle under several rooms. Its chart then runs through below the walls,
//! and bilinear lookups next to a wall mix the light of two rooms. Here such triangles are divided along
//! the lines where walls touch or cross them, and those lines become borders between charts:
//!
//! | step | file | result |
//! | --- | --- | --- |
//! | neighbours | `box_tree` | triangles whose boxes overlap |
//! | lines | `wall_cuts` | where walls meet a triangle's plane |
//! | pieces | `pieces` | convex polygons on either side of the lines |
//! | mesh | `rebuild` | a scene whose edges still match, with interpolated vertices |
//! | charts | `close_seams` | further seams where a chart would reach around the end of a wall |

mod box_tree;
mod close_seams;
mod pieces;
mod rebuild;
#[cfg(test)]
mod tests;
mod wall_cuts;

use probelight_scene::{Bounds, Scene};
use rayon::prelude::*;

use box_tree::BoxTree;
use close_seams::close_seams;
use pieces::{Frame, Pieces};
use rebuild::rebuild;
use wall_cuts::{WallCut, find_wall_cuts};

/// A scene whose triangles end at its walls.
#[derive(Clone, Debug)]
pub(crate) struct CutScene {
    /// The same surface in more triangles. Vertices of the input keep their index.
    pub(crate) scene: Scene,
    /// `seams[t][k]`: the edge from corner `k` to corner `k + 1` (mod 3) of triangle `t` must separate two
    /// charts.
    pub(crate) seams: Vec<[bool; 3]>,
}

/// Shortest wall that cuts, and shortest triangle that is cut, texels.
const MIN_LENGTH_TEXELS: f64 = 3.0;

/// Smallest height of a wall's triangle above (or depth below) the plane it cuts, texels: decals, door sills
/// and bevels are lower.
const MIN_RISE_TEXELS: f64 = 1.0;

/// Distance over which bilinear lookups and texels that straddle a border mix light, texels.
const REACH_TEXELS: f64 = 2.0;

/// Contact tolerance as a share of the scene's diagonal, and its upper bound in texels.
const TOLERANCE_OF_DIAGONAL: f64 = 5e-5;
const MAX_TOLERANCE_TEXELS: f64 = 0.05;

/// Smallest tolerance as a share of the largest coordinate: 16 steps of an `f32`.
const TOLERANCE_OF_COORDINATES: f64 = 1e-6;

/// Most triangles that cutting may add: this share of the input's, or what any scene can afford. Those that
/// keep the neighbours' edges matched come on top.
const MAX_ADDED_SHARE: usize = 1;
const MAX_ADDED_ANYWAY: usize = 4096;

/// Lengths that decide what is a wall, metres.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Points closer than this are one; no piece is thinner.
    tolerance: f64,
    min_length: f64,
    min_rise: f64,
    reach: f64,
}

impl Limits {
    fn new(bounds: &Bounds, texel_size: f32) -> Self {
        let texel = f64::from(texel_size);
        let largest_coordinate = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element());
        Self {
            tolerance: (TOLERANCE_OF_DIAGONAL * f64::from(bounds.diagonal()))
                .min(MAX_TOLERANCE_TEXELS * texel)
                .max(TOLERANCE_OF_COORDINATES * largest_coordinate),
            min_length: MIN_LENGTH_TEXELS * texel,
            min_rise: MIN_RISE_TEXELS * texel,
            reach: REACH_TEXELS * texel,
        }
    }
}

/// A triangle, the walls on it and what they leave of it.
struct Division {
    triangle: u32,
    /// Longest first.
    cuts: Vec<WallCut>,
    pieces: Pieces,
}

/// Cuts triangles where walls of other triangles stand on them or pass through them.
///
/// A wall is what meets the triangle's plane at an angle, over at least three texels, and rises at least one
/// texel from it. Edges stay matched: a triangle beside a cut one gets the same vertices on the shared edge.
/// `texel_size` is the lightmap's texel, metres.
pub(crate) fn cut_along_walls(scene: &Scene, texel_size: f32) -> CutScene {
    let limits = Limits::new(&scene.bounds(), texel_size);
    let boxes: Vec<Bounds> =
        (0..scene.triangles.len()).map(|triangle| Bounds::of(scene.corners(triangle))).collect();
    let tree = BoxTree::new(&boxes);
    let divisions: Vec<Division> = (0..scene.triangles.len())
        .into_par_iter()
        .filter_map(|triangle| divide(scene, &boxes, &tree, triangle, &limits))
        .collect();
    let divisions = keep_longest(divisions, scene.triangles.len());
    let mut cut = rebuild(scene, &divisions, &limits);
    close_seams(&mut cut, &limits);
    cut
}

/// Divides one triangle; `None` if no wall stands on it.
fn divide(
    scene: &Scene,
    boxes: &[Bounds],
    tree: &BoxTree,
    triangle: usize,
    limits: &Limits,
) -> Option<Division> {
    if f64::from(boxes[triangle].diagonal()) < limits.min_length {
        return None;
    }
    let frame = Frame::of(scene.corners(triangle));
    let cuts = find_wall_cuts(scene, boxes, tree, triangle, &frame, limits);
    let mut pieces = Pieces::whole(scene.corners(triangle).map(|p| frame.plane_from_world(p)));
    for cut in &cuts {
        pieces.cut(cut, limits.tolerance);
    }
    (!cuts.is_empty()).then_some(Division { triangle: triangle as u32, cuts, pieces })
}

/// Undoes the divisions by the shortest walls where the scene would grow too much. In triangle order.
fn keep_longest(mut divisions: Vec<Division>, triangles: usize) -> Vec<Division> {
    divisions.sort_by(|a, b| b.cuts[0].length().total_cmp(&a.cuts[0].length()));
    let mut budget = (triangles * MAX_ADDED_SHARE).max(MAX_ADDED_ANYWAY);
    divisions.retain(|division| {
        let added = division.pieces.triangle_count() - 1;
        let fits = added <= budget;
        budget -= if fits { added } else { 0 };
        fits
    });
    divisions.sort_by_key(|division| division.triangle);
    divisions
}
