//! Baked scenes whose right answer is known on paper.

mod support;

use std::f32::consts::PI;
use std::sync::Arc;

use half::f16;
use probelight_asset::{BakedScene, RelightPoint};
use probelight_math::glam::Vec3;
use probelight_runtime::Runtime;
use probelight_scene::{Light, Lighting};
use support::{SMALL, Size, all_lights, floor_and_shade, material, random_room, single_probe, sky_point};
use support::{uniform_sky, white_point};

fn runtime(baked: BakedScene) -> Runtime {
    Runtime::new(Arc::new(baked)).unwrap()
}

#[test]
fn constant_radiance_has_only_the_constant_coefficient() {
    let radiance = Vec3::new(0.5, 1.0, 2.0);
    let mut runtime = runtime(single_probe(floor_and_shade(), sky_point(), &[PI]));
    runtime.set_lighting(uniform_sky(radiance));
    runtime.step();
    for channel in 0..3 {
        let coefficients = runtime.probe_radiance().coefficients(0, channel);
        let expected = 2.0 * PI.sqrt() * radiance[channel];
        assert!((coefficients[0] - expected).abs() < 2e-6 * expected, "{} for {expected}", coefficients[0]);
        assert!(coefficients[1..].iter().all(|c| c.abs() < 2e-6 * expected), "{coefficients:?}");
    }
    // A receiver that sees this radiance everywhere: E = πL (π rounded to half precision).
    let expected = f16::from_f32(PI).to_f32() * radiance;
    assert!((runtime.receiver_irradiance()[0] / expected).abs_diff_eq(Vec3::ONE, 1e-5));
}

#[test]
fn sky_that_varies_has_other_coefficients_too() {
    let mut runtime = runtime(single_probe(floor_and_shade(), sky_point(), &[PI]));
    runtime.set_lighting(all_lights());
    runtime.step();
    assert!(runtime.probe_radiance().coefficients(0, 0)[1..].iter().any(|c| c.abs() > 0.01));
}

#[test]
fn furnace_converges_to_the_geometric_series() {
    let (albedo, emitted) = (Vec3::new(0.5, 0.8, 0.0), Vec3::new(1.0, 2.0, 3.0));
    let mut scene = floor_and_shade();
    scene.materials[0] = material(albedo, emitted);
    let gain = f16::from_f32(PI).to_f32();
    let mut runtime = runtime(single_probe(scene, white_point(), &[gain]));
    // E = gain · (Le + ρ/π · E): the n-th step has n terms of the series.
    let bounce = albedo * gain / PI;
    let mut expected = Vec3::ZERO;
    for _ in 0..4 {
        runtime.step();
        expected = gain * emitted + bounce * expected;
        assert!((runtime.irradiance().texels[0] / expected).abs_diff_eq(Vec3::ONE, 1e-5));
    }
    let convergence = runtime.converge(1e-6, 200);
    assert!(convergence.change <= 1e-6 && (20..100).contains(&convergence.steps), "{convergence:?}");
    let limit = gain * emitted / (Vec3::ONE - bounce);
    assert!((runtime.irradiance().texels[0] / limit).abs_diff_eq(Vec3::ONE, 2e-5));
    runtime.reset();
    assert_eq!(runtime.irradiance().texels[0], Vec3::ZERO);
    runtime.step();
    assert!((runtime.irradiance().texels[0] / (gain * emitted)).abs_diff_eq(Vec3::ONE, 1e-5));
}

#[test]
fn converge_stops_at_its_limit_and_in_darkness() {
    let mut runtime = runtime(random_room(SMALL));
    assert_eq!(runtime.converge(0.0, 3).steps, 3);
    runtime.set_lighting(Lighting { emissive_scale: 0.0, ..Lighting::default() });
    runtime.reset();
    let convergence = runtime.converge(1e-6, 9);
    assert_eq!((convergence.steps, convergence.change), (1, 0.0));
}

#[test]
fn point_light_reaches_the_side_that_was_hit() {
    let lit = |side: u8, height: f32| {
        let mut point = RelightPoint { position: Vec3::new(2.0, 0.0, 0.5), ..white_point() };
        point.base_color_and_side[3] = side;
        let mut runtime = runtime(single_probe(floor_and_shade(), point, &[1.0]));
        let position = Vec3::new(2.0, height, 0.5);
        let lights = vec![Light::Point { position, intensity: Vec3::splat(8.0 * PI) }];
        runtime.set_lighting(Lighting { lights, ..Lighting::default() });
        runtime.step();
        runtime.relight_radiance().values()[0]
    };
    // L = ρ/π · I/d², with the floor's albedo.
    let expected = Vec3::new(0.7, 0.5, 0.3) * 2.0;
    assert!(lit(0, 2.0).abs_diff_eq(expected, 1e-5));
    assert_eq!(lit(1, 2.0), Vec3::ZERO);
    assert!(lit(1, -2.0).abs_diff_eq(expected, 1e-5));
}

#[test]
fn shadows_fall_and_back_faces_do_not_emit() {
    let shine = |position: Vec3, triangle: u32, side: u8| {
        let mut point = RelightPoint { position, triangle, ..white_point() };
        point.base_color_and_side[3] = side;
        let mut runtime = runtime(single_probe(floor_and_shade(), point, &[1.0]));
        let lights = vec![Light::Directional { direction: -Vec3::Y, irradiance: Vec3::splat(PI) }];
        runtime.set_lighting(Lighting { lights, ..Lighting::default() });
        runtime.step();
        runtime.relight_radiance().values()[0]
    };
    assert!(shine(Vec3::new(2.0, 0.0, 0.0), 0, 0).abs_diff_eq(Vec3::new(0.7, 0.5, 0.3), 1e-5));
    assert_eq!(shine(Vec3::new(0.5, 0.0, 0.0), 0, 0), Vec3::ZERO);
    let front = Vec3::new(1.0, 2.0, 0.5) + Vec3::new(0.2, 0.4, 0.6);
    assert!(shine(Vec3::Y, 2, 0).abs_diff_eq(front, 1e-5));
    assert_eq!(shine(Vec3::Y, 2, 1), Vec3::ZERO);
}

/// With U and ΣVᵀ the identity, receiver i is the i-th signal.
#[test]
fn identity_matrices_pass_the_signals_in_the_order_of_bands() {
    let (probes, columns) = (2, 8);
    let size = Size {
        clusters: 1,
        receivers_per_cluster: columns,
        rank: columns,
        probes,
        probes_per_cluster: probes,
        rays: 40,
        sh_degree: 1,
    };
    let mut baked = random_room(size);
    let identity = |i: usize| if i.is_multiple_of(columns + 1) { f16::ONE } else { f16::ZERO };
    baked.receiver_basis = (0..columns * columns).map(identity).collect();
    baked.signal_basis = (0..columns * columns).map(identity).collect();
    baked.row_scales.fill(1.0);
    let mut runtime = runtime(baked);
    runtime.set_lighting(all_lights());
    runtime.step();
    let order = [(0, 0), (1, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3)];
    for (receiver, (probe, coefficient)) in runtime.receiver_irradiance().iter().zip(order) {
        for channel in 0..3 {
            assert_eq!(receiver[channel], runtime.probe_radiance().coefficients(probe, channel)[coefficient]);
        }
    }
}
