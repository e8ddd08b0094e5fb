//! How long the CPU plans frames in which much moves.

use std::time::{Duration, Instant};

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_math::sampling::Rng;
use probelight_runtime::{FrameInput, FramePlan, LodPreset, Planner, View};
use probelight_scene::Bounds;

/// How wide the objects are, metres.
const WIDTH: f32 = 0.5;

/// Times of as many frames, shortest first: by the levels of detail of `medium`, seen from the middle, with objects that
/// are elsewhere in each frame.
pub(crate) fn planning_times(baked: &BakedScene, objects: u32, frames: u32) -> Vec<Duration> {
    let bounds = bounds_of_clusters(baked);
    let view = View { position: bounds.min.midpoint(bounds.max), direction: Vec3::X };
    let settings = LodPreset::Medium.settings();
    let (mut planner, mut plan) = (Planner::new(baked), FramePlan::full(baked));
    let mut rng = Rng::new(u64::from(objects), 0);
    let mut place = || {
        let min = bounds.min + bounds.size() * rng.next_vec2().extend(rng.next_f32()) - 0.5 * WIDTH;
        Bounds { min, max: min + WIDTH }
    };
    let mut time = |_| {
        let boxes: Vec<Bounds> = (0..objects).map(|_| place()).collect();
        let input = FrameInput { view: Some(view), active_boxes: &boxes, ..FrameInput::default() };
        let start = Instant::now();
        planner.plan(baked, &settings, &input, &mut plan);
        start.elapsed()
    };
    let mut times: Vec<Duration> = (0..frames).map(&mut time).collect();
    times.sort_unstable();
    times
}

/// A box around all clusters, metres.
pub(crate) fn bounds_of_clusters(baked: &BakedScene) -> Bounds {
    Bounds::of(baked.clusters.iter().flat_map(|cluster| [cluster.bounds.min, cluster.bounds.max]))
}
