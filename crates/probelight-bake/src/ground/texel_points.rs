//! Points spread over the surface that falls into each texel.
//!
//! A texel's irradiance is the mean over its surface. Where a chart is finer than its texels, a single point
//! would stand for a ledge or for the crevice behind it, as chance has it.

use probelight_asset::NONE;
use probelight_math::glam::Vec2;
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};
use probelight_trace::{Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::Outpost;
use crate::air::limits::{
    EXPOSURE_RAYS, FULL_EXPOSURE, LEAST_EXPOSURE, PROBES_TRIED_PER_POINT, SMALLEST_EXPOSED_SHARE,
};
use crate::air::point_tree::PointTree;
use crate::ground::atlas::Atlas;
use crate::ground::atlas::barycentric_of;
use crate::ground::sample_point::SurfacePoint;
use crate::ground::site::Site;
use crate::steps::for_each_in_parallel;

/// Points are pulled this far towards the middle of their face, so that rays never start exactly on an edge
/// shared with another wall.
const INSET: f32 = 2e-3;

/// The points of all receivers' texels.
#[derive(Clone, Debug, Default)]
pub(crate) struct TexelPoints {
    points: Vec<SurfacePoint>,
    /// First point of each receiver, and the end of the last one's.
    first_points: Vec<u32>,
}

/// Points on each texel.
pub(crate) const POINTS_PER_TEXEL: u32 = 8;

impl TexelPoints {
    /// The points that count, with their exposure over a texel's width. Points that see neither the site's outlook nor
    /// one of the probes nearest to it, or that are much less exposed than others, lie under furniture that stands on
    /// the texel and must not darken what is beside it. Where they are most of the texel it lies in a gap, and all count.
    pub(crate) fn in_sight(
        self,
        tracer: &Tracer,
        sites: &[Site],
        probes: &PointTree,
        texel_size: f32,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let exposures = |r: u32| {
            let site = &sites[r as usize];
            let near = probes.nearest(site.position, PROBES_TRIED_PER_POINT);
            let outlook = site.outlook.map(|outlook| outlook.probe);
            let sees_a_probe = |point: &Outpost| {
                let mut probes = outlook.iter().chain(&near).map(|p| probes.positions[*p as usize]);
                probes.any(|probe| tracer.is_visible(point.origin, probe))
            };
            let look = |(i, point): (u32, &SurfacePoint)| {
                let point = point.outpost(tracer);
                (sees_a_probe(&point), exposure(tracer, &point, texel_size, hash_pair(site.seed, i)))
            };
            let exposed: Vec<(bool, u8)> = (0..).zip(self.of(r)).map(look).collect();
            exposures_that_count(&exposed)
        };
        let numbers = (0..sites.len() as u32).into_par_iter();
        let exposures = for_each_in_parallel("measuring exposure", numbers, progress, exposures)?;
        Ok(self.with_exposures(&exposures))
    }

    /// The points with an exposure, and that.
    fn with_exposures(&self, exposures: &[Vec<Option<u8>>]) -> Self {
        let mut counting = Self { points: Vec::new(), first_points: vec![0] };
        for (r, exposures) in (0..).zip(exposures) {
            let points = self.of(r).iter().zip(exposures);
            counting.points.extend(points.filter_map(|(p, e)| Some(SurfacePoint { exposure: (*e)?, ..*p })));
            counting.first_points.push(counting.points.len() as u32);
        }
        counting
    }

    /// Points on a receiver's texel; at least one.
    pub(crate) fn of(&self, receiver: u32) -> &[SurfacePoint] {
        let receiver = receiver as usize;
        &self.points[self.first_points[receiver] as usize..self.first_points[receiver + 1] as usize]
    }

    /// The points of texels, receiver by receiver.
    pub(crate) fn of_texels(points: &[Vec<SurfacePoint>]) -> Self {
        let ends = points.iter().scan(0, |end, points| {
            *end += points.len() as u32;
            Some(*end)
        });
        Self { first_points: std::iter::once(0).chain(ends).collect(), points: points.concat() }
    }
}

/// A place on a face: barycentric weights of the second and third corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacePoint {
    pub(crate) face: u32,
    pub(crate) barycentric: Vec2,
}

/// A part of a texel's square, and the chart that points in it are to lie on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    texel: u32,
    chart: u32,
    /// Smallest corner, texels.
    low: Vec2,
    /// Edge lengths, texels.
    size: Vec2,
}

impl Window {
    /// All of a texel.
    pub(crate) fn whole(atlas: &Atlas, texel: u32, chart: u32) -> Self {
        let low = Vec2::new((texel % atlas.width) as f32, (texel / atlas.width) as f32);
        Self { texel, chart, low, size: Vec2::ONE }
    }

    /// What lies between two corners, texels.
    pub(crate) fn within(self, (low, high): (Vec2, Vec2)) -> Self {
        let end = high.min(self.low + self.size);
        let low = low.max(self.low);
        Self { low, size: (end - low).max(Vec2::ZERO), ..self }
    }
}

/// `count` points spread over each of the given windows, as far as they lie on the window's chart.
pub(crate) fn spread_points(atlas: &Atlas, windows: &[Window], count: u32) -> Vec<Vec<FacePoint>> {
    let mut number_of_texel = vec![NONE; atlas.width as usize * atlas.height as usize];
    for (number, window) in (0..).zip(windows) {
        number_of_texel[window.texel as usize] = number;
    }
    let pattern: Vec<Vec2> = (0..count).map(|i| sobol_owen(i, 0x7e8e1)).collect();
    let mut found: Vec<Vec<(u32, FacePoint)>> = vec![Vec::new(); windows.len()];
    for (face, layout) in (0..).zip(&atlas.faces).filter(|(f, _)| atlas.face_charts[*f as usize] != NONE) {
        for (x, y) in texels_around(atlas, layout.corners) {
            let number = number_of_texel[(y * atlas.width + x) as usize];
            if number == NONE || windows[number as usize].chart != atlas.face_charts[face as usize] {
                continue;
            }
            let Window { low, size, .. } = windows[number as usize];
            for (i, offset) in (0..).zip(&pattern) {
                let at = barycentric_of(low + size * *offset, layout.corners);
                if at.x >= 0.0 && at.y >= 0.0 && at.x + at.y <= 1.0 {
                    found[number as usize].push((i, FacePoint { face, barycentric: at }));
                }
            }
        }
    }
    // Not face by face, so that any part of a texel's points covers it all.
    let in_order = |mut points: Vec<(u32, FacePoint)>| {
        points.sort_by_key(|(i, _)| *i);
        points.into_iter().map(|(_, point)| point).collect()
    };
    found.into_iter().map(in_order).collect()
}

/// Texels that a face may reach into or that lookups in it touch.
pub(crate) fn texels_around(atlas: &Atlas, corners: [Vec2; 3]) -> impl Iterator<Item = (u32, u32)> {
    let low = (corners.into_iter().reduce(Vec2::min).unwrap_or_default() - 1.0).floor().max(Vec2::ZERO);
    let high = corners.into_iter().reduce(Vec2::max).unwrap_or_default() + 1.0;
    let (x0, y0) = (low.x as u32, low.y as u32);
    let (x1, y1) = ((high.x as u32).min(atlas.width - 1), (high.y as u32).min(atlas.height - 1));
    (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| (x, y)))
}

/// A point of a face, pulled a little towards its middle.
pub(crate) fn point_on_face(atlas: &Atlas, face: u32, barycentric: Vec2) -> SurfacePoint {
    let barycentric = barycentric.lerp(Vec2::splat(1.0 / 3.0), INSET).clamp(Vec2::ZERO, Vec2::ONE);
    SurfacePoint {
        exposure: FULL_EXPOSURE,
        triangle: atlas.face_triangles[face as usize],
        barycentric,
        is_back_face: atlas.is_back_face(face),
    }
}

/// Leaves out points that are hidden while others beside them are exposed.
pub(crate) fn keep_exposed<T>(mut points: Vec<T>, exposure: impl Fn(&T) -> u8) -> Vec<T> {
    let best = points.iter().map(&exposure).max().unwrap_or(0);
    points.retain(|point| is_exposed_beside(exposure(point), best));
    points
}

/// The exposures of a texel's points (whether each sees a probe, and its exposure); `None` for those that do not count.
fn exposures_that_count(points: &[(bool, u8)]) -> Vec<Option<u8>> {
    let best = points.iter().filter(|(sees, _)| *sees).map(|(_, exposure)| *exposure).max().unwrap_or(0);
    let is_exposed = |(sees, exposure): &(bool, u8)| *sees && is_exposed_beside(*exposure, best);
    let exposed = points.iter().filter(|point| is_exposed(point)).count();
    let is_gap = (exposed as f32) < SMALLEST_EXPOSED_SHARE * points.len() as f32;
    points.iter().map(|point| (is_gap || is_exposed(point)).then_some(point.1)).collect()
}

/// Whether a point's exposure is not much less than the best of those beside it.
fn is_exposed_beside(exposure: u8, best: u8) -> bool {
    u32::from(exposure) * LEAST_EXPOSURE >= u32::from(best)
}

/// Exposure of a point, percent: the cosine-weighted share of directions that are free over `distance` metres.
/// Half of them count as all: in the corner of two walls no more than that is free, and the corner is seen as
/// well as the walls are.
fn exposure(tracer: &Tracer, point: &Outpost, distance: f32, seed: u32) -> u8 {
    let (origin, frame) = (point.origin, world_from_tangent(point.normal));
    let is_free = |i: &u32| {
        let direction = frame * cosine_hemisphere_from_square(sobol_owen(*i, seed));
        !tracer.is_occluded(&Ray { origin, direction, max_distance: distance })
    };
    let free = (0..EXPOSURE_RAYS).filter(is_free).count() as u32;
    (u32::from(FULL_EXPOSURE) * 2 * free / EXPOSURE_RAYS).clamp(1, u32::from(FULL_EXPOSURE)) as u8
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Vec3;

    use super::*;
    use crate::small_scene::SmallScene;

    #[test]
    fn hidden_points_count_where_they_are_most_of_a_texel() {
        // Under furniture: seen by no probe, or much less exposed.
        let beside_furniture = [(true, 100), (true, 60), (false, 50), (true, 10)];
        assert_eq!(exposures_that_count(&beside_furniture), [Some(100), Some(60), None, None]);
        let in_a_gap = [(true, 100), (false, 50), (false, 1), (true, 10)];
        assert_eq!(exposures_that_count(&in_a_gap), [100, 50, 1, 10].map(Some));
        assert_eq!(exposures_that_count(&[(false, 1)]), [Some(1)]);
    }

    #[test]
    fn exposure_is_full_on_open_floor_and_in_corners_and_least_under_the_lamp() {
        let scene = SmallScene::load("cornell_empty.glb");
        let exposure = |position, normal, distance| {
            let tracer = &scene.ground.tracer;
            let point = Outpost { origin: tracer.off_surface(position, normal), normal };
            exposure(tracer, &point, distance, 1)
        };
        assert_eq!(exposure(Vec3::new(2.0, 0.0, 2.0), Vec3::Y, 0.1), FULL_EXPOSURE);
        assert!(exposure(Vec3::new(0.01, 0.0, 2.0), Vec3::Y, 0.5) >= FULL_EXPOSURE / 2);
        assert_eq!(exposure(Vec3::new(2.78, 5.488, 2.8), Vec3::NEG_Y, 0.1), 1);
    }
}
