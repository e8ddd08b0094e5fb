//! Where walls meet a triangle's plane.

use probelight_math::glam::{DVec2, Vec3};
use probelight_scene::{Bounds, Scene};

use super::Limits;
use super::box_tree::BoxTree;
use super::pieces::Frame;

/// Smallest sine of the angle between a wall and the plane it cuts.
const MIN_SINE: f64 = 0.2;

/// Most lines looked at per triangle.
const MAX_LINES: usize = 256;

/// A straight stretch of wall in the plane of the triangle it cuts, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallCut {
    /// Unit normal of the line, in the plane.
    normal: DVec2,
    /// Signed distance of the line from the plane's origin.
    offset: f64,
    /// Where the wall begins and ends along the line.
    pub(super) start: f64,
    pub(super) end: f64,
}

impl WallCut {
    fn through([a, b]: [DVec2; 2]) -> Self {
        let direction = (b - a).normalize_or(DVec2::X);
        let normal = direction.perp();
        let ends = [direction.dot(a), direction.dot(b)];
        Self { normal, offset: normal.dot(a), start: ends[0], end: ends[1] }
    }

    pub(super) fn length(&self) -> f64 {
        self.end - self.start
    }

    /// Signed distance from the line.
    pub(super) fn distance(&self, point: DVec2) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Position along the line.
    pub(super) fn along(&self, point: DVec2) -> f64 {
        -self.normal.perp().dot(point)
    }

    /// The point of the line at a position along it.
    pub(super) fn at(&self, along: f64) -> DVec2 {
        self.normal * self.offset - self.normal.perp() * along
    }

    /// Whether the wall stands on an edge.
    pub(super) fn covers(&self, a: DVec2, b: DVec2, tolerance: f64) -> bool {
        let middle = self.along(0.5 * (a + b));
        self.distance(a).abs() <= tolerance
            && self.distance(b).abs() <= tolerance
            && (self.start..self.end).contains(&middle)
    }
}

/// The walls on a triangle, longest first.
pub(super) fn find_wall_cuts(
    scene: &Scene,
    boxes: &[Bounds],
    tree: &BoxTree<'_>,
    triangle: usize,
    frame: &Frame,
    limits: &Limits,
) -> Vec<WallCut> {
    let corners = scene.corners(triangle);
    let margin = Vec3::splat(limits.tolerance as f32);
    let own = &boxes[triangle];
    let query = Bounds { min: own.min - margin, max: own.max + margin };
    let mut segments: Vec<[DVec2; 2]> = tree
        .overlapping(&query)
        .into_iter()
        .map(|other| scene.corners(other as usize))
        .filter(|wall| wall.iter().filter(|p| corners.contains(p)).count() < 2)
        .filter_map(|wall| segment_in_plane(frame, wall, limits))
        .collect();
    segments.sort_by(|a, b| b[0].distance_squared(b[1]).total_cmp(&a[0].distance_squared(a[1])));
    let mut cuts: Vec<WallCut> = merge_collinear(&segments, limits);
    cuts.sort_by(|a, b| b.length().total_cmp(&a.length()));
    cuts
}

/// The stretch along which a wall's triangle meets the plane; `None` if it is no wall.
fn segment_in_plane(frame: &Frame, wall: [Vec3; 3], limits: &Limits) -> Option<[DVec2; 2]> {
    let heights = wall.map(|p| frame.height(p)).map(|h| if h.abs() <= limits.tolerance { 0.0 } else { h });
    let rise = heights.into_iter().map(f64::abs).fold(0.0, f64::max);
    if rise < limits.min_rise || frame.sine_to(wall) < MIN_SINE {
        return None;
    }
    let points = wall.map(|p| frame.plane_from_world(p));
    let mut ends = Vec::with_capacity(2);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if heights[i] == 0.0 {
            ends.push(points[i]);
        } else if heights[i] * heights[j] < 0.0 {
            ends.push(points[i].lerp(points[j], heights[i] / (heights[i] - heights[j])));
        }
    }
    let ends: [DVec2; 2] = ends.try_into().ok()?;
    (ends[0].distance(ends[1]) > limits.tolerance).then_some(ends)
}

/// Joins segments (longest first) on one line that touch each other, and keeps what is long enough.
fn merge_collinear(segments: &[[DVec2; 2]], limits: &Limits) -> Vec<WallCut> {
    let mut lines: Vec<(WallCut, Vec<[f64; 2]>)> = Vec::new();
    for segment in segments {
        let on = |line: &WallCut| segment.iter().all(|p| line.distance(*p).abs() <= limits.tolerance);
        let known = lines.iter().position(|(line, _)| on(line));
        let index = known.unwrap_or(lines.len());
        if known.is_none() {
            if lines.len() == MAX_LINES {
                continue;
            }
            lines.push((WallCut::through(*segment), Vec::new()));
        }
        let (line, stretches) = &mut lines[index];
        let [a, b] = segment.map(|p| line.along(p));
        stretches.push([a.min(b), a.max(b)]);
    }
    let mut cuts = Vec::new();
    for (line, mut stretches) in lines {
        stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
        for joined in join_stretches(&stretches, limits.tolerance) {
            cuts.push(WallCut { start: joined[0], end: joined[1], ..line });
        }
    }
    cuts.retain(|cut| cut.length() >= limits.min_length);
    cuts
}

/// Unites intervals, sorted by their beginning, that overlap or touch.
fn join_stretches(sorted: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for &[start, end] in sorted {
        match joined.last_mut() {
            Some(last) if start <= last[1] + tolerance => last[1] = last[1].max(end),
            _ => joined.push([start, end]),
        }
    }
    joined
}
