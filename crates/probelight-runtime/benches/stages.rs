//! Time of each stage at 120,000 receivers, and of reading as many bytes as a frame moves: the ratio of the two
//! says how far a frame is from what memory allows.
//!
//! `cargo bench -p probelight-runtime`

#![expect(clippy::print_stdout, reason = "the ratio is the benchmark's result")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use probelight_asset::BakedScene;
use probelight_runtime::synthetic::{SyntheticSize, synthetic_lighting, synthetic_room};
use probelight_runtime::{FrameInput, PerStage, Runtime, Stage, StageTimings, stage_bytes};
use probelight_scene::Lighting;
use rayon::prelude::*;

/// About as many as a baked atrium has.
const RECEIVERS: usize = 120_000;

/// More than any last-level cache holds.
const BASELINE_BYTES: usize = 1 << 29;

/// Reads memory with all threads and returns the sum of the values, so that nothing can be left out.
fn read(words: &[u64]) -> u64 {
    words.par_chunks(1 << 17).map(|chunk| chunk.iter().fold(0, |sum: u64, w| sum.wrapping_add(*w))).sum()
}

/// Shortest of some runs: what the machine can do when nobody disturbs.
fn shortest(runs: usize, mut run: impl FnMut() -> Duration) -> Duration {
    (0..runs).map(|_| run()).min().unwrap_or_default()
}

fn timed(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

fn stages(criterion: &mut Criterion) {
    for (name, size) in
        [("paper", SyntheticSize::paper(RECEIVERS)), ("hybrid", SyntheticSize::hybrid(RECEIVERS))]
    {
        let mut runtime = Runtime::new(Arc::new(BakedScene::new(synthetic_room(size)).unwrap()));
        runtime.set_lighting(synthetic_lighting()).unwrap();
        runtime.step(&FrameInput::default());
        bench_stages(criterion, name, &mut runtime);
        report_ratio(name, &mut runtime);
    }
}

fn bench_stages(criterion: &mut Criterion, name: &str, runtime: &mut Runtime) {
    let mut group = criterion.benchmark_group(name);
    let mut bench = |name: &str, of: &dyn Fn(&StageTimings) -> Duration| {
        let mut frame = || of(&runtime.step(&FrameInput::default()));
        group.bench_function(name, |b| b.iter_custom(|n| (0..n).map(|_| frame()).sum()));
    };
    for stage in Stage::ALL.into_iter().filter(|stage| stage.is_on_cpu()) {
        bench(stage.name(), &|timings| timings.stages[stage]);
    }
    bench("frame", &|timings| timings.frame);
    group.bench_function("frame_with_shadow_rays", |b| {
        b.iter_custom(|n| {
            let frame = |i| {
                let lights = if i % 2 == 0 { Vec::new() } else { synthetic_lighting().lights };
                runtime.set_lighting(Lighting { lights, ..synthetic_lighting() }).unwrap();
                runtime.step(&FrameInput::default()).frame
            };
            // Half of the frames have no lights, hence no shadow rays.
            (0..2 * n).map(frame).sum()
        });
    });
    group.finish();
}

/// Prints how long a frame takes in multiples of reading its bytes once, both measured here.
fn report_ratio(name: &str, runtime: &mut Runtime) {
    let words = vec![1u64; BASELINE_BYTES / 8];
    let baseline =
        shortest(20, || timed(|| assert_eq!(black_box(read(black_box(&words))), words.len() as u64)));
    let bytes_per_second = BASELINE_BYTES as f64 / baseline.as_secs_f64();
    let frame = shortest(200, || runtime.step(&FrameInput::default()).frame);
    let bytes: u64 = stage_bytes(runtime.baked(), runtime.plan(), false).values().iter().sum();
    let floor = bytes as f64 / bytes_per_second;
    println!(
        "{name}: {:.1} bytes per receiver; memory: {:.1} GB/s; frame: {:.2} ms for {:.1} MB, {:.2} ms to read as many: ratio {:.2}",
        runtime.baked().matrix_bytes_per_receiver(),
        bytes_per_second * 1e-9,
        frame.as_secs_f64() * 1e3,
        bytes as f64 * 1e-6,
        floor * 1e3,
        frame.as_secs_f64() / floor
    );
    let mut best = PerStage::from_fn(|_| Duration::MAX);
    for _ in 0..200 {
        let timings = runtime.step(&FrameInput::default());
        best = PerStage::from_fn(|stage| best[stage].min(timings.stages[stage]));
    }
    for stage in Stage::ALL.into_iter().filter(|stage| stage.is_on_cpu()) {
        println!("shortest {}: {:?}", stage.name(), best[stage]);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .sample_size(20);
    targets = stages
}
criterion_main!(benches);
