//! Frames that compute less than everything, against the slow frame with the same extents.
#![cfg(feature = "cpu")]

mod support;

use std::sync::Arc;

use probelight_asset::{BakedParts, BakedScene};
use probelight_math::glam::Vec3;
use probelight_math::sampling::Rng;
use probelight_runtime::{
    ClusterExtent, FrameInput, FramePlan, LodLevel, LodSettings, Planner, ProbeExtent, Runtime, RuntimeError,
    SurfaceColors, View,
};
use probelight_scene::Bounds;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use support::slow_frame::{SlowFrame, slow_frame};
use support::{SMALL, SMALL_PAPER, Size, all_lights, checked, random_plan, random_room, stage_differences};

/// As for full frames.
const TOLERANCE: f64 = 3e-6;

/// Runs both through the plans, one a frame.
fn compare(parts: BakedParts, plans: impl Fn(&BakedScene) -> Vec<FramePlan>) {
    let baked = checked(parts);
    let mut runtime = Runtime::new(baked.clone());
    runtime.set_lighting(all_lights()).unwrap();
    let colors = SurfaceColors::of(&baked.scene);
    let mut slow = SlowFrame::dark(&baked);
    for (frame, plan) in plans(&baked).iter().enumerate() {
        runtime.step_with(plan).unwrap();
        slow = slow_frame(&baked, &all_lights(), &colors, plan, &slow);
        let differences = stage_differences(&runtime, &slow);
        assert!(differences.iter().all(|d| *d < TOLERANCE), "frame {frame}: {differences:?}");
    }
}

/// Less than everything, everything, and less again, so that there is something to keep.
fn changing_plans(baked: &BakedScene, seed: u64) -> Vec<FramePlan> {
    let mut rng = Rng::new(seed, 0);
    let first = random_plan(baked, &mut rng);
    let rest = [random_plan(baked, &mut rng), random_plan(baked, &mut rng)];
    [&[first, FramePlan::full(baked)], &rest[..]].concat()
}

#[test]
fn smaller_frames_equal_the_slow_frame() {
    compare(random_room(SMALL), |baked| changing_plans(baked, 1));
    compare(random_room(SMALL_PAPER), |baked| changing_plans(baked, 2));
    // Probes in batches, with the same extent and with several.
    let many = Size { probes: 40, rays: 100, sh_degree: 7, clusters: 30, ..SMALL };
    compare(random_room(many), |baked| changing_plans(baked, 3));
    compare(random_room(many), |baked| {
        let extent = ClusterExtent { rank: 5, columns: 60, receivers: 70, ..ClusterExtent::ALL };
        let plan = FramePlan::new(baked, |_| extent, |_| ProbeExtent { rays: 50, degree: 3 });
        vec![FramePlan::full(baked), plan]
    });
}

proptest! {
    // The same cases each time: of thousands one is off by a fifth more, where what is left of a sum is all there is.
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn any_extents_equal_the_slow_frame(seed in any::<u64>(), varied in any::<bool>(), paper in any::<bool>()) {
        let size = if paper { SMALL_PAPER } else { SMALL };
        compare(random_room(Size { varied, ..size }), |baked| changing_plans(baked, seed));
    }
}

/// The slow frame with one more of anything is another one.
#[test]
fn the_comparison_notices_other_extents() {
    let baked = checked(random_room(SMALL));
    let extent = ClusterExtent { rank: 5, columns: 60, receivers: 70, ..ClusterExtent::ALL };
    let probe = ProbeExtent { rays: 30, degree: 2 };
    let plan = |extent, probe| FramePlan::new(&baked, |_| extent, |_| probe);
    let mut runtime = Runtime::new(baked.clone());
    runtime.set_lighting(all_lights()).unwrap();
    runtime.step_with(&plan(extent, probe)).unwrap();
    let colors = SurfaceColors::of(&baked.scene);
    let is_right = |extent, probe| {
        let plan = plan(extent, probe);
        let slow = slow_frame(&baked, &all_lights(), &colors, &plan, &SlowFrame::dark(&baked));
        stage_differences(&runtime, &slow).map(|d| d < TOLERANCE)
    };
    assert_eq!(is_right(extent, probe), [true; 5]);
    let [_, relight, project, gather, _] = [0, 1, 2, 3, 4];
    assert!(!is_right(extent, ProbeExtent { rays: 60, ..probe })[relight]);
    assert!(!is_right(extent, ProbeExtent { degree: 4, ..probe })[relight]);
    assert!(!is_right(ClusterExtent { rank: 6, ..extent }, probe)[project]);
    assert!(!is_right(ClusterExtent { solid: 4, fade: 9, ..extent }, probe)[project]);
    assert!(!is_right(ClusterExtent { columns: 61, ..extent }, probe)[project]);
    assert!(!is_right(ClusterExtent { receivers: 71, ..extent }, probe)[gather]);
}

/// What a plan leaves out is not read: other numbers there change nothing.
#[test]
fn what_lies_beyond_an_extent_does_not_count() {
    let parts = random_room(Size { varied: false, ..SMALL });
    let extent = ClusterExtent { rank: 8, columns: 40, receivers: 96, ..ClusterExtent::ALL };
    let bits = |baked: &Arc<BakedScene>, extent| {
        let plan = FramePlan::new(baked, |_| extent, |_| ProbeExtent { rays: 30, degree: 1 });
        let mut runtime = Runtime::new(Arc::clone(baked));
        runtime.set_lighting(all_lights()).unwrap();
        runtime.step_with(&plan).unwrap();
        runtime.receiver_irradiance().iter().map(|e| e.to_array().map(f32::to_bits)).collect::<Vec<_>>()
    };
    let baked = checked(parts.clone());
    let mut damaged = parts;
    for cluster in &baked.clusters {
        let columns = baked.column_count(cluster);
        let start = cluster.signal_basis_offset as usize;
        let behind =
            cluster.signal_ranks.line_start(8, columns)..cluster.signal_ranks.line_start(14, columns);
        damaged.signal_basis[start..][behind].fill(0x1111_1111);
        damaged.row_scales[cluster.row_scale_offset as usize + 8..][..6].fill(77.0);
        damaged.column_exponents[cluster.column_exponent_offset as usize..][40..columns].fill(0);
    }
    for ray in (0..damaged.relight_surfels.len()).filter(|ray| ray % 60 >= 30) {
        damaged.relight_surfels[ray] = 0;
    }
    let damaged = checked(damaged);
    assert!(bits(&baked, extent) == bits(&damaged, extent));
    assert!(bits(&baked, ClusterExtent::ALL) != bits(&damaged, ClusterExtent::ALL), "nothing was damaged");
}

#[test]
fn levels_of_detail_become_plans() {
    let mut baked = random_room(SMALL);
    for (cluster, x) in baked.clusters.iter_mut().zip(0u8..) {
        cluster.bounds = Bounds { min: Vec3::X * f32::from(x), max: Vec3::X * f32::from(x) + Vec3::ONE };
    }
    let baked = checked(baked);
    let far =
        LodLevel { distance: 4.0, rank: Some(3), degree: Some(1), rays: Some(20), ..LodLevel::default() };
    let lod = LodSettings { levels: vec![LodLevel::default(), far], ..LodSettings::default() };
    let input = FrameInput { view: Some(View::default()), ..FrameInput::default() };

    let mut by_levels = Runtime::new(baked.clone());
    by_levels.set_lod(lod.clone()).unwrap();
    by_levels.step(&input);
    let mut plan = FramePlan::full(&baked);
    Planner::new(&baked).plan(&baked, &lod, &input, &mut plan);
    assert_eq!(*by_levels.plan(), plan);
    assert_ne!(plan, FramePlan::full(&baked));

    let mut by_plan = Runtime::new(baked.clone());
    by_plan.step_with(&plan).unwrap();
    assert_eq!(by_levels.receiver_irradiance(), by_plan.receiver_irradiance());
    by_plan.step_with(&FramePlan::full(&baked)).unwrap();
    assert_ne!(by_levels.receiver_irradiance(), by_plan.receiver_irradiance());
}

#[test]
fn settings_survive_json_and_bad_ones_are_refused() {
    let baked = checked(random_room(SMALL));
    let far = LodLevel { distance: 4.0, rank: Some(3), ..LodLevel::default() };
    let lod = LodSettings { levels: vec![LodLevel::default(), far], ..LodSettings::default() };
    let text = serde_json::to_string(&lod).unwrap();
    assert_eq!(serde_json::from_str::<LodSettings>(&text).unwrap(), lod);
    assert!(serde_json::from_str::<LodSettings>(r#"{"levels": [{"ranks": 3}]}"#).is_err());
    let sparse: LodSettings =
        serde_json::from_str(r#"{"levels": [{}, {"distance": 4, "rank": 3}]}"#).unwrap();
    assert_eq!(sparse, lod);

    let mut runtime = Runtime::new(baked);
    let none = LodSettings { levels: Vec::new(), ..LodSettings::default() };
    assert!(matches!(runtime.set_lod(none), Err(RuntimeError::InvalidLod { .. })));
    assert_eq!(*runtime.lod(), LodSettings::default());
}

#[test]
fn plans_for_another_scene_are_refused() {
    let mut runtime = Runtime::new(checked(random_room(SMALL)));
    let foreign = FramePlan::full(&checked(random_room(Size { clusters: 3, ..SMALL })));
    assert!(matches!(runtime.step_with(&foreign), Err(RuntimeError::ForeignPlan)));
    // As many clusters and probes, but larger ones: as much of it as there is.
    let larger = Size { receivers_per_cluster: 500, sh_degree: 9, rays: 99, ..SMALL };
    let larger = FramePlan::full(&checked(random_room(larger)));
    runtime.step_with(&larger).unwrap();
    assert_eq!(*runtime.plan(), FramePlan::full(runtime.baked()));
}
