//! Receivers: lightmap texels that hold light of their own.
//!
//! A texel belongs to a chart if its square overlaps one of the chart's faces (conservative rasterisation).
//! Its sample point is the texel's centre, or the covered point nearest to it. Texels whose sample point
//! lies inside other geometry try other points of their square; those that find none are invalid and are
//! filled from valid neighbours of the same chart.

use std::collections::VecDeque;

use probelight_asset::NONE;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_trace::{Ray, Tracer};
use rayon::prelude::*;

use crate::atlas::Atlas;
use crate::sides::LitSides;
use crate::site::{Outlook, Site};
use crate::texel_points::{SamplePoint, TexelPoints, point_on_face, texels_around};

/// A place that gathers light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Receiver {
    /// Index of its texel in the stacked image.
    pub(crate) texel: u32,
    /// Chart of the texel.
    pub(crate) chart: u32,
    /// Triangle it lies on.
    pub(crate) triangle: u32,
    /// Where on the triangle: barycentric weights of the second and third corner.
    pub(crate) barycentric: Vec2,
    /// Whether it belongs to the triangle's back face.
    pub(crate) is_back_face: bool,
    /// Sample point on the surface, metres.
    pub(crate) position: Vec3,
    /// Unit geometric normal on the lit side.
    pub(crate) normal: Vec3,
}

impl Receiver {
    /// Where rays from the receiver start: its sample point, moved off the surface.
    pub(crate) fn ray_origin(&self, tracer: &Tracer) -> Vec3 {
        self.position + self.normal * tracer.offset()
    }

    /// The receiver as a place that gathers light. Texels whose coordinates both have k trailing zero bits belong to
    /// lightmap level k (\[SED\] §5.3).
    pub(crate) fn site(&self, outlook: Option<Outlook>, lightmap_width: u32) -> Site {
        let (x, y) = (self.texel % lightmap_width, self.texel / lightmap_width);
        let level = (x | y).trailing_zeros();
        Site { seed: self.texel, level, position: self.position, normal: self.normal, outlook }
    }
}

/// All receivers, in texel order, and how to fill the texels around them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Receivers {
    pub(crate) receivers: Vec<Receiver>,
    /// Points on each receiver's texel; its irradiance is the mean of theirs.
    pub(crate) points: TexelPoints,
    /// (texel, receiver texel of the same chart to copy from).
    pub(crate) dilation: Vec<[u32; 2]>,
    /// Chart texels, valid or not.
    pub(crate) chart_texels: u64,
    /// Chart texels inside geometry.
    pub(crate) invalid_texels: u64,
}

/// A texel that a chart needs.
#[derive(Clone, Copy, Debug)]
struct Coverage {
    face: u32,
    chart: u32,
    /// Whether the chart reaches into the texel's square; otherwise only bilinear lookups do.
    is_covered: bool,
    /// Squared distance from the texel's centre to the face, texels².
    squared_distance: f32,
    /// Covered point nearest to the centre, texels.
    nearest: Vec2,
}

impl Coverage {
    /// Covering a texel counts more than touching it; otherwise the nearer face counts.
    fn is_preferred_to(&self, other: &Self) -> bool {
        (!self.is_covered, self.squared_distance) < (!other.is_covered, other.squared_distance)
    }
}

/// Rays that decide whether a sample point lies inside a solid, and the share of unlit sides above which it
/// does.
const VALIDITY_RAYS: u32 = 48;
const MAX_UNLIT_SHARE: f32 = 0.3;

/// Finds the receivers of an atlas.
pub(crate) fn place_receivers(tracer: &Tracer, atlas: &Atlas, lit_sides: &LitSides) -> Receivers {
    let needed = rasterize_conservatively(atlas);
    let covered: Vec<&(u32, Coverage)> = needed.iter().filter(|(_, c)| c.is_covered).collect();
    let placed: Vec<Option<Receiver>> = covered
        .par_iter()
        .map(|(texel, coverage)| find_valid_sample(tracer, atlas, lit_sides, *texel, coverage))
        .collect();
    let receivers: Vec<Receiver> = placed.iter().flatten().copied().collect();
    Receivers {
        points: TexelPoints::spread(tracer, atlas, &receivers),
        dilation: dilate_charts(atlas, &needed, &receivers),
        chart_texels: covered.len() as u64,
        invalid_texels: (covered.len() - receivers.len()) as u64,
        receivers,
    }
}

/// Number of chart texels at this layout: what the receiver count follows.
pub(crate) fn count_chart_texels(atlas: &Atlas) -> usize {
    rasterize_conservatively(atlas).iter().filter(|(_, c)| c.is_covered).count()
}

/// Texels that a chart covers or that bilinear lookups in it touch, in texel order, each with the face
/// nearest to its centre.
///
/// A lookup touches the texels whose centre is less than one texel away along both axes: those whose
/// square, grown to twice its size, overlaps the chart.
fn rasterize_conservatively(atlas: &Atlas) -> Vec<(u32, Coverage)> {
    let mut nearest: Vec<Option<Coverage>> = vec![None; atlas.width as usize * atlas.height as usize];
    for (face, layout) in atlas.faces.iter().enumerate() {
        let chart = atlas.face_charts[face];
        if chart == NONE {
            continue;
        }
        let corners = layout.corners;
        for (x, y) in texels_around(atlas, corners) {
            let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            if !square_overlaps_triangle(centre, 1.0, corners) {
                continue;
            }
            let point = nearest_in_triangle(centre, corners);
            let candidate = Coverage {
                face: face as u32,
                chart,
                is_covered: square_overlaps_triangle(centre, 0.5, corners),
                squared_distance: point.distance_squared(centre),
                nearest: point,
            };
            let slot = &mut nearest[(y * atlas.width + x) as usize];
            if slot.is_none_or(|best| candidate.is_preferred_to(&best)) {
                *slot = Some(candidate);
            }
        }
    }
    nearest.into_iter().enumerate().filter_map(|(texel, c)| Some((texel as u32, c?))).collect()
}

/// Separating-axis test of a square with edges `2 · half` around `centre` against a triangle
/// (Akenine-Möller 2001).
fn square_overlaps_triangle(centre: Vec2, half: f32, corners: [Vec2; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p - centre);
    let separates = |axis: Vec2| {
        let (pa, pb, pc) = (axis.dot(a), axis.dot(b), axis.dot(c));
        let radius = half * (axis.x.abs() + axis.y.abs());
        pa.min(pb).min(pc) > radius || pa.max(pb).max(pc) < -radius
    };
    let axes = [Vec2::X, Vec2::Y, (b - a).perp(), (c - b).perp(), (a - c).perp()];
    !axes.into_iter().any(separates)
}

/// The point of a triangle nearest to `point`.
fn nearest_in_triangle(point: Vec2, corners: [Vec2; 3]) -> Vec2 {
    let [a, b, c] = corners;
    let barycentric = barycentric_of(point, corners);
    if barycentric.x >= 0.0 && barycentric.y >= 0.0 && barycentric.x + barycentric.y <= 1.0 {
        return point;
    }
    let on_edge = |from: Vec2, to: Vec2| {
        let edge = to - from;
        let t = ((point - from).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        from + edge * t
    };
    [on_edge(a, b), on_edge(b, c), on_edge(c, a)]
        .into_iter()
        .min_by(|p, q| p.distance_squared(point).total_cmp(&q.distance_squared(point)))
        .unwrap_or(a)
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

/// The first sample point of the texel that lies in open air.
fn find_valid_sample(
    tracer: &Tracer,
    atlas: &Atlas,
    lit_sides: &LitSides,
    texel: u32,
    covered: &Coverage,
) -> Option<Receiver> {
    let corners = atlas.faces[covered.face as usize].corners;
    let centre = Vec2::new((texel % atlas.width) as f32 + 0.5, (texel / atlas.width) as f32 + 0.5);
    let others = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
        .map(|(x, y)| nearest_in_triangle(centre + Vec2::new(x, y) * 0.4, corners));
    std::iter::once(covered.nearest)
        .chain(others)
        .map(|point| receiver_at(tracer, atlas, texel, covered.face, point))
        .find(|receiver| !is_inside_solid(tracer, lit_sides, receiver))
}

/// The receiver of a texel whose sample point is at lightmap position `point` of a face.
fn receiver_at(tracer: &Tracer, atlas: &Atlas, texel: u32, face: u32, point: Vec2) -> Receiver {
    let barycentric = barycentric_of(point, atlas.faces[face as usize].corners);
    let SamplePoint { triangle, barycentric, position, normal, .. } =
        point_on_face(tracer, atlas, face, barycentric);
    let (chart, is_back_face) = (atlas.face_charts[face as usize], atlas.is_back_face(face));
    Receiver { texel, chart, triangle, barycentric, is_back_face, position, normal }
}

/// Whether a place sees so many unlit sides that it must lie inside a solid.
fn is_inside_solid(tracer: &Tracer, lit_sides: &LitSides, receiver: &Receiver) -> bool {
    let world_from_local = world_from_tangent(receiver.normal);
    let origin = receiver.ray_origin(tracer);
    let unlit = (0..VALIDITY_RAYS)
        .filter(|ray| {
            let u = sobol_owen(*ray, hash_pair(receiver.texel, 5));
            let direction = world_from_local * cosine_hemisphere_from_square(u);
            tracer.closest_hit(&Ray::new(origin, direction)).is_some_and(|hit| !lit_sides.is_lit(&hit))
        })
        .count();
    unlit as f32 > MAX_UNLIT_SHARE * VALIDITY_RAYS as f32
}

/// Sources for the needed texels without a receiver: the nearest receiver of the same chart, found by
/// growing outwards from the receivers through the chart's texels.
fn dilate_charts(atlas: &Atlas, needed: &[(u32, Coverage)], receivers: &[Receiver]) -> Vec<[u32; 2]> {
    let texel_count = atlas.width as usize * atlas.height as usize;
    let mut source = vec![NONE; texel_count];
    let mut chart_of = vec![NONE; texel_count];
    for (texel, coverage) in needed {
        chart_of[*texel as usize] = coverage.chart;
    }
    let mut front: VecDeque<u32> = receivers.iter().map(|r| r.texel).collect();
    for texel in &front {
        source[*texel as usize] = *texel;
    }
    let mut dilation = Vec::new();
    while let Some(texel) = front.pop_front() {
        for neighbour in neighbours(texel, atlas.width, atlas.height) {
            let same_chart = chart_of[neighbour as usize] == chart_of[texel as usize];
            if same_chart && source[neighbour as usize] == NONE {
                source[neighbour as usize] = source[texel as usize];
                dilation.push([neighbour, source[texel as usize]]);
                front.push_back(neighbour);
            }
        }
    }
    dilation.sort_unstable();
    dilation
}

/// The up to eight texels around one, edge neighbours first.
fn neighbours(texel: u32, width: u32, height: u32) -> impl Iterator<Item = u32> {
    let (x, y) = ((texel % width) as i32, (texel / width) as i32);
    [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)].into_iter().filter_map(
        move |(dx, dy)| {
            let (x, y) = (x + dx, y + dy);
            (x >= 0 && y >= 0 && x < width as i32 && y < height as i32).then(|| (y as u32) * width + x as u32)
        },
    )
}
