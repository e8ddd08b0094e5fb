//! The steps of a bake, in order.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use probelight_asset::{BakedScene, FORMAT_VERSION};
use probelight_scene::Scene;
use probelight_trace::Progress;
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::assemble::assemble;
use crate::byte_budget::price_within;
use crate::checkpoint::{Checkpoint, FinishedGroup, refuse_foreign_file};
use crate::ground::{Groundwork, prepare};
use crate::group_worker::GroupWorker;
use crate::light::SceneLight;
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
    checkpoint.map_or(Ok(()), refuse_foreign_file)?;
    let mut ground = prepare(scene, options, progress)?;
    let light = SceneLight::prepare(&ground, progress)?;
    let groups = ground.groups();
    // The one setting that only the light can tell.
    if let Some(budget) = ground.byte_budget {
        let worker = GroupWorker::new(&ground, &light);
        ground.settings.byte_price = price_within(budget, &worker, &groups, progress)?;
    }
    let finished = bake_groups(&GroupWorker::new(&ground, &light), &groups, checkpoint, progress)?;
    Ok(BakedScene::new(assemble(ground, light, &finished))?)
}

/// Counts changes of the bake after which finished groups of before must not be used.
const REVISION: u32 = 8;

/// Tells bakes apart whose finished groups must not be mixed.
fn fingerprint(ground: &Groundwork) -> u64 {
    let Groundwork { scene_hash, settings, error, sites, probes, .. } = ground;
    let revision = (env!("CARGO_PKG_VERSION"), FORMAT_VERSION, REVISION);
    let text = format!("{revision:?} {settings:?} {error:?} {}", sites.len());
    let settings = xxh3_64_with_seed(text.as_bytes(), *scene_hash);
    let positions = probes.positions.iter().flat_map(|position| position.to_array());
    let positions: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    xxh3_64_with_seed(&positions, settings)
}

/// Gathers and compresses all groups, in parallel, keeping the finished ones in the checkpoint.
fn bake_groups(
    worker: &GroupWorker<'_>,
    groups: &[Vec<u32>],
    checkpoint: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Vec<FinishedGroup>, BakeError> {
    let (checkpoint, mut known) = match checkpoint {
        Some(path) => {
            let (checkpoint, known) = Checkpoint::open(path, fingerprint(worker.ground))?;
            (Some(checkpoint), known)
        }
        None => (None, HashMap::new()),
    };
    let total: usize = groups.iter().map(Vec::len).sum();
    progress.begin("gathering light", total as u64);
    let known: Vec<Option<FinishedGroup>> = (0..groups.len()).map(|g| known.remove(&(g as u32))).collect();
    let has_failed = AtomicBool::new(false);
    let bake_group = |(g, (group, known)): (usize, (&Vec<u32>, Option<FinishedGroup>))| {
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
    };
    let finished: Result<Vec<FinishedGroup>, BakeError> =
        groups.par_iter().zip(known).enumerate().map(bake_group).collect();
    let finished = finished?;
    if let Some(checkpoint) = checkpoint {
        checkpoint.remove();
    }
    Ok(finished)
}
