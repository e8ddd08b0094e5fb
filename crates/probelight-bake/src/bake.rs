//! The steps of a bake, in order.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use probelight_asset::BakedScene;
use probelight_math::directions::progressive_sphere;
use probelight_math::sh::Basis;
use probelight_scene::Scene;
use probelight_trace::{Progress, Tracer};
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::air_spaces::assign_outlooks;
use crate::assemble::{BakeParts, assemble};
use crate::checkpoint::{Checkpoint, FinishedGroup};
use crate::compress::Compressor;
use crate::cut::{CutScene, cut_along_walls};
use crate::group_worker::GroupWorker;
use crate::layout::fit_layout;
use crate::options::Resolved;
use crate::partition::KdRule;
use crate::point_grid::PointGrid;
use crate::probes::place_probes;
use crate::receivers::place_receivers;
use crate::relight::trace_relight_rays;
use crate::scene_light::{SceneLight, SceneParts};
use crate::sides::LitSides;
use crate::{BakeError, BakeOptions};

/// Bakes a valid scene ([`Scene::validate`]).
///
/// With a `checkpoint` path, finished parts are kept there and an earlier, interrupted bake of the same
/// scene with the same options goes on where it stopped; the file is removed on success. The result
/// depends only on scene and options, not on threads or interruptions.
///
/// # Errors
/// See [`BakeError`]; [`BakeError::Cancelled`] as soon as `progress` asks to stop.
pub fn bake(
    scene: Arc<Scene>,
    options: &BakeOptions,
    checkpoint: Option<&Path>,
    progress: &dyn Progress,
) -> Result<BakedScene, BakeError> {
    progress.begin("building the ray tracer", 1);
    let scene_hash = scene.content_hash();
    let tracer = Tracer::new(scene);
    let mut resolved = options.resolve(&tracer)?;
    let CutScene { scene, seams } =
        cut_along_walls(tracer.scene(), resolved.estimated_texel_size(tracer.scene()));
    let tracer = Tracer::new(Arc::new(scene));
    let lit_sides = LitSides::find(&tracer, resolved.smallest_spacing() * 0.5, resolved.settings.seed);
    let atlas = fit_layout(&tracer, &lit_sides, &seams, options.use_uv1, &mut resolved, progress)?;
    let mut receivers = place_receivers(&tracer, &atlas, &lit_sides);
    resolved.set_receiver_count(receivers.receivers.len());
    let probes = place_probes(&tracer, &resolved, &lit_sides, &receivers.receivers, progress)?;
    resolved.set_probe_count(probes.len());
    let directions = progressive_sphere(resolved.settings.relight_rays as usize);
    let relight_hits = trace_relight_rays(&tracer, &probes, &directions, progress)?;
    let probe_set = PointGrid::of(&probes, resolved.settings.probe_spacing * 0.5);
    assign_outlooks(&tracer, &probe_set, &directions, &relight_hits, &mut receivers.receivers);
    let texel_size = 1.0 / resolved.settings.texels_per_meter;
    receivers.points.keep_those_in_sight(&tracer, &receivers.receivers, &probe_set, texel_size);
    let light = SceneLight::prepare(
        &SceneParts { tracer: &tracer, atlas: &atlas, receivers: &receivers, probes: &probes },
        &directions,
        &relight_hits,
        &resolved.settings,
        progress,
    )?;

    let split_rule = split_rule(&resolved);
    let largest = resolved.settings.receivers_per_cluster as usize;
    let groups = split_rule.partition(&receivers.receivers, largest);
    let fingerprint = fingerprint(scene_hash, &resolved, receivers.receivers.len(), &probes);
    let worker = GroupWorker {
        tracer: &tracer,
        atlas: &atlas,
        basis: Basis::new(resolved.settings.sh_degree as usize),
        sky_basis: Basis::new(resolved.settings.sky_degree.unwrap_or(0) as usize),
        probes: &probe_set,
        receivers: &receivers.receivers,
        points: &receivers.points,
        light: &light,
        compressor: Compressor {
            settings: &resolved.settings,
            must_meet_error: resolved.must_meet_error,
            receivers: &receivers.receivers,
            split_rule,
            lightmap_width: atlas.width,
        },
    };
    let finished = gather_groups(&worker, &groups, checkpoint, fingerprint, progress)?;
    let parts = BakeParts {
        scene: Arc::clone(tracer.scene()),
        scene_hash,
        resolved,
        receivers,
        atlas,
        probes,
        directions,
        light,
    };
    Ok(BakedScene::new(assemble(parts, finished))?)
}

/// Receivers facing opposite ways are split before those half a full cluster's width apart.
fn split_rule(resolved: &Resolved) -> KdRule {
    let cluster_width =
        (resolved.settings.receivers_per_cluster as f32).sqrt() / resolved.settings.texels_per_meter;
    KdRule { meters_per_normal: 0.5 * cluster_width, by_outlook: true }
}

/// Tells bakes apart whose finished groups must not be mixed.
fn fingerprint(
    scene_hash: u64,
    resolved: &Resolved,
    receivers: usize,
    probes: &[probelight_math::glam::Vec3],
) -> u64 {
    let Resolved { settings, must_meet_error, .. } = resolved;
    let text = format!("{} {settings:?} {must_meet_error} {receivers}", env!("CARGO_PKG_VERSION"));
    let settings = xxh3_64_with_seed(text.as_bytes(), scene_hash);
    xxh3_64_with_seed(bytemuck::cast_slice(probes), settings)
}

/// Gathers and compresses all groups, in parallel, keeping the finished ones in the checkpoint.
fn gather_groups(
    worker: &GroupWorker<'_>,
    groups: &[Vec<u32>],
    checkpoint: Option<&Path>,
    fingerprint: u64,
    progress: &dyn Progress,
) -> Result<Vec<FinishedGroup>, BakeError> {
    let (checkpoint, mut known) = match checkpoint {
        Some(path) => {
            let (checkpoint, known) = Checkpoint::open(path, fingerprint)?;
            (Some(checkpoint), known)
        }
        None => (None, std::collections::HashMap::new()),
    };
    let total: usize = groups.iter().map(Vec::len).sum();
    progress.begin("gathering light", total as u64);
    let known: Vec<Option<FinishedGroup>> = (0..groups.len()).map(|g| known.remove(&(g as u32))).collect();
    let has_failed = AtomicBool::new(false);
    let finished: Result<Vec<FinishedGroup>, BakeError> = groups
        .par_iter()
        .zip(known)
        .enumerate()
        .map(|(g, (group, known))| {
            if progress.is_cancelled() || has_failed.load(Ordering::Relaxed) {
                return Err(BakeError::Cancelled);
            }
            let finished = match known {
                Some(finished) => finished,
                None => {
                    let finished = worker.bake_group(group);
                    if let Some(checkpoint) = &checkpoint {
                        checkpoint
                            .append(g as u32, &finished)
                            .inspect_err(|_| has_failed.store(true, Ordering::Relaxed))?;
                    }
                    finished
                }
            };
            progress.advance(group.len() as u64);
            Ok(finished)
        })
        .collect();
    let finished = finished?;
    if let Some(checkpoint) = checkpoint {
        checkpoint.remove();
    }
    Ok(finished)
}
