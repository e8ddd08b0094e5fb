//! Receivers: lightmap texels that hold light of their own.
//!
//! A texel belongs to a chart if its square overlaps one of the chart's faces (conservative rasterisation).
//! Points are spread over its surface; those that are open ([`crate::air`]) stay, and the one nearest to the texel's
//! centre is its sample point. Texels without an open point, inside other geometry, are invalid and are filled from
//! valid neighbours of the same chart.

use std::collections::{HashMap, VecDeque};

use probelight_asset::NONE;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::hash_pair;
use probelight_trace::{Progress, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::{Air, LitSides, Outpost};
use crate::ground::atlas::{Atlas, barycentric_of};
use crate::ground::sample_point::SurfacePoint;
use crate::ground::site::{Outlook, Site};
use crate::ground::texel_points::{
    FacePoint, POINTS_PER_TEXEL, TexelPoints, Window, point_on_face, spread_points, texels_around,
};
use crate::steps::for_each_in_parallel;

/// See [`Groundwork::unforeseen_share_of`](crate::ground::Groundwork::unforeseen_share_of).
pub(crate) const UNFORESEEN_SHARE: f32 = 0.05;

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
        tracer.off_surface(self.position, self.normal)
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

/// Points tried on texels whose first points are all hidden.
const POINTS_OF_HIDDEN_TEXELS: u32 = 64;

/// Finds the receivers of an atlas, and the open points on each one's texel; its irradiance is the mean of theirs.
pub(crate) fn place_receivers(
    air: &Air<'_>,
    atlas: &Atlas,
    lit_sides: &LitSides,
    progress: &dyn Progress,
) -> Result<(Receivers, TexelPoints), BakeError> {
    let needed = rasterize_conservatively(atlas);
    let covered: Vec<(u32, Coverage)> = needed.iter().filter(|(_, c)| c.is_covered).copied().collect();
    let finder = PointFinder { air, atlas, lit_sides, progress };
    let (receivers, points): (Vec<Receiver>, Vec<Vec<SurfacePoint>>) = covered
        .iter()
        .zip(finder.open_points(&covered)?)
        .filter_map(|(texel, open)| receiver(air.tracer(), texel, open))
        .unzip();
    let receivers = Receivers {
        dilation: dilate_charts(atlas, &needed, &receivers),
        chart_texels: covered.len() as u64,
        invalid_texels: (covered.len() - receivers.len()) as u64,
        receivers,
    };
    Ok((receivers, TexelPoints::of_texels(&points)))
}

/// The receiver of a texel at the first of its open points, and the points that its rays start from: the others, or
/// that one where there are no others.
fn receiver(
    tracer: &Tracer,
    (texel, coverage): &(u32, Coverage),
    mut open: Vec<SurfacePoint>,
) -> Option<(Receiver, Vec<SurfacePoint>)> {
    let point = *open.first()?;
    let SurfacePoint { triangle, barycentric, is_back_face, .. } = point;
    let (position, normal) = (point.position(tracer), point.normal(tracer));
    if open.len() > 1 {
        open.remove(0);
    }
    let (texel, chart) = (*texel, coverage.chart);
    Some((Receiver { texel, chart, triangle, barycentric, is_back_face, position, normal }, open))
}

/// Finds the points of texels that are open.
struct PointFinder<'a> {
    air: &'a Air<'a>,
    atlas: &'a Atlas,
    lit_sides: &'a LitSides,
    progress: &'a dyn Progress,
}

impl PointFinder<'_> {
    /// Open points of each texel, that at its middle or nearest to it first. None lies inside a solid.
    fn open_points(&self, texels: &[(u32, Coverage)]) -> Result<Vec<Vec<SurfacePoint>>, BakeError> {
        let middle = |(_, coverage): &(u32, Coverage)| vec![self.point(coverage.face, coverage.nearest)];
        let by_any_way = |point: &Outpost, seed| self.air.is_open(point, seed);
        let whole = |(texel, c): &(u32, Coverage)| Window::whole(self.atlas, *texel, c.chart);
        let mut open = self.open_among(texels, whole, POINTS_PER_TEXEL, middle, by_any_way)?;
        let hidden: Vec<usize> = (0..texels.len()).filter(|i| open[*i].is_empty()).collect();
        let hidden_texels: Vec<(u32, Coverage)> = hidden.iter().map(|i| texels[*i]).collect();
        let rims = self.rims();
        let corners_and_rims = |(texel, coverage): &(u32, Coverage)| {
            let centre = self.centre(*texel);
            let corners = self.atlas.faces[coverage.face as usize].corners;
            let near = |(x, y)| nearest_in_triangle(centre + Vec2::new(x, y) * 0.4, corners);
            let at_corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(near);
            let at_corners = at_corners.into_iter().map(|point| self.point(coverage.face, point));
            at_corners.chain(rims.get(texel).into_iter().flatten().copied()).collect()
        };
        let at_once = |point: &Outpost, _| self.air.sees(point);
        // Where a chart is much smaller than a texel, points spread over all of the texel would miss it.
        let charts = self.atlas.chart_bounds();
        let on_chart = |texel: &(u32, Coverage)| whole(texel).within(charts[texel.1.chart as usize]);
        let count = POINTS_OF_HIDDEN_TEXELS;
        let found = self.open_among(&hidden_texels, on_chart, count, corners_and_rims, at_once)?;
        for (i, mut points) in hidden.into_iter().zip(found) {
            points.truncate(POINTS_PER_TEXEL as usize);
            open[i] = points;
        }
        Ok(open)
    }

    /// The open ones among `count` points spread over each texel's window and among its special points, which come
    /// first.
    fn open_among(
        &self,
        texels: &[(u32, Coverage)],
        window: impl Fn(&(u32, Coverage)) -> Window,
        count: u32,
        special: impl Fn(&(u32, Coverage)) -> Vec<SurfacePoint> + Sync,
        is_open: impl Fn(&Outpost, u32) -> bool + Sync,
    ) -> Result<Vec<Vec<SurfacePoint>>, BakeError> {
        let tracer = self.air.tracer();
        let windows: Vec<Window> = texels.iter().map(window).collect();
        let spread = spread_points(self.atlas, &windows, count);
        let open = |(texel, spread): (&(u32, Coverage), Vec<FacePoint>)| {
            let middle = self.point(texel.1.face, texel.1.nearest).position(tracer);
            let spread = spread.into_iter().map(|p| point_on_face(self.atlas, p.face, p.barycentric));
            let points = (0..).zip(special(texel).into_iter().chain(spread));
            let points = points.filter(|(i, point)| is_open(&point.outpost(tracer), hash_pair(texel.0, *i)));
            let mut points: Vec<SurfacePoint> = points.map(|(_, point)| point).collect();
            let distance = |p: &SurfacePoint| p.position(tracer).distance_squared(middle);
            let nearest =
                (0..points.len()).min_by(|a, b| distance(&points[*a]).total_cmp(&distance(&points[*b])));
            if let Some(nearest) = nearest {
                points[..=nearest].rotate_right(1);
            }
            points
        };
        let texels = texels.par_iter().zip(spread);
        for_each_in_parallel("looking for lit texels", texels, self.progress, open)
    }

    /// Points of rims, by the texel in which they lie.
    fn rims(&self) -> HashMap<u32, Vec<SurfacePoint>> {
        let mut rims: HashMap<u32, Vec<SurfacePoint>> = HashMap::new();
        for face in
            (0..self.atlas.faces.len() as u32).filter(|face| self.atlas.face_charts[*face as usize] != NONE)
        {
            let triangle = self.atlas.face_triangles[face as usize];
            for point in self.lit_sides.rim(triangle, self.atlas.is_back_face(face)) {
                let texel = self.atlas.texel_at(self.atlas.faces[face as usize].position(*point));
                rims.entry(texel).or_default().push(point_on_face(self.atlas, face, *point));
            }
        }
        rims
    }

    /// The middle of a texel in the lightmap, texels.
    fn centre(&self, texel: u32) -> Vec2 {
        Vec2::new((texel % self.atlas.width) as f32 + 0.5, (texel / self.atlas.width) as f32 + 0.5)
    }

    /// The point of a face at a position in the lightmap.
    fn point(&self, face: u32, position: Vec2) -> SurfacePoint {
        let barycentric = barycentric_of(position, self.atlas.faces[face as usize].corners);
        point_on_face(self.atlas, face, barycentric)
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
