//! Convex pieces of a triangle, in its plane.

use probelight_math::glam::{DVec2, DVec3, Vec3};

use super::wall_cuts::WallCut;

/// Most pieces of one triangle.
const MAX_PIECES: usize = 64;

/// Coordinates in a triangle's plane: origin at the first corner, counter-clockwise seen from the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    normal: DVec3,
}

impl Frame {
    pub(super) fn of(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
        let x = (b - a).normalize_or(DVec3::X);
        Self { origin: a, x, y: normal.cross(x), normal }
    }

    pub(super) fn plane_from_world(&self, point: Vec3) -> DVec2 {
        let relative = point.as_dvec3() - self.origin;
        DVec2::new(self.x.dot(relative), self.y.dot(relative))
    }

    /// Signed distance from the plane.
    pub(super) fn height(&self, point: Vec3) -> f64 {
        self.normal.dot(point.as_dvec3() - self.origin)
    }

    /// Sine of the angle to another triangle's plane.
    pub(super) fn sine_to(&self, other: [Vec3; 3]) -> f64 {
        self.normal.cross(Self::of(other).normal).length()
    }
}

/// A triangle divided into convex polygons that share their points. Where one polygon has a corner on
/// another's edge, the other has the same point as a straight corner.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    /// The triangle's corners come first.
    pub(super) points: Vec<DVec2>,
    /// Counter-clockwise rings of indices into `points`.
    pub(super) polygons: Vec<Vec<u32>>,
}

/// Where a line crosses a ring: at one of its corners, or on the edge after one.
#[derive(Clone, Copy)]
enum Crossing {
    Corner(usize),
    Edge(usize, DVec2),
}

impl Pieces {
    pub(super) fn whole(corners: [DVec2; 3]) -> Self {
        Self { points: corners.to_vec(), polygons: vec![vec![0, 1, 2]] }
    }

    /// Triangles that the polygons will become.
    pub(super) fn triangle_count(&self) -> usize {
        self.polygons.iter().map(|ring| ring.len() - 2).sum()
    }

    /// Cuts, along the whole line, each polygon on which the wall stands. Pieces thinner than `tolerance`
    /// are not made.
    pub(super) fn cut(&mut self, wall: &WallCut, tolerance: f64) {
        for polygon in 0..self.polygons.len() {
            if self.polygons.len() == MAX_PIECES {
                return;
            }
            if let Some(crossings) = self.find_crossings(polygon, wall, tolerance)
                && self.wall_overlaps_chord(polygon, crossings, wall, tolerance)
            {
                self.split(polygon, crossings, wall, tolerance);
            }
        }
    }

    fn find_crossings(&self, polygon: usize, wall: &WallCut, tolerance: f64) -> Option<[Crossing; 2]> {
        let corners: Vec<DVec2> = self.polygons[polygon].iter().map(|p| self.points[*p as usize]).collect();
        let distances: Vec<f64> = corners
            .iter()
            .map(|p| wall.distance(*p))
            .map(|d| if d.abs() <= tolerance { 0.0 } else { d })
            .collect();
        let count = corners.len();
        let off_line: Vec<usize> = (0..count).filter(|i| distances[*i] != 0.0).collect();
        let mut crossings = Vec::with_capacity(2);
        for (position, &i) in off_line.iter().enumerate() {
            let j = off_line[(position + 1) % off_line.len()];
            if distances[i] * distances[j] > 0.0 {
                continue;
            }
            let after = (i + 1) % count;
            crossings.push(if after == j {
                let share = distances[i] / (distances[i] - distances[j]);
                Crossing::Edge(i, corners[i].lerp(corners[j], share))
            } else {
                Crossing::Corner(after)
            });
        }
        crossings.try_into().ok()
    }

    fn wall_overlaps_chord(
        &self,
        polygon: usize,
        crossings: [Crossing; 2],
        wall: &WallCut,
        tolerance: f64,
    ) -> bool {
        let [a, b] = crossings.map(|crossing| match crossing {
            Crossing::Corner(corner) => self.points[self.polygons[polygon][corner] as usize],
            Crossing::Edge(_, point) => point,
        });
        let [a, b] = [wall.along(a), wall.along(b)];
        a.max(b).min(wall.end) - a.min(b).max(wall.start) > tolerance
    }

    /// Splits a polygon between two crossings, unless a half would be too thin.
    fn split(&mut self, polygon: usize, crossings: [Crossing; 2], wall: &WallCut, tolerance: f64) {
        let before = self.clone();
        let mut ends = crossings.map(|_| 0);
        for (end, crossing) in crossings.into_iter().enumerate() {
            ends[end] = match crossing {
                Crossing::Corner(corner) => before.polygons[polygon][corner],
                Crossing::Edge(corner, point) => {
                    let ring = &before.polygons[polygon];
                    self.insert_on_edge(ring[corner], ring[(corner + 1) % ring.len()], point)
                }
            };
        }
        let ring = &self.polygons[polygon];
        let position = |point: u32| ring.iter().position(|p| *p == point).unwrap_or(0);
        let (first, last) =
            (position(ends[0]).min(position(ends[1])), position(ends[0]).max(position(ends[1])));
        let inner = ring[first..=last].to_vec();
        let outer = [&ring[last..], &ring[..=first]].concat();
        if self.width(&inner).min(self.width(&outer)) < tolerance {
            *self = before;
            return;
        }
        let (from, to) = (ring[last], ring[first]);
        self.polygons[polygon] = inner;
        self.polygons.push(outer);
        self.mark_wall_ends(from, to, wall, tolerance);
    }

    /// Puts points where the wall begins and ends inside the new edge.
    fn mark_wall_ends(&mut self, from: u32, to: u32, wall: &WallCut, tolerance: f64) {
        let [start, end] = [from, to].map(|p| wall.along(self.points[p as usize]));
        let mut stops = [wall.start, wall.end];
        if start > end {
            stops.reverse();
        }
        let mut last = from;
        for stop in stops {
            if (stop - start).abs().min((stop - end).abs()) > tolerance
                && (start.min(end)..start.max(end)).contains(&stop)
            {
                last = self.insert_on_edge(last, to, wall.at(stop));
            }
        }
    }

    /// Adds a point on the edge between two points, to all polygons that have this edge.
    pub(super) fn insert_on_edge(&mut self, a: u32, b: u32, point: DVec2) -> u32 {
        let index = self.points.len() as u32;
        self.points.push(point);
        for ring in &mut self.polygons {
            let count = ring.len();
            let after = (0..count).find(|&i| {
                let edge = (ring[i], ring[(i + 1) % count]);
                edge == (a, b) || edge == (b, a)
            });
            if let Some(i) = after {
                ring.insert(i + 1, index);
            }
        }
        index
    }

    /// The smallest extent of a convex ring across one of its edges.
    fn width(&self, ring: &[u32]) -> f64 {
        let corner = |i: usize| self.points[ring[i % ring.len()] as usize];
        let extent_across = |i: usize| {
            let direction = (corner(i + 1) - corner(i)).normalize_or_zero();
            (0..ring.len()).map(|j| direction.perp_dot(corner(j) - corner(i)).abs()).fold(0.0, f64::max)
        };
        (0..ring.len()).map(extent_across).fold(f64::INFINITY, f64::min)
    }

    /// Triangulates a polygon so that the thinnest triangle is as thick as possible (dynamic programming
    /// over the ring's intervals, Klincsek 1980); `None` if a triangle would have no area.
    pub(super) fn triangulate(&self, ring: &[u32]) -> Option<Vec<[u32; 3]>> {
        let count = ring.len();
        // Thickness of the thinnest triangle between corners i..=j, and the corner opposite edge (i, j).
        let mut best = vec![(f64::INFINITY, 0); count * count];
        for span in 2..count {
            for i in 0..count - span {
                let j = i + span;
                let thickness = |k: usize| {
                    let own = self.altitude(ring[i], ring[k], ring[j]);
                    own.min(best[i * count + k].0).min(best[k * count + j].0)
                };
                best[i * count + j] = (i + 1..j)
                    .map(|k| (thickness(k), k))
                    .fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a });
            }
        }
        if best[count - 1].0 <= 0.0 {
            return None;
        }
        let mut triangles = Vec::with_capacity(count - 2);
        let mut open = vec![(0, count - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i >= 2 {
                let k = best[i * count + j].1;
                triangles.push([ring[i], ring[k], ring[j]]);
                open.extend([(k, j), (i, k)]);
            }
        }
        Some(triangles)
    }

    /// Smallest altitude of a triangle; not positive if it is not counter-clockwise.
    fn altitude(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|p| self.points[p as usize]);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        (b - a).perp_dot(c - a) / longest.max(f64::MIN_POSITIVE)
    }
}
