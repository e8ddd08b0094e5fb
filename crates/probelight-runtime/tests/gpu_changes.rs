//! Frames that leave alone what did not change, on the GPU as on the CPU.
#![cfg(all(feature = "cpu", feature = "gpu", feature = "blocking"))]

#[path = "support/gpu.rs"]
mod gpu;
mod support;

use probelight_asset::BakedParts;
use probelight_math::glam::{DVec3, Vec3};
use probelight_runtime::gpu::{GpuOptions, GpuRuntime, ShadowMapOptions};
use probelight_runtime::{FrameInput, LodChanges, LodLevel, LodSettings, Runtime, View, Workload};
use probelight_scene::Lighting;
use support::{SMALL_PAPER, Size, all_lights, checked, random_room};

/// As between stages; a frame's errors add up over the frames.
const TOLERANCE: f64 = 1e-5;

/// Clusters that each see but a part of the room.
fn room() -> BakedParts {
    let size = Size { clusters: 40, receivers_per_cluster: 100, ..Size::hybrid(4000) };
    random_room(Size { surfels: 3000, surfel_groups: 2999, probes: 25, rays: 128, emitters: 3, ..size })
}

struct Twins {
    on_cpu: Runtime,
    on_gpu: GpuRuntime,
}

impl Twins {
    fn new(parts: BakedParts, changes: LodChanges) -> Option<Self> {
        Self::with_lod(parts, LodSettings { changes, ..LodSettings::default() })
    }

    fn with_lod(parts: BakedParts, lod: LodSettings) -> Option<Self> {
        let gpu = gpu::gpu_or_skip()?;
        let baked = checked(parts);
        let maps = ShadowMapOptions { resolution: 64, ..ShadowMapOptions::default() };
        let options = GpuOptions { shadow_maps: maps, ..GpuOptions::default() };
        let mut on_cpu = Runtime::new(baked.clone());
        let mut on_gpu = GpuRuntime::new(&gpu.device, &gpu.queue, baked, options).unwrap();
        on_cpu.set_lod(lod.clone()).unwrap();
        on_gpu.set_lod(lod).unwrap();
        Some(Self { on_cpu, on_gpu })
    }

    /// A frame with so bright a sky and emission, and so bright a floor. There are no lamps, whose shadows differ.
    fn step(&mut self, brightness: f32, floor: f32) {
        let lighting = Lighting { lights: Vec::new(), emissive_scale: brightness, ..all_lights() };
        self.on_cpu.set_lighting(lighting.clone()).unwrap();
        self.on_gpu.set_lighting(lighting).unwrap();
        self.on_cpu.set_base_color(0, Vec3::splat(floor)).unwrap();
        self.on_gpu.set_base_color(0, Vec3::splat(floor)).unwrap();
        self.on_cpu.step(&FrameInput::default());
        self.on_gpu.step(&FrameInput::default());
    }

    /// Clusters that the last frame computed.
    fn worked(&self) -> [usize; 2] {
        let count = |extents: &[probelight_runtime::ClusterExtent]| {
            extents.iter().filter(|extent| extent.receivers > 0).count()
        };
        [count(self.on_cpu.work().clusters()), count(&self.on_gpu.read_work().unwrap())]
    }

    /// What the last frame did and left, which both must agree on.
    fn workload(&self) -> Workload {
        let on_gpu = self.on_gpu.read_workload().unwrap();
        assert_eq!(self.on_cpu.workload(), on_gpu);
        on_gpu
    }

    fn difference(&self) -> f64 {
        let cpu: Vec<DVec3> = self.on_cpu.receiver_irradiance().iter().map(|e| e.as_dvec3()).collect();
        support::difference(self.on_gpu.read_irradiance().unwrap(), &cpu)
    }
}

/// Brightness of emission and of the floor in each frame: a walk with a pause.
const WALK: [[f32; 2]; 16] = [
    [1.0, 0.5],
    [1.0, 0.5],
    [1.0, 0.5],
    [1.1, 0.5],
    [1.1, 0.5],
    [1.1, 0.52],
    [1.1, 0.54],
    [1.1, 0.56],
    [0.5, 0.56],
    [0.5, 0.56],
    [0.5, 0.56],
    [0.5, 0.56],
    [0.5, 0.56],
    [0.5, 0.56],
    [0.5, 0.4],
    [0.5, 0.4],
];

#[test]
fn the_same_clusters_wait_on_both() {
    let changes = LodChanges { threshold: 0.02, longest_wait: 5, matrix_share: None };
    for parts in [room(), random_room(SMALL_PAPER)] {
        let all = parts.clusters.len();
        let Some(mut twins) = Twins::new(parts, changes) else { return };
        let mut worked = Vec::new();
        for [emission, floor] in WALK {
            twins.step(emission, floor);
            let [on_cpu, on_gpu] = twins.worked();
            assert_eq!(on_cpu, on_gpu, "{worked:?}");
            worked.push(on_cpu);
            let found = twins.difference();
            assert!(found < TOLERANCE, "{found} after {worked:?}");
        }
        assert!(worked[0] == all && worked.iter().any(|count| *count < all), "{worked:?}");
    }
}

/// How bright emission is in a frame: more and more, then at rest.
fn brighter(frame: u16) -> f32 {
    1.0 + 0.5 * f32::from(frame.min(8))
}

#[test]
fn a_budget_chooses_the_same_clusters() {
    let parts = random_room(SMALL_PAPER);
    let all = parts.clusters.len();
    let changes = LodChanges { threshold: 0.02, longest_wait: 9, matrix_share: Some(0.1) };
    let Some(mut twins) = Twins::new(parts, changes) else { return };
    let (mut most_pending, mut most_worked) = (0, 0);
    for frame in 0..16 {
        twins.step(brighter(frame), 0.5);
        let [on_cpu, on_gpu] = twins.worked();
        assert_eq!(on_cpu, on_gpu);
        if frame == 0 {
            assert_eq!(on_cpu, all, "the first frame leaves nothing to others");
        } else {
            most_worked = most_worked.max(on_cpu);
        }
        let Workload { receivers, matrix_bytes, pending_clusters } = twins.workload();
        assert_eq!(receivers, twins.on_cpu.work().receivers());
        assert_eq!([receivers == 0, matrix_bytes == 0], [on_cpu == 0; 2]);
        most_pending = most_pending.max(pending_clusters);
        assert!(twins.difference() < TOLERANCE);
    }
    assert!(
        (1..all.div_ceil(2)).contains(&most_worked),
        "{most_worked} of {all}: the budget is a tenth of all"
    );
    assert!(most_pending > 0, "a budget leaves clusters waiting");
}

#[test]
fn probes_have_the_same_turns_on_both() {
    let changes = LodChanges { threshold: 0.0005, longest_wait: 9, matrix_share: None };
    let Some(mut twins) = Twins::with_lod(
        random_room(SMALL_PAPER),
        LodSettings { changes, probe_turns: 3, ..LodSettings::default() },
    ) else {
        return;
    };
    let relit = |twins: &Twins| twins.on_cpu.work().relit_probes();
    let mut counts = Vec::new();
    for frame in 0..20 {
        twins.step(brighter(frame), 0.5);
        let [on_cpu, on_gpu] = twins.worked();
        assert_eq!(on_cpu, on_gpu);
        assert!(twins.difference() < TOLERANCE, "{counts:?}");
        counts.push(relit(&twins));
    }
    let all = twins.on_cpu.baked().probes.len();
    assert_eq!(counts[0], all, "the first frame leaves nothing to others");
    assert!(counts[1..].iter().any(|count| (1..all).contains(count)), "{counts:?} of {all}");
}

/// Levels of all kinds at once, seen by a camera that moves.
#[test]
fn levels_are_those_of_the_cpu() {
    let mut parts = room();
    let width = parts.lightmap.width;
    for cluster in &parts.clusters {
        let first = cluster.first_receiver as usize;
        let texels = &mut parts.receiver_texels[first..first + cluster.receiver_count as usize];
        texels.sort_by_key(|texel| std::cmp::Reverse(((texel % width) | (texel / width)).trailing_zeros()));
    }
    let Some(mut twins) = Twins::new(parts, LodChanges::default()) else { return };
    let level = |(n, distance): (u32, f32)| LodLevel {
        distance,
        behind: Some(distance / 2.0),
        rank: Some(24 - 5 * n),
        degree: Some(7 - n),
        rays: Some(128 >> n),
        lightmap_level: n,
        ..LodLevel::default()
    };
    let levels = (0..).zip([0.0, 2.0, 3.5, 5.0]).map(level).collect();
    let lod = LodSettings { levels, ..LodSettings::default() };
    twins.on_cpu.set_lod(lod.clone()).unwrap();
    twins.on_gpu.set_lod(lod).unwrap();
    let mut filled = 0;
    for x in 0..4u8 {
        let view = View { position: Vec3::new(f32::from(x), 0.5, 1.0), direction: Vec3::X };
        let input = FrameInput { view: Some(view), ..FrameInput::default() };
        twins.on_cpu.step(&input);
        twins.on_gpu.step(&input);
        assert!(twins.difference() < TOLERANCE, "{}", twins.difference());
        let clusters = twins.on_cpu.plan().clusters();
        filled += clusters.iter().filter(|extent| extent.fill > 0 && extent.solid < extent.rank).count();
        assert_eq!(twins.on_gpu.read_work().unwrap(), clusters);
    }
    assert!(filled > 0, "no cluster fades and is filled");
}

#[test]
fn nothing_waits_after_it_was_switched_off() {
    let changes = LodChanges { threshold: 0.5, ..LodChanges::default() };
    let Some(mut twins) = Twins::new(room(), changes) else { return };
    for [emission, floor] in WALK {
        twins.step(emission, floor);
    }
    let clusters = twins.on_cpu.baked().clusters.len();
    assert!(twins.worked()[1] < clusters);
    for lod in [LodSettings::default(), LodSettings { changes, ..LodSettings::default() }] {
        twins.on_cpu.set_lod(lod.clone()).unwrap();
        twins.on_gpu.set_lod(lod).unwrap();
        twins.step(0.5, 0.4);
        assert_eq!(twins.worked(), [clusters; 2]);
        twins.step(0.5, 0.4);
        assert!(twins.difference() < TOLERANCE);
    }
    // Forgetting the light makes everything new.
    twins.on_cpu.reset();
    twins.on_gpu.reset();
    twins.step(0.5, 0.4);
    assert_eq!(twins.worked(), [clusters; 2]);
    assert!(twins.difference() < TOLERANCE);
}
