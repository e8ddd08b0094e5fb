//! Rooms that no light leaves or enters: how bright they are is known on paper.

mod support;

use std::f32::consts::PI;
use std::sync::Arc;

use probelight_asset::packed::{GAIN_STEPS, column_factor};
use probelight_asset::{BakedScene, Cluster, Method, Metric, NONE, Storage};
use probelight_bake::{BakeOptions, bake};
use probelight_math::directions::weighted_basis;
use probelight_math::glam::Vec3;
use probelight_math::sh::Y00;
use probelight_runtime::Runtime;
use probelight_scene::{Light, Lighting};
use probelight_trace::Silent;

use support::{load, quick, quick_bake};

/// A cluster's signals when all surfaces and the sky have a radiance of 1 in all directions and emitters are
/// off: one value for each column.
fn constant_radiance(baked: &BakedScene, cluster: &Cluster) -> Vec<f32> {
    let (patches, sky) = (baked.first_emitter_signal(), baked.first_sky_signal());
    let signals = baked.signals_of(cluster);
    let value = |signal: &u32| match *signal as usize {
        s if s < patches => 1.0,
        s if s == sky => 1.0 / Y00,
        _ => 0.0,
    };
    let mut values: Vec<f32> = signals.iter().map(value).collect();
    let probes = baked.probes_of(cluster);
    let coefficients: Vec<Vec<f32>> = probes.iter().map(|p| measured_by_probe(baked, *p as usize)).collect();
    for l in 0..=baked.settings.sh_degree as usize {
        values.extend(coefficients.iter().flat_map(|of_probe| &of_probe[l * l..(l + 1) * (l + 1)]));
    }
    values
}

/// A probe's coefficients then. The sky is among them unless it has signals of its own.
fn measured_by_probe(baked: &BakedScene, probe: usize) -> Vec<f32> {
    let rays = baked.relight_directions.len();
    let table = weighted_basis(&baked.relight_directions, baked.settings.sh_degree as usize);
    let mut sums = vec![0.0; baked.coefficients()];
    for (ray, row) in table.chunks_exact(sums.len()).enumerate() {
        if baked.relight_surfels[probe * rays + ray] != NONE || baked.settings.sky_degree.is_none() {
            let gain = f32::from(baked.relight_gains[probe * rays + ray]) / f32::from(GAIN_STEPS);
            sums.iter_mut().zip(row).for_each(|(sum, y)| *sum += gain * y);
        }
    }
    sums
}

/// Irradiance of every receiver of a cluster for given signals, from the packed matrices.
fn irradiance(baked: &BakedScene, cluster: &Cluster, signals: &[f32]) -> Vec<f32> {
    let (columns, height) = (signals.len(), cluster.receiver_count as usize);
    let basis = &baked.signal_basis[cluster.signal_basis_offset as usize..];
    let u = &baked.receiver_basis[cluster.receiver_basis_offset as usize..];
    let exponents = &baked.column_exponents[cluster.column_exponent_offset as usize..];
    let mut irradiance = vec![0.0; height];
    for k in 0..cluster.rank() as usize {
        let precision = cluster.signal_ranks.precision(k);
        let row = &basis[cluster.signal_ranks.line_start(k, columns)..];
        let scaled = |c: usize| precision.unpack(row, c) * column_factor(exponents[c]) * signals[c];
        let coefficient =
            (0..columns).map(scaled).sum::<f32>() * baked.row_scales[cluster.row_scale_offset as usize + k];
        let line = &u[cluster.receiver_ranks.line_start(k, height)..];
        let precision = cluster.receiver_ranks.precision(k);
        for (r, e) in irradiance.iter_mut().enumerate() {
            *e += precision.unpack(line, r) * coefficient;
        }
    }
    irradiance
}

/// Errors of the receivers' irradiance under constant radiance, relative to π.
fn furnace_errors(baked: &BakedScene) -> Vec<f32> {
    baked
        .clusters
        .iter()
        .flat_map(|cluster| irradiance(baked, cluster, &constant_radiance(baked, cluster)))
        .map(|e| e / PI - 1.0)
        .collect()
}

fn root_mean_square(values: &[f32]) -> f32 {
    (values.iter().map(|v| v * v).sum::<f32>() / values.len() as f32).sqrt()
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

fn largest(values: &[f32]) -> f32 {
    values.iter().map(|v| v.abs()).fold(0.0, f32::max)
}

#[test]
fn the_papers_method_turns_constant_radiance_into_pi_times_it() {
    for name in ["furnace.glb", "cornell_empty.glb"] {
        let baked = quick_bake(name, Method::Paper);
        let errors = furnace_errors(&baked);
        assert!(mean(&errors).abs() < 2e-3, "{name}: {}", mean(&errors));
        assert!(largest(&errors) < 0.03, "{name}: one receiver is off by {}", largest(&errors));
        assert_eq!(baked.report.uncovered_fraction, 0.0);
    }
}

/// With nothing lost to compression, every gather ray brings its share of π, by whichever signal. What remains
/// is that patches which few receivers of a cluster see stay coarse, and that surfels' shares in them follow how
/// bright they are under random lightings: single dark places may err.
#[test]
fn uncompressed_signals_turn_constant_radiance_into_pi_times_it() {
    for near_radius in [None, Some(2.0)] {
        for name in ["furnace.glb", "cornell_empty.glb"] {
            let options = BakeOptions {
                near_radius,
                metric: Some(Metric::Plain),
                storage: Some(Storage::F16),
                max_cluster_error: Some(1e-9),
                max_rank: Some(256),
                ..quick(Method::Hybrid)
            };
            let baked = bake(load(name), &options, None, &Silent).unwrap();
            let errors = furnace_errors(&baked);
            assert!(mean(&errors).abs() < 2e-3, "{name}: {}", mean(&errors));
            assert!(root_mean_square(&errors) < 0.03, "{name}: {}", root_mean_square(&errors));
        }
    }
}

/// What compression keeps is the light that random lightings bring. In a bare room, where all light soon is
/// nearly uniform, that holds uniform light to the error asked for; elsewhere only the mean is safe: places that
/// no lighting reaches, such as the gap above the lamp of the Cornell box, may err by more.
#[test]
fn compressed_signals_keep_constant_radiance_about_as_well_as_asked() {
    let baked = quick_bake("furnace.glb", Method::Hybrid);
    let errors = furnace_errors(&baked);
    assert!(root_mean_square(&errors) < baked.settings.max_cluster_error, "{}", root_mean_square(&errors));
    assert!(mean(&errors).abs() < 5e-3, "{}", mean(&errors));
    let errors = furnace_errors(&quick_bake("cornell_empty.glb", Method::Hybrid));
    assert!(mean(&errors).abs() < 0.01, "{}", mean(&errors));
    // Negative control: with too few singular values the first comparison fails.
    let options = BakeOptions { max_rank: Some(1), ..quick(Method::Hybrid) };
    let errors = furnace_errors(&bake(load("furnace.glb"), &options, None, &Silent).unwrap());
    assert!(root_mean_square(&errors) > baked.settings.max_cluster_error, "{}", root_mean_square(&errors));
}

#[test]
fn an_error_that_is_asked_for_is_kept_by_every_cluster() {
    let largest_error = |wanted, max_rank| {
        let options = BakeOptions { max_cluster_error: Some(wanted), max_rank, ..quick(Method::Hybrid) };
        bake(load("cornell_empty.glb"), &options, None, &Silent).unwrap().report.max_cluster_error
    };
    for wanted in [0.1, 0.01, 0.002] {
        let error = largest_error(wanted, None);
        assert!(error <= f64::from(wanted) && error > 0.5 * f64::from(wanted), "{error} of {wanted}");
    }
    // Negative control: so few singular values do not suffice.
    assert!(largest_error(0.01, Some(4)) > 0.01);
}

/// The largest irradiance on the floors of the sunlit room A and of the sealed room C of `rooms.glb`.
fn brightest_of_rooms(baked: BakedScene, lamp: Vec3) -> [f32; 2] {
    let mut runtime = Runtime::new(Arc::new(baked));
    let lights = vec![Light::Point { position: lamp, intensity: Vec3::splat(20.0), range: None }];
    runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
    runtime.converge(1e-4, 50);
    // Room A and room C begin at these x; both are 5 m deep in z.
    [0.4, 6.4].map(|west| {
        let floor = |i: usize| Vec3::new(west + 0.3 * (i % 12) as f32, 0.0, 0.3 + 0.4 * (i / 12) as f32);
        let places = (0..12 * 12).map(floor);
        let lit = places.filter_map(|place| runtime.irradiance_at(place, Vec3::Y));
        lit.map(Vec3::max_element).fold(0.0, f32::max)
    })
}

/// Lamps in the middle of room A and of room C.
const LAMPS: [Vec3; 2] = [Vec3::new(4.2, 2.4, 1.6), Vec3::new(8.0, 2.4, 2.5)];

#[test]
fn a_sealed_room_stays_exactly_dark() {
    // The rooms are a twentieth of the scene's area; texels must be small against them and their walls' gaps.
    let options = BakeOptions { receivers: Some(6000), ..quick(Method::Hybrid) };
    let baked = bake(load("rooms.glb"), &options, None, &Silent).unwrap();
    let [lit, sealed] = brightest_of_rooms(baked.clone(), LAMPS[0]);
    assert!(lit > 0.1, "room A: {lit}");
    assert!(sealed <= 1e-6 * lit, "room C is lit through its walls: {sealed} of {lit}");
    // Negative control: a lamp within room C is seen there.
    let [dark, lit] = brightest_of_rooms(baked, LAMPS[1]);
    assert!(lit > 0.1 && dark <= 1e-6 * lit, "room C: {lit}, room A: {dark}");
}
