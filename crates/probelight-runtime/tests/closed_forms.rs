//! Baked scenes whose right answer is known on paper.
#![cfg(feature = "cpu")]

mod support;

use std::f32::consts::PI;

use half::f16;
use probelight_asset::packed::{Precision, Ranks};
use probelight_asset::{BakedParts, Emitter, LightSample, Surfel, SurfelGroup};
use probelight_math::glam::{Vec2, Vec3, vec2};
use probelight_runtime::{FrameInput, Runtime};
use probelight_scene::{Light, Lighting, Sky};
use support::{SMALL, Size, all_lights, checked, floor_and_shade, material, random_room, single_probe};
use support::{uniform_sky, white_sample};

fn runtime(parts: BakedParts) -> Runtime {
    Runtime::new(checked(parts))
}

#[test]
fn constant_radiance_has_only_the_constant_coefficient() {
    let radiance = Vec3::new(0.5, 1.0, 2.0);
    let mut runtime = runtime(single_probe(floor_and_shade(), None, &[PI]));
    runtime.set_lighting(uniform_sky(radiance)).unwrap();
    runtime.step(&FrameInput::default());
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
    let mut runtime = runtime(single_probe(floor_and_shade(), None, &[PI]));
    runtime.set_lighting(all_lights()).unwrap();
    runtime.step(&FrameInput::default());
    assert!(runtime.probe_radiance().coefficients(0, 0)[1..].iter().any(|c| c.abs() > 0.01));
}

#[test]
fn furnace_converges_to_the_geometric_series() {
    let (albedo, emitted) = (Vec3::new(0.5, 0.8, 0.0), Vec3::new(1.0, 2.0, 3.0));
    let mut scene = floor_and_shade();
    scene.materials[0] = material(albedo, emitted);
    let gain = f16::from_f32(PI).to_f32();
    let mut runtime = runtime(single_probe(scene, Some(white_sample()), &[gain]));
    // E = gain · (Le + ρ/π · E): the n-th step has n terms of the series.
    let bounce = albedo * gain / PI;
    let mut expected = Vec3::ZERO;
    for _ in 0..4 {
        runtime.step(&FrameInput::default());
        expected = gain * emitted + bounce * expected;
        assert!((runtime.irradiance().texels[0] / expected).abs_diff_eq(Vec3::ONE, 1e-5));
    }
    let convergence = runtime.converge(1e-6, 200);
    assert!(convergence.change <= 1e-6 && (20..100).contains(&convergence.steps), "{convergence:?}");
    let limit = gain * emitted / (Vec3::ONE - bounce);
    assert!((runtime.irradiance().texels[0] / limit).abs_diff_eq(Vec3::ONE, 2e-5));
    runtime.reset();
    assert_eq!(runtime.irradiance().texels[0], Vec3::ZERO);
    runtime.step(&FrameInput::default());
    assert!((runtime.irradiance().texels[0] / (gain * emitted)).abs_diff_eq(Vec3::ONE, 1e-5));
}

#[test]
fn without_bounces_surfaces_emit_and_reflect_nothing() {
    let (albedo, emitted) = (Vec3::new(0.5, 0.8, 0.2), Vec3::new(1.0, 2.0, 3.0));
    let mut scene = floor_and_shade();
    scene.materials[0] = material(albedo, emitted);
    let gain = f16::from_f32(PI).to_f32();
    let mut runtime = runtime(single_probe(scene, Some(white_sample()), &[gain]));
    let light = |runtime: &mut Runtime| {
        runtime.converge(1e-7, 200);
        runtime.irradiance().texels[0]
    };
    let all = light(&mut runtime);
    runtime.set_bounces(false);
    let alone = light(&mut runtime);
    assert!((alone / (gain * emitted)).abs_diff_eq(Vec3::ONE, 1e-5), "{alone}");
    assert_eq!(runtime.surface_colors(0).unwrap().base_color, albedo, "the material is what it was");
    runtime.set_bounces(true);
    assert!((light(&mut runtime) / all).abs_diff_eq(Vec3::ONE, 1e-5), "and all comes back");
    assert!(all.cmpgt(1.1 * alone).all());
}

#[test]
fn converge_stops_at_its_limit_and_in_darkness() {
    let mut runtime = runtime(random_room(SMALL));
    assert_eq!(runtime.converge(0.0, 3).steps, 3);
    runtime.set_lighting(Lighting { emissive_scale: 0.0, ..Lighting::default() }).unwrap();
    runtime.reset();
    let convergence = runtime.converge(1e-6, 9);
    assert_eq!((convergence.steps, convergence.change), (1, 0.0));
}

#[test]
fn point_light_reaches_the_side_of_the_sample() {
    let lit = |side: bool, height: f32| {
        // At (2, 0, ½).
        let sample = LightSample::new(0, side, Vec2::splat(2.5 / 6.0), [255; 3]);
        let mut runtime = runtime(single_probe(floor_and_shade(), Some(sample), &[1.0]));
        let position = Vec3::new(2.0, height, 0.5);
        let lights = vec![Light::Point { position, intensity: Vec3::splat(8.0 * PI), range: None }];
        runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
        runtime.step(&FrameInput::default());
        runtime.surfel_radiance()[0]
    };
    // L = ρ/π · I/d², with the floor's albedo.
    let expected = Vec3::new(0.7, 0.5, 0.3) * 2.0;
    assert!(lit(false, 2.0).abs_diff_eq(expected, 1e-5));
    assert_eq!(lit(true, 2.0), Vec3::ZERO);
    assert!(lit(true, -2.0).abs_diff_eq(expected, 1e-5));
}

#[test]
fn shadows_fall_and_back_faces_do_not_emit() {
    let shine = |at: Vec2, triangle: u32, side: bool| {
        let sample = LightSample::new(triangle, side, at, [255; 3]);
        let mut runtime = runtime(single_probe(floor_and_shade(), Some(sample), &[1.0]));
        let lights = vec![Light::Directional { direction: -Vec3::Y, irradiance: Vec3::splat(PI) }];
        runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
        runtime.step(&FrameInput::default());
        runtime.surfel_radiance()[0]
    };
    // At (2, 0, 0) and at (½, 0, 0), below the shade.
    assert!(shine(vec2(1.0 / 3.0, 0.5), 0, false).abs_diff_eq(Vec3::new(0.7, 0.5, 0.3), 1e-5));
    assert_eq!(shine(vec2(0.5 / 6.0, 0.5), 0, false), Vec3::ZERO);
    let front = Vec3::new(1.0, 2.0, 0.5) + Vec3::new(0.2, 0.4, 0.6);
    assert!(shine(Vec2::splat(0.25), 2, false).abs_diff_eq(front, 1e-5));
    assert_eq!(shine(Vec2::splat(0.25), 2, true), Vec3::ZERO);
}

/// A floor that emits and reflects, with samples of some colours, which read no texel.
fn floor_of(emission: Vec3, samples: &[[u8; 3]], surfels: &[u32]) -> BakedParts {
    let mut scene = floor_and_shade();
    scene.materials[0] = material(Vec3::ONE, emission);
    let mut baked = single_probe(scene, None, &[1.0]);
    // At (2, 0, ½).
    let sample = |color: [u8; 3]| LightSample::new(0, false, Vec2::splat(2.5 / 6.0), color);
    baked.light_samples = samples.iter().copied().map(sample).collect();
    for sample_count in surfels.iter().copied() {
        let first_sample = baked.surfels.last().map_or(0, |last| last.first_sample + last.sample_count);
        baked.surfels.push(Surfel { first_sample, sample_count, area: 0.0 });
    }
    baked
}

#[test]
fn surfels_are_means_of_samples_and_groups_of_surfels() {
    let colors = [[255, 0, 0], [0, 255, 0], [0, 0, 0], [0, 0, 255]];
    let mut baked = floor_of(Vec3::ZERO, &colors, &[3, 1]);
    baked.surfel_groups = vec![
        SurfelGroup { children: [0, 1], first_weight: 0.75 },
        SurfelGroup { children: [1, 2], first_weight: 0.5 },
        SurfelGroup { children: [3, 3], first_weight: 1.0 },
    ];
    let mut runtime = runtime(baked);
    let lights = vec![Light::Directional { direction: -Vec3::Y, irradiance: Vec3::splat(PI) }];
    runtime.set_lighting(Lighting { lights, ..Lighting::default() }).unwrap();
    runtime.step(&FrameInput::default());
    let expected = [
        Vec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0),
        Vec3::Z,
        Vec3::new(0.25, 0.25, 0.25),
        Vec3::new(0.125, 0.125, 0.625),
        Vec3::new(0.125, 0.125, 0.625),
    ];
    for (signal, expected) in runtime.signals().values().iter().zip(expected) {
        assert!(signal.abs_diff_eq(expected, 1e-6), "{signal} for {expected}");
    }
    assert_eq!(runtime.signals().values().len(), 5);
}

#[test]
fn emitters_shine_in_place_of_their_surfels() {
    let mean_texel = Vec3::new(0.5, 0.25, 1.0);
    let mut baked = floor_of(Vec3::ONE, &[[255; 3]], &[1]);
    let signals = |baked: BakedParts, lighting: Lighting| {
        let mut runtime = runtime(baked);
        runtime.set_lighting(lighting).unwrap();
        runtime.set_emission(0, Vec3::new(2.0, 4.0, 1.0)).unwrap();
        runtime.step(&FrameInput::default());
        runtime.signals().values().to_vec()
    };
    let bright = Lighting { emissive_scale: 3.0, ..Lighting::default() };
    assert_eq!(signals(baked.clone(), bright.clone()), [Vec3::new(6.0, 12.0, 3.0)]);
    // An emitter of another material changes nothing.
    baked.emitters = vec![Emitter { material: 1, mean_texel: Vec3::ZERO }];
    assert_eq!(signals(baked.clone(), bright.clone()), [Vec3::new(6.0, 12.0, 3.0), Vec3::ZERO]);
    baked.emitters = vec![Emitter { material: 0, mean_texel }];
    assert_eq!(signals(baked.clone(), bright), [Vec3::ZERO, Vec3::new(3.0, 3.0, 3.0)]);
    let off = Lighting { emissive_scale: 0.0, ..Lighting::default() };
    assert_eq!(signals(baked, off), [Vec3::ZERO; 2]);
}

#[test]
fn sky_with_signals_of_its_own_is_dark_to_probes() {
    let mut baked = single_probe(floor_and_shade(), None, &[1.0]);
    baked.settings.sky_degree = Some(2);
    let mut runtime = runtime(baked);
    // Linear in y, so that bands 0 and 1 hold all of it.
    let (horizon, slope) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 0.0, -1.0));
    let sky = Sky::Gradient { zenith: horizon + slope, horizon, ground: horizon - slope };
    runtime.set_lighting(Lighting { sky, ..Lighting::default() }).unwrap();
    runtime.step(&FrameInput::default());
    assert_eq!(runtime.receiver_irradiance()[0], Vec3::ZERO);
    let signals = runtime.signals().values();
    assert_eq!(signals.len(), 9);
    for (j, signal) in signals.iter().enumerate() {
        let expected = match j {
            0 => horizon * 2.0 * PI.sqrt(),
            1 => slope * (4.0 * PI / 3.0).sqrt(),
            _ => Vec3::ZERO,
        };
        assert!(signal.abs_diff_eq(expected, 2e-5), "{j}: {signal} for {expected}");
    }
}

/// With U and ΣVᵀ the identity, receiver i is the i-th column: first the scalar signals, then the probes'
/// coefficients in the order of bands.
#[test]
fn identity_matrices_pass_the_columns_in_order() {
    let (probes, scalars, columns) = (2, 3, 11);
    let all = columns as u32;
    let ranks = [
        Ranks { f16: all, ..Ranks::default() },
        Ranks { snorm8: all, ..Ranks::default() },
        Ranks { snorm4: all, ..Ranks::default() },
        Ranks { f16: 4, snorm8: 5, snorm4: 2 },
    ];
    for ranks in ranks {
        let size = Size {
            clusters: 1,
            receivers_per_cluster: columns,
            receiver_ranks: ranks,
            signal_ranks: ranks,
            signals_per_cluster: scalars,
            probes,
            probes_per_cluster: probes,
            sh_degree: 1,
            ..SMALL
        };
        let mut baked = random_room(size);
        (baked.receiver_basis, baked.signal_basis) = (identity(ranks, columns), identity(ranks, columns));
        baked.row_scales.fill(1.0);
        baked.column_exponents.fill(8);
        let numbers = baked.cluster_signals.clone();
        let mut runtime = runtime(baked);
        runtime.set_lighting(all_lights()).unwrap();
        runtime.step(&FrameInput::default());
        let coefficient = |(probe, j): (usize, usize)| {
            Vec3::from([0, 1, 2].map(|c| runtime.probe_radiance().coefficients(probe, c)[j]))
        };
        let order = [(0, 0), (1, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3)].map(coefficient);
        let signals = numbers.iter().map(|number| runtime.signals().values()[*number as usize]);
        for (receiver, column) in runtime.receiver_irradiance().iter().zip(signals.chain(order)) {
            // An exponent of eight is a factor of one half.
            assert!(receiver.abs_diff_eq(0.5 * column, 1e-6 * column.length()), "{receiver} for {column}");
        }
    }
}

fn identity(ranks: Ranks, count: usize) -> Vec<u32> {
    let mut words = Vec::new();
    for k in 0..count {
        let line: Vec<f32> = (0..count).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        let precision: Precision = ranks.precision(k);
        precision.pack(&line, &mut words);
    }
    words
}
