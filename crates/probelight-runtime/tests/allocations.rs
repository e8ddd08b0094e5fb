//! A frame allocates nothing. Alone in its file, because every allocation of the process counts.
#![cfg(feature = "cpu")]

mod support;

use std::alloc::System;
use std::sync::Barrier;

use probelight_runtime::{FrameInput, LodChanges, LodSettings, Runtime};
use probelight_scene::Lighting;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use support::{SMALL, all_lights, checked, random_room};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations and reallocations while `work` runs.
fn allocations(work: impl FnOnce()) -> usize {
    let region = Region::new(ALLOCATOR);
    work();
    let change = region.change();
    change.allocations + change.reallocations
}

/// Has both workers of the pool steal from each other: the first time, that allocates. On a busy machine a frame may
/// end before the second worker has looked.
fn steal_once() {
    let meet = |barrier: &Barrier| {
        barrier.wait();
    };
    let (there, back) = (Barrier::new(2), Barrier::new(2));
    rayon::join(
        || meet(&there),
        || {
            meet(&there);
            rayon::join(|| meet(&back), || meet(&back))
        },
    );
}

/// Runs inside a pool: work handed to a pool from outside now and then makes its queue allocate.
#[test]
fn frames_after_the_first_allocate_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(|| {
        let mut runtime = Runtime::new(checked(random_room(SMALL)));
        for threshold in [0.0, 0.005] {
            let changes = LodChanges { threshold, ..LodChanges::default() };
            runtime.set_lod(LodSettings { changes, ..LodSettings::default() }).unwrap();
            // Lights have their rays, once for each.
            runtime.set_lighting(all_lights()).unwrap();
            runtime.step(&FrameInput::default());
            steal_once();
            let mut lightings = [all_lights(), Lighting::default(), all_lights()].into_iter();
            let in_frames = allocations(|| {
                for frame in 0..30 {
                    if frame % 10 == 0 {
                        runtime.set_lighting(lightings.next().unwrap()).unwrap();
                    }
                    runtime.step(&FrameInput::default());
                }
            });
            assert_eq!(in_frames, 0);
        }
        let in_converge = allocations(|| assert_eq!(runtime.converge(0.0, 1).steps, 1));
        assert!(in_converge > 0, "the count counts nothing");
    });
}
