//! Frames that leave alone what did not change.
#![cfg(feature = "cpu")]

mod support;

use std::sync::Arc;

use probelight_asset::{BakedScene, Cluster};
use probelight_math::glam::{DVec3, Vec3};
use probelight_math::sampling::Rng;
use probelight_runtime::{FrameInput, FramePlan, LodChanges, LodSettings, Runtime};
use probelight_scene::{Light, Lighting};
use support::slow_frame::{SlowFrame, irradiance_of_cluster};
use support::{Size, all_lights, checked, probe_coefficients, random_room};

/// Many clusters that each see but a part of the room.
fn room() -> Arc<BakedScene> {
    let size = Size { clusters: 60, receivers_per_cluster: 100, ..Size::hybrid(6000) };
    let mut parts = random_room(Size { surfels: 4000, surfel_groups: 3999, probes: 30, rays: 128, ..size });
    // What is left of a change is compared before borders are blended.
    parts.settings.blend_borders = false;
    checked(parts)
}

fn lets_wait(threshold: f32) -> LodSettings {
    let changes = LodChanges { threshold, longest_wait: 1000, ..LodChanges::default() };
    LodSettings { changes, ..LodSettings::default() }
}

fn runtime(baked: &Arc<BakedScene>, lod: LodSettings) -> Runtime {
    let mut runtime = Runtime::new(Arc::clone(baked));
    runtime.set_lod(lod).unwrap();
    runtime
}

/// One lamp above a part of the floor, and little else.
fn lamp(power: f32) -> Lighting {
    let intensity = Vec3::splat(power);
    let lamp = Light::Point { position: Vec3::new(-1.5, 0.3, -1.5), intensity, range: None };
    Lighting { lights: vec![lamp], ..all_lights() }
}

/// The same, at some place.
fn lamp_at(position: Vec3) -> Lighting {
    let lamp = Light::Point { position, intensity: Vec3::splat(5.0), range: None };
    Lighting { lights: vec![lamp], ..all_lights() }
}

/// How far each cluster is from what its signals say now, as a share of its light: root mean square over its
/// receivers, of the worst channel.
fn staleness(runtime: &Runtime) -> Vec<f64> {
    let baked = runtime.baked();
    let mut frame = SlowFrame::dark(baked);
    frame.signals = runtime.signals().values().iter().map(|signal| signal.as_dvec3()).collect();
    let coefficients: Vec<DVec3> = probe_coefficients(runtime).iter().map(|value| value.as_dvec3()).collect();
    frame.coefficients = coefficients.chunks(baked.coefficients()).map(<[DVec3]>::to_vec).collect();
    let share = |cluster: &Cluster| {
        let first = cluster.first_receiver as usize;
        let held = &runtime.receiver_irradiance()[first..first + cluster.receiver_count as usize];
        let now = irradiance_of_cluster(baked, cluster, &frame);
        let squares: DVec3 = now.iter().zip(held).map(|(now, held)| (*now - held.as_dvec3()).powf(2.0)).sum();
        (squares.max_element() / f64::from(cluster.receiver_count)).sqrt() / light(runtime, cluster)
    };
    baked.clusters.iter().map(share).collect()
}

/// Root mean square of a cluster's irradiance, as if the columns of U were orthogonal.
fn light(runtime: &Runtime, cluster: &Cluster) -> f64 {
    let receivers = cluster.receiver_count as usize;
    let basis = &runtime.baked().receiver_basis[cluster.receiver_basis_offset as usize..];
    let strength = |row: usize| -> f64 {
        let line = &basis[cluster.receiver_ranks.line_start(row, receivers)..];
        let value = |i| f64::from(cluster.receiver_ranks.precision(row).unpack(line, i));
        (0..receivers).map(|i| value(i).powi(2)).sum::<f64>() / receivers as f64
    };
    let b = &runtime.cluster_coefficients().values()[cluster.row_scale_offset as usize..];
    let square = |row: usize| strength(row) * Vec3::from(b[row]).as_dvec3().length_squared() / 3.0;
    (0..cluster.rank() as usize).map(square).sum::<f64>().sqrt()
}

fn worst(staleness: &[f64]) -> f64 {
    staleness.iter().copied().fold(0.0, f64::max)
}

#[test]
fn what_waits_is_never_more_than_allowed() {
    let baked = room();
    let mut rng = Rng::new(1, 2);
    for threshold in [0.002, 0.02, 0.1] {
        let mut runtime = runtime(&baked, lets_wait(threshold));
        let (mut power, mut largest, mut waited) = (5.0, 0.0f64, 0);
        for frame in 0..40 {
            // A walk of small and large steps, with pauses.
            power *= [1.0, 1.01, 0.99, 1.1, 0.9, 1.5, 0.5, 1.0][rng.next_u32() as usize % 8];
            runtime.set_lighting(lamp(power)).unwrap();
            runtime.step(&FrameInput::default());
            let found = worst(&staleness(&runtime));
            assert!(
                found <= f64::from(threshold) * 1.001 + 1e-5,
                "frame {frame}: {found}, {threshold} allowed"
            );
            largest = largest.max(found);
            waited += runtime.plan().receivers() - runtime.work().receivers();
        }
        assert!(waited > 0, "nothing ever waited, {threshold}");
        // Negative control: much less would not hold.
        assert!(largest > 0.02 * f64::from(threshold), "{largest} for {threshold}");
    }
}

#[test]
fn still_light_comes_to_rest_where_it_should() {
    let baked = room();
    let mut rests = runtime(&baked, lets_wait(0.001));
    let mut exact = Runtime::new(Arc::clone(&baked));
    let mut frames = Vec::new();
    for _ in 0..60 {
        for runtime in [&mut rests, &mut exact] {
            runtime.set_lighting(lamp(5.0)).unwrap();
            runtime.step(&FrameInput::default());
        }
        frames.push(rests.work().receivers());
    }
    assert_eq!(frames[0], rests.plan().receivers());
    assert_eq!(frames[30..], [0; 30], "{frames:?}");
    let difference = |a: &Runtime, b: &Runtime| {
        let squares = |values: &mut dyn Iterator<Item = Vec3>| {
            values.map(|v| v.as_dvec3().length_squared()).sum::<f64>()
        };
        let (a, b) = (a.receiver_irradiance(), b.receiver_irradiance());
        (squares(&mut a.iter().zip(b).map(|(a, b)| *a - *b)) / squares(&mut a.iter().copied())).sqrt()
    };
    let found = difference(&rests, &exact);
    assert!(found < 0.01, "{found}");
    // A change wakes what it reaches.
    rests.set_lighting(lamp(6.0)).unwrap();
    rests.step(&FrameInput::default());
    assert!(rests.work().receivers() > 0);
    assert!(difference(&rests, &exact) > found, "the comparison notices nothing");
}

#[test]
fn a_small_change_is_computed_in_the_end() {
    let baked = room();
    let changes = LodChanges { threshold: 0.05, longest_wait: 12, matrix_share: None };
    let mut runtime = runtime(&baked, LodSettings { changes, ..LodSettings::default() });
    let frames = |runtime: &mut Runtime, power| -> Vec<u64> {
        runtime.set_lighting(lamp(power)).unwrap();
        let frame = |_| {
            runtime.step(&FrameInput::default());
            runtime.work().receivers()
        };
        (0..60).map(frame).collect()
    };
    frames(&mut runtime, 5.0);
    let after = frames(&mut runtime, 5.2);
    let first = after.iter().position(|receivers| *receivers > 0);
    assert!(first.is_some_and(|frame| frame < 13), "{after:?}");
}

#[test]
fn a_budget_spreads_work_over_frames() {
    let baked = room();
    let all = FramePlan::full(&baked).matrix_bytes(&baked);
    let changes = LodChanges { threshold: 0.002, matrix_share: Some(0.2), ..LodChanges::default() };
    let mut runtime = runtime(&baked, LodSettings { changes, ..LodSettings::default() });
    runtime.set_lighting(lamp(5.0)).unwrap();
    let mut bytes = Vec::new();
    for _ in 0..200 {
        runtime.step(&FrameInput::default());
        bytes.push(runtime.work().matrix_bytes(&baked));
    }
    assert_eq!(bytes[0], all, "the first frame leaves nothing to others");
    assert!(bytes[1] > 0 && bytes[1..].iter().all(|bytes| *bytes < all / 3), "{bytes:?} of {all}");
    assert_eq!(bytes.last(), Some(&0));
    let stale = worst(&staleness(&runtime));
    assert!(stale < 0.0021, "{stale}");
}

/// Probes that have their turns are relit later, not less: when the light stands still, nothing is left out.
#[test]
fn probes_take_turns() {
    let baked = room();
    let changes = LodChanges { threshold: 0.002, ..LodChanges::default() };
    let mut runtime = runtime(&baked, LodSettings { changes, probe_turns: 4, ..LodSettings::default() });
    let mut relit = |place, frames| -> Vec<usize> {
        runtime.set_lighting(lamp(place)).unwrap();
        let frame = |_| {
            runtime.step(&FrameInput::default());
            runtime.work().relit_probes()
        };
        (0..frames).map(frame).collect()
    };
    assert_eq!(relit(5.0, 1), [baked.probes.len()], "the first frame leaves nothing to others");
    let moved = relit(6.0, 200);
    let most = baked.probes.len().div_ceil(2);
    assert!(moved.iter().all(|relit| *relit <= most), "an even share of them: {moved:?}");
    assert!(moved[..4].iter().sum::<usize>() > most, "all in four frames: {moved:?}");
    assert_eq!(moved.last(), Some(&0));
    let stale = worst(&staleness(&runtime));
    assert!(stale < 0.0021, "{stale}");
}

/// Where shadow rays have their turns, the light of the last frame of a walk arrives a few frames later, and then is the
/// same.
#[test]
fn shadow_rays_take_turns() {
    let baked = room();
    let mut in_turns = runtime(&baked, LodSettings { shadow_turns: 4, ..LodSettings::default() });
    let mut at_once = Runtime::new(Arc::clone(&baked));
    let mut differ = |in_turns: &mut Runtime, place| {
        for runtime in [&mut *in_turns, &mut at_once] {
            runtime.set_lighting(lamp_at(Vec3::new(place, 0.3, -1.5))).unwrap();
            runtime.step(&FrameInput::default());
        }
        in_turns.signals().values() != at_once.signals().values()
    };
    assert!(!differ(&mut in_turns, -1.5), "the first frame leaves nothing to others");
    assert!(
        [-1.4, -1.3, -1.2, -1.1].into_iter().all(|place| differ(&mut in_turns, place)),
        "nothing waits for its turn"
    );
    (0..3).for_each(|_| {
        differ(&mut in_turns, -1.1);
    });
    // Direct light is the same now; bounced light has yet to follow.
    in_turns.converge(1e-7, 200);
    at_once.converge(1e-7, 200);
    let difference = |(a, b): (&Vec3, &Vec3)| (*a - *b).abs().max_element();
    let signals = in_turns.signals().values().iter().zip(at_once.signals().values());
    assert!(signals.map(difference).fold(0.0, f32::max) < 1e-5);
}

#[test]
fn settings_may_change_between_any_two_frames() {
    let baked = room();
    let mut changing = runtime(&baked, lets_wait(0.05));
    let mut exact = Runtime::new(Arc::clone(&baked));
    for (frame, lod) in [lets_wait(0.05), LodSettings::default(), lets_wait(0.0), LodSettings::default()]
        .into_iter()
        .cycle()
        .take(12)
        .enumerate()
    {
        changing.set_lod(lod).unwrap();
        for runtime in [&mut changing, &mut exact] {
            runtime.set_lighting(lamp(5.0 + frame as f32)).unwrap();
            runtime.step(&FrameInput::default());
        }
    }
    // The last frames let nothing wait, but the light of the first is still on its way.
    for runtime in [&mut changing, &mut exact] {
        runtime.converge(1e-7, 200);
    }
    let scale = exact.receiver_irradiance().iter().map(|e| e.length()).fold(0.0, f32::max);
    for (found, expected) in changing.receiver_irradiance().iter().zip(exact.receiver_irradiance()) {
        assert!((*found - *expected).length() < 1e-5 * scale);
    }
}
