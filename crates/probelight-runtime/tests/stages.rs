//! Each stage against the slow frame, and the whole frame over several bounces.

mod support;

use probelight_asset::BakedParts;
use probelight_asset::packed::Ranks;
use probelight_math::glam::{DVec3, Vec3};
use probelight_runtime::Runtime;
use probelight_runtime::cpu::SurfaceColors;
use proptest::prelude::*;
use support::slow_frame::{SlowFrame, slow_frame};
use support::{SMALL, SMALL_PAPER, Size, all_lights, checked, random_room};

/// Largest difference, relative to the largest value (if there is one).
fn difference(fast: impl IntoIterator<Item = Vec3>, slow: &[DVec3]) -> f64 {
    let fast: Vec<Vec3> = fast.into_iter().collect();
    assert_eq!(fast.len(), slow.len());
    let largest = slow.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
    let worst = fast.iter().zip(slow).map(|(f, s)| (f.as_dvec3() - *s).abs().max_element());
    worst.fold(0.0, f64::max) / if largest > 0.0 { largest } else { 1.0 }
}

fn probe_coefficients(runtime: &Runtime) -> Vec<Vec3> {
    let baked = runtime.baked();
    let probes = runtime.probe_radiance();
    let of_probe = |p| {
        (0..baked.coefficients()).map(move |j| Vec3::from([0, 1, 2].map(|c| probes.coefficients(p, c)[j])))
    };
    (0..baked.probes.len()).flat_map(of_probe).collect()
}

/// Largest relative differences of all stages after the same frames.
fn differences(runtime: &Runtime, slow: &SlowFrame) -> [f64; 5] {
    let cluster_coefficients = runtime.cluster_coefficients().values();
    [
        difference(runtime.signals().values().iter().copied(), &slow.signals),
        difference(probe_coefficients(runtime), &slow.coefficients.concat()),
        difference(cluster_coefficients.iter().map(|b| Vec3::from(*b)), &slow.cluster_coefficients),
        difference(runtime.receiver_irradiance().iter().copied(), &slow.irradiance),
        difference(runtime.irradiance().texels.iter().copied(), &slow.lightmap),
    ]
}

/// Runs both for three bounces and compares after each.
fn compare(parts: BakedParts) {
    let baked = checked(parts);
    let mut runtime = Runtime::new(baked.clone());
    runtime.set_lighting(all_lights());
    let colors = SurfaceColors::of(&baked.scene);
    let mut feedback = vec![DVec3::ZERO; runtime.irradiance().texels.len()];
    for bounce in 0..3 {
        runtime.step();
        let slow = slow_frame(&baked, &all_lights(), &colors, &feedback);
        let differences = differences(&runtime, &slow);
        // A sum of n products of random sign in f32 is off by some √n · 6e-8; n is about a hundred here.
        assert!(differences.iter().all(|d| *d < 3e-6), "bounce {bounce}: {differences:?}");
        feedback = slow.lightmap;
    }
}

#[test]
fn stages_equal_the_slow_frame() {
    compare(random_room(SMALL));
}

#[test]
fn stages_equal_the_slow_frame_as_published() {
    compare(random_room(SMALL_PAPER));
}

#[test]
fn stages_equal_the_slow_frame_at_other_sizes() {
    compare(random_room(Size { sh_degree: 7, receivers_per_cluster: 64, ..SMALL }));
    compare(random_room(Size { sh_degree: 0, receivers_per_cluster: 1, probes: 8, ..SMALL_PAPER }));
    compare(random_room(Size {
        sh_degree: 9,
        rays: 200,
        probes: 3,
        clusters: 2,
        sky_degree: Some(8),
        ..SMALL
    }));
    compare(random_room(Size { probes: 0, probes_per_cluster: 0, rays: 0, varied: false, ..SMALL }));
}

fn ranks() -> impl Strategy<Value = Ranks> {
    (0u32..10, 0u32..10, 0u32..10).prop_map(|(f16, snorm8, snorm4)| Ranks { f16, snorm8, snorm4 })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Packed kernels equal the mathematics of the values that are stored, whatever the remainders.
    #[test]
    fn stages_equal_the_slow_frame_at_any_size(
        (clusters, receivers_per_cluster, ranks) in (1usize..6, 1usize..200, ranks()),
        (surfels, samples_per_surfel, surfel_groups) in (1usize..50, 1usize..6, 0usize..50),
        (emitters, sky_degree) in (0usize..3, prop::option::of(0u32..5)),
        (signals_per_cluster, probes, sh_degree) in (0usize..70, 1usize..12, 0usize..6),
        varied in any::<bool>(),
    ) {
        let Ranks { f16, snorm8, snorm4 } = ranks;
        let signal_ranks = Ranks { f16: snorm4, snorm8: f16, snorm4: snorm8 };
        let size = Size {
            clusters, receivers_per_cluster, receiver_ranks: ranks, signal_ranks, surfels, samples_per_surfel, surfel_groups, emitters,
            sky_degree, signals_per_cluster, probes, sh_degree, varied, probes_per_cluster: probes % 4, rays: 50,
        };
        compare(random_room(size));
    }
}

#[test]
fn comparison_notices_a_wrong_value_in_each_stage() {
    let baked = checked(random_room(SMALL));
    let mut runtime = Runtime::new(baked.clone());
    runtime.set_lighting(all_lights());
    runtime.step();
    let colors = SurfaceColors::of(&baked.scene);
    let dark = vec![DVec3::ZERO; runtime.irradiance().texels.len()];
    assert!(
        differences(&runtime, &slow_frame(&baked, &all_lights(), &colors, &dark)).iter().all(|d| *d < 3e-6)
    );
    for stage in 0..5 {
        let mut slow = slow_frame(&baked, &all_lights(), &colors, &dark);
        let values = match stage {
            0 => &mut slow.signals,
            1 => &mut slow.coefficients[2],
            2 => &mut slow.cluster_coefficients,
            3 => &mut slow.irradiance,
            _ => &mut slow.lightmap,
        };
        let largest = values.iter_mut().max_by(|a, b| a.x.abs().total_cmp(&b.x.abs())).unwrap();
        largest.x *= 1.01;
        let noticed = differences(&runtime, &slow).map(|d| d > 3e-6);
        assert_eq!(noticed, std::array::from_fn(|i| i == stage));
    }
}
