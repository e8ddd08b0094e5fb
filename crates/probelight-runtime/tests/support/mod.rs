//! Baked scenes made by hand, and the slow truth of a frame.
#![allow(dead_code, reason = "each test binary uses a part")]

pub(crate) mod slow_frame;

use std::sync::Arc;

use probelight_asset::packed::{Precision, Ranks};
use probelight_asset::{
    BakedParts, BakedScene, GAIN_STEPS, LightSample, LightmapFace, LightmapLayout, NONE, Surfel,
};
use probelight_math::glam::{DVec3, Vec2, Vec3, vec2};
use probelight_math::sampling::Rng;
use probelight_math::sh::Y00;
#[allow(unused_imports, reason = "each test binary uses a part")]
pub(crate) use probelight_runtime::synthetic::{
    SyntheticSize as Size, add_quad, floor_and_shade, horizontal_quad, material,
    synthetic_lighting as all_lights, synthetic_room as random_room,
};
use probelight_runtime::{ClusterExtent, FADE_STEPS, FramePlan, ProbeExtent, Runtime};
use probelight_scene::{Lighting, Scene, Sky};

/// Largest difference, relative to the largest value (if there is one); NaN if there is one.
pub(crate) fn difference(found: impl IntoIterator<Item = Vec3>, expected: &[DVec3]) -> f64 {
    let found: Vec<Vec3> = found.into_iter().collect();
    assert_eq!(found.len(), expected.len());
    // `f64::max` would pass over NaN.
    let larger = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
    let largest = expected.iter().map(|e| e.abs().max_element()).fold(0.0, larger);
    let worst = found.iter().zip(expected).map(|(f, e)| difference_of_channels(f.as_dvec3() - *e));
    worst.fold(0.0, larger) / if largest > 0.0 { largest } else { 1.0 }
}

/// Largest of three absolute values, or NaN; `max_element` alone would pass over NaN.
fn difference_of_channels(difference: DVec3) -> f64 {
    if difference.is_nan() { f64::NAN } else { difference.abs().max_element() }
}

/// What the stages of both left behind, as relative differences.
pub(crate) fn stage_differences(runtime: &Runtime, slow: &slow_frame::SlowFrame) -> [f64; 5] {
    let cluster_coefficients = runtime.cluster_coefficients().values();
    [
        difference(runtime.signals().values().iter().copied(), &slow.signals),
        difference(probe_coefficients(runtime), &slow.coefficients.concat()),
        difference(cluster_coefficients.iter().map(|b| Vec3::from(*b)), &slow.cluster_coefficients),
        difference(runtime.receiver_irradiance().iter().copied(), &slow.irradiance),
        difference(runtime.irradiance().texels.iter().copied(), &slow.lightmap),
    ]
}

/// All coefficients of each probe.
pub(crate) fn probe_coefficients(runtime: &Runtime) -> Vec<Vec3> {
    let (baked, probes) = (runtime.baked(), runtime.probe_radiance());
    let of_probe = |p| {
        (0..baked.coefficients()).map(move |j| Vec3::from([0, 1, 2].map(|c| probes.coefficients(p, c)[j])))
    };
    (0..baked.probes.len()).flat_map(of_probe).collect()
}

/// Anything from nothing to all of each cluster and probe.
pub(crate) fn random_plan(baked: &BakedScene, rng: &mut Rng) -> FramePlan {
    let mut below = |most: u32| if rng.next_f32() < 0.2 { u32::MAX } else { rng.next_u32() % (most + 1) };
    let clusters: Vec<ClusterExtent> = baked
        .clusters
        .iter()
        .map(|cluster| ClusterExtent {
            rank: below(cluster.rank()),
            columns: below(baked.column_count(cluster) as u32),
            receivers: below(cluster.receiver_count),
            solid: below(cluster.rank()),
            fade: below(FADE_STEPS),
            fill: 0,
        })
        .collect();
    let rays = baked.relight_directions.len() as u32;
    let probes: Vec<ProbeExtent> = baked
        .probes
        .iter()
        .map(|_| ProbeExtent { rays: below(rays), degree: below(baked.settings.sh_degree) })
        .collect();
    FramePlan::new(baked, |cluster| clusters[cluster], |probe| probes[probe])
}

/// Small, with every remainder that the vector loops must handle.
pub(crate) const SMALL: Size = Size {
    clusters: 11,
    receivers_per_cluster: 101,
    receiver_ranks: Ranks { f16: 2, snorm8: 7, snorm4: 5 },
    signal_ranks: Ranks { f16: 6, snorm8: 1, snorm4: 7 },
    surfels: 70,
    samples_per_surfel: 5,
    surfel_groups: 30,
    emitters: 2,
    sky_degree: Some(2),
    signals_per_cluster: 37,
    probes: 19,
    probes_per_cluster: 3,
    rays: 60,
    sh_degree: 4,
    varied: true,
};

/// As [`SMALL`], but as published: relight rays that each see a point of their own or the sky, signals from
/// probes alone, half floats.
pub(crate) const SMALL_PAPER: Size = Size {
    receiver_ranks: Ranks { f16: 7, snorm8: 0, snorm4: 0 },
    signal_ranks: Ranks { f16: 7, snorm8: 0, snorm4: 0 },
    surfels: 19 * 60,
    samples_per_surfel: 1,
    surfel_groups: 0,
    emitters: 0,
    sky_degree: None,
    signals_per_cluster: 0,
    varied: false,
    ..SMALL
};

/// Parts that must be valid.
#[track_caller]
pub(crate) fn checked(parts: BakedParts) -> Arc<BakedScene> {
    Arc::new(BakedScene::new(parts).unwrap())
}

/// One probe whose rays all see `sample`, or else the sky, and one receiver per gain, side by side in the
/// lightmap: E of receiver i is `gains[i]` times the probe's mean radiance.
pub(crate) fn single_probe(scene: Scene, sample: Option<LightSample>, gains: &[f32]) -> BakedParts {
    let size = Size {
        clusters: 1,
        receivers_per_cluster: gains.len(),
        receiver_ranks: Ranks { f16: 1, ..Ranks::default() },
        signal_ranks: Ranks { f16: 1, ..Ranks::default() },
        probes: 1,
        probes_per_cluster: 1,
        rays: 64,
        sh_degree: 3,
        ..SMALL_PAPER
    };
    let mut baked = random_room(size);
    baked.lightmap = LightmapLayout {
        width: gains.len() as u32,
        height: 1,
        pages: 1,
        faces: vec![LightmapFace::default(); scene.triangles.len()],
        back_faces: vec![NONE; scene.triangles.len()],
        dilation: Vec::new(),
    };
    if sample.is_some() {
        // All of triangle 0 within texel 0.
        baked.lightmap.faces[0].corners = [vec2(0.5, 0.5), vec2(0.6, 0.5), vec2(0.5, 0.6)];
    }
    baked.receiver_texels = (0..gains.len() as u32).collect();
    baked.receiver_errors = vec![0; gains.len()];
    baked.surfels = sample.iter().map(|_| Surfel { first_sample: 0, sample_count: 1, area: 0.0 }).collect();
    baked.light_samples = sample.into_iter().collect();
    baked.relight_surfels = vec![if sample.is_some() { 0 } else { NONE }; size.rays];
    baked.relight_gains = vec![GAIN_STEPS; size.rays];
    baked.scene = scene.into();
    let columns = baked.column_count(&baked.clusters[0]);
    baked.column_exponents = vec![0; columns];
    baked.row_scales = vec![Y00];
    baked.signal_basis.clear();
    baked.receiver_basis.clear();
    let first_column: Vec<f32> = (0..columns).map(|c| if c == 0 { 1.0 } else { 0.0 }).collect();
    Precision::F16.pack(&first_column, &mut baked.signal_basis);
    Precision::F16.pack(gains, &mut baked.receiver_basis);
    baked
}

/// A sample on the front of triangle 0 with a white texture, which reads texel 0.
pub(crate) fn white_sample() -> LightSample {
    LightSample::new(0, false, Vec2::ZERO, [255; 3])
}

/// A lighting with nothing but a uniform sky.
pub(crate) fn uniform_sky(radiance: Vec3) -> Lighting {
    Lighting { sky: Sky::Uniform(radiance), ..Lighting::default() }
}
