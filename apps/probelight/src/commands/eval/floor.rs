//! What an ideal lightmap of the same texels would say at reference points: the floor under the errors of any lightmap.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use probelight_asset::{BakedScene, NONE};
use probelight_eval::{PointKind, ReferencePoint, ReferencePoints};
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_u32, sobol_owen, world_from_tangent};
use probelight_runtime::{IrradianceLightmap, lightmap_position};
use probelight_scene::Setup;
use probelight_trace::{PathTracer, Ray, Tracer};
use rayon::prelude::*;

use crate::console::Console;
use crate::movers::Movers;

/// Points along a texel's edge at which its mean is taken.
const POINTS_PER_EDGE: u32 = 4;

/// The same for texels of which none of those is on an open surface: slivers of charts, and texels almost covered.
const POINTS_PER_EDGE_OF_SLIVERS: u32 = 16;

/// Rays that tell whether a point lies inside a solid.
const RAYS_PER_POINT: u32 = 16;

/// What an ideal lightmap says at each reference point, W/m²: every texel holds the mean of the irradiance on its
/// surface, and lookups are bilinear. Both are the same but for their noise, which is independent. `None` for points in
/// free space, without a place in the lightmap, or beside texels without any open surface.
pub(super) type IdealPredictions = [Vec<Option<Vec3>>; 2];

/// Traces `paths` paths for each texel that a lookup at a reference point on a surface reads.
pub(super) fn trace_ideal_lightmap(
    baked: &BakedScene,
    setup: &Setup,
    movers: &Movers,
    reference: &ReferencePoints,
    paths: u32,
    console: &Console,
) -> anyhow::Result<IdealPredictions> {
    let tracer = Tracer::new(Arc::clone(&baked.scene));
    let position = |point: &ReferencePoint| match point.kind {
        PointKind::Surface => lightmap_position(&tracer, &baked.lightmap, point.position, point.normal),
        PointKind::FreeSpace => None,
    };
    let positions: Vec<Option<Option<Vec2>>> = reference.points.par_iter().map(position).collect();
    let receivers = baked.receivers_of_texels();
    // The texels whose light a lookup is made of, each that of a receiver, and their weights.
    let footprint = |at: Vec2| {
        let texels = IrradianceLightmap::footprint([baked.lightmap.width, baked.lightmap.height], at);
        let read = texels.into_iter().filter(|(_, weight)| *weight > 0.0);
        read.map(|(texel, weight)| {
            let source = baked.receiver_texels.get(receivers[texel as usize] as usize);
            (source.copied().unwrap_or(NONE), weight)
        })
    };
    let lit = positions.iter().filter_map(|position| position.flatten());
    let wanted: BTreeSet<u32> = lit.flat_map(footprint).map(|(texel, _)| texel).collect();
    let surface = open_points(baked, &tracer, &wanted);

    let scene = movers.traced_scene(setup, Arc::clone(&baked.scene))?;
    let tracer = PathTracer::new(Arc::new(Tracer::new(scene)), setup.lighting.clone());
    let mut halves = [Vec::new(), Vec::new()];
    for (seed, predictions) in (0..).zip(&mut halves) {
        let means = trace_means(&tracer, &surface, paths / 2, seed, console)?;
        let predict = |position: &Option<Option<Vec2>>| match (*position)? {
            None => Some(Vec3::ZERO),
            Some(at) => footprint(at).map(|(texel, weight)| Some(*means.get(&texel)? * weight)).sum(),
        };
        *predictions = positions.iter().map(predict).collect();
    }
    Ok(halves)
}

/// Both together.
pub(super) fn mean_of_halves([first, second]: &IdealPredictions) -> Vec<Option<Vec3>> {
    first.iter().zip(second).map(|(a, b)| Some(0.5 * ((*a)? + (*b)?))).collect()
}

/// Points spread over the open surface of each texel, with their normals.
fn open_points(
    baked: &BakedScene,
    tracer: &Tracer,
    wanted: &BTreeSet<u32>,
) -> BTreeMap<u32, Vec<(Vec3, Vec3)>> {
    let mut points = points_on_texels(baked, tracer, wanted, POINTS_PER_EDGE);
    let left: BTreeSet<u32> = wanted.iter().filter(|texel| !points.contains_key(texel)).copied().collect();
    points.append(&mut points_on_texels(baked, tracer, &left, POINTS_PER_EDGE_OF_SLIVERS));
    points
}

fn points_on_texels(
    baked: &BakedScene,
    tracer: &Tracer,
    wanted: &BTreeSet<u32>,
    per_edge: u32,
) -> BTreeMap<u32, Vec<(Vec3, Vec3)>> {
    let layout = &baked.lightmap;
    let triangles = 0..layout.back_faces.len() as u32;
    let sides: Vec<(u32, bool)> =
        triangles.flat_map(|triangle| [(triangle, false), (triangle, true)]).collect();
    let on_side = |&(triangle, is_back_face): &(u32, bool)| {
        let face = layout.face(triangle, is_back_face);
        let points = face.into_iter().flat_map(|face| face.points(per_edge));
        let wanted = points.filter_map(|(position, barycentric)| {
            let texel = layout.texel_at(position);
            wanted.contains(&texel).then_some((texel, barycentric))
        });
        let normal = tracer.side_normal(triangle, is_back_face);
        let place =
            |(texel, barycentric)| (texel, tracer.scene().position(triangle as usize, barycentric), normal);
        let open =
            wanted.map(place).filter(|(_, position, normal)| is_open(baked, tracer, *position, *normal));
        open.collect::<Vec<_>>()
    };
    let mut points: BTreeMap<u32, Vec<(Vec3, Vec3)>> = BTreeMap::new();
    for (texel, position, normal) in sides.par_iter().flat_map_iter(on_side).collect::<Vec<_>>() {
        points.entry(texel).or_default().push((position, normal));
    }
    points
}

/// Whether a point of a surface is not inside a solid: most of what it sees has light.
fn is_open(baked: &BakedScene, tracer: &Tracer, position: Vec3, normal: Vec3) -> bool {
    let to_world = world_from_tangent(normal);
    let origin = tracer.off_surface(position, normal);
    let seed = hash_u32(
        position.x.to_bits() ^ position.y.to_bits().rotate_left(11) ^ position.z.to_bits().rotate_left(22),
    );
    let sees_light = |i: &u32| {
        let direction = to_world * cosine_hemisphere_from_square(sobol_owen(*i, seed));
        let hit = tracer.closest_hit(&Ray::new(origin, direction));
        hit.is_none_or(|hit| baked.lightmap.face(hit.triangle, hit.is_back_face).is_some())
    };
    (0..RAYS_PER_POINT).filter(sees_light).count() as u32 > RAYS_PER_POINT / 2
}

/// Mean irradiance of each texel's points, W/m²: what lightmaps hold of it.
fn trace_means(
    tracer: &PathTracer,
    texels: &BTreeMap<u32, Vec<(Vec3, Vec3)>>,
    paths: u32,
    seed: u64,
    console: &Console,
) -> anyhow::Result<HashMap<u32, Vec3>> {
    let mut means = HashMap::new();
    // Texels with equally many points share their paths out equally.
    let mut by_count: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for (texel, points) in texels {
        by_count.entry(points.len()).or_default().push(*texel);
    }
    for (count, of_count) in by_count {
        let points: Vec<(Vec3, Vec3)> =
            of_count.iter().flat_map(|texel| texels[texel].iter().copied()).collect();
        let each = paths.div_ceil(count as u32);
        let seed = seed << 32 | count as u64;
        let traced = tracer.irradiance_of_points(&points, each, seed, console)?;
        for (texel, points) in of_count.into_iter().zip(traced.chunks(count)) {
            let sum: Vec3 = points.iter().map(|e| e.area + e.sky + e.indirect).sum();
            means.insert(texel, sum / count as f32);
        }
    }
    console.clear_progress();
    Ok(means)
}
