//! Time of each step of a bake, and of the whole, on bundled scenes.
//!
//! `cargo bench -p probelight-bake --bench steps`
//!
//! Steps are what the bake announces by [`Progress`]: each lasts until the next begins. A bake is stopped as soon as
//! the step to be measured is over.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_scene::load_gltf;
use probelight_trace::{Progress, Silent};

/// Few enough that a bake takes about a second.
const RECEIVERS: u32 = 2000;

/// What medium quality shoots in scenes of many receivers; so few would get more.
const GATHER_RAYS: u32 = 256;

/// Notes when steps begin, and stops the bake after one of them.
#[derive(Default)]
struct StepClock {
    /// The last step of interest; if empty, the bake goes on to its end.
    last: String,
    begun: Mutex<Vec<(String, Instant)>>,
    is_over: AtomicBool,
}

impl Progress for StepClock {
    fn begin(&self, step: &str, _total: u64) {
        let mut begun = self.begun.lock().unwrap();
        if begun.last().is_some_and(|(step, _)| *step == self.last) {
            self.is_over.store(true, Ordering::Relaxed);
        }
        begun.push((step.to_owned(), Instant::now()));
    }

    fn advance(&self, _steps: u64) {}

    fn is_cancelled(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }
}

/// Runs a bake up to the end of a step and returns how long that step took.
fn time_of_step(step: &str, bake: impl FnOnce(&StepClock) -> Result<(), BakeError>) -> Duration {
    let clock = StepClock { last: step.to_owned(), ..StepClock::default() };
    match bake(&clock) {
        Ok(()) | Err(BakeError::Cancelled) => {}
        Err(error) => panic!("{error}"),
    }
    let end = Instant::now();
    let begun = clock.begun.into_inner().unwrap();
    let index = begun.iter().position(|(name, _)| name == step).expect("the bake has this step");
    begun.get(index + 1).map_or(end, |(_, next)| *next) - begun[index].1
}

fn steps(criterion: &mut Criterion) {
    for name in ["cornell", "rooms"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../assets/scenes/{name}.glb"));
        let scene = Arc::new(load_gltf(&path).expect("bundled scenes load"));
        let options = BakeOptions {
            receivers: Some(RECEIVERS),
            gather_rays: Some(GATHER_RAYS),
            ..BakeOptions::default()
        };
        let bake = |progress: &dyn Progress| bake(Arc::clone(&scene), &options, None, progress);

        let clock = StepClock::default();
        let baked = bake(&clock).expect("bundled scenes are valid");
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(baked.receiver_texels.len() as u64));
        for (step, _) in clock.begun.into_inner().unwrap() {
            group.bench_function(&step, |bencher| {
                bencher.iter_custom(|n| {
                    (0..n).map(|_| time_of_step(&step, |clock| bake(clock).map(drop))).sum()
                });
            });
        }
        group.bench_function("whole bake", |bencher| bencher.iter(|| bake(&Silent)));
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .sample_size(10);
    targets = steps
}
criterion_main!(benches);
