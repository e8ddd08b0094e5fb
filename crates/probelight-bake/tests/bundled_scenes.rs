//! Bakes of the bundled scenes: closed forms and structural promises.

mod support;

use std::collections::HashSet;
use std::sync::Arc;

use probelight_asset::{BakedScene, Method, NONE};
use probelight_bake::{BakeError, BakeOptions, Quality, bake};
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::Runtime;
use probelight_scene::{Lighting, Sky};
use probelight_trace::{Progress, Silent};

use support::{METHODS, load, quick, quick_bake};

#[test]
fn every_texel_has_one_receiver_and_charts_never_overlap() {
    let baked = quick_bake("cornell.glb", Method::Hybrid);
    let texels: HashSet<u32> = baked.receiver_texels.iter().copied().collect();
    assert_eq!(texels.len(), baked.receiver_texels.len());
    for [texel, source] in &baked.lightmap.dilation {
        assert!(!texels.contains(texel) && texels.contains(source));
    }
    // Sample points of different faces never share a place in the lightmap.
    let mut owner = std::collections::HashMap::new();
    for (face, layout) in baked.lightmap.faces.iter().enumerate() {
        for i in 0..400 {
            let u = probelight_math::sampling::sobol_owen(i, 3);
            let position = layout.position(probelight_math::sampling::triangle_from_square(u));
            let place = (position * 64.0).as_ivec2();
            let inside = layout.corners.iter().all(|c| c.distance(position) > 0.5);
            if let Some(other) = owner.insert(place, (face, position))
                && inside
                && other.0 != face
            {
                assert!(shares_edge(&baked, face, other.0), "faces {face} and {} overlap", other.0);
            }
        }
    }
}

fn shares_edge(baked: &BakedScene, a: usize, b: usize) -> bool {
    let corners = |face: usize| baked.lightmap.faces[face].corners;
    let near = |p: Vec2, q: Vec2| p.distance(q) < 1e-2;
    corners(a).into_iter().filter(|p| corners(b).into_iter().any(|q| near(*p, q))).count() >= 2
}

#[test]
fn the_floor_under_the_blocks_costs_no_receivers() {
    let lit = |name| {
        let baked = quick_bake(name, Method::Hybrid);
        let lighting = Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() };
        let mut runtime = Runtime::new(Arc::new(baked));
        runtime.set_lighting(lighting).unwrap();
        runtime.converge(1e-3, 50);
        // The middles of the two blocks, and the floor beside them.
        [[1.86, 1.69], [3.68, 3.51], [3.68, 1.7], [1.7, 3.6]]
            .map(|[x, z]| runtime.irradiance_at(Vec3::new(x, 0.0, z), Vec3::Y).unwrap().y > 0.0)
    };
    assert_eq!(lit("cornell.glb"), [false, false, true, true]);
    assert_eq!(lit("cornell_empty.glb"), [true; 4]);
}

#[test]
fn hidden_texels_are_few_where_faces_that_are_wholly_hidden_have_none() {
    for name in ["cornell.glb", "cornell_empty.glb"] {
        let report = quick_bake(name, Method::Hybrid).into_parts().report;
        let share = report.invalid_texels as f64 / report.chart_texels as f64;
        assert!(share < 0.005, "{name}: {share}");
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads_or_an_interruption() {
    for method in METHODS {
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| quick_bake("cornell.glb", method))
        };
        let one = with_threads(1);
        assert_same(&one, &with_threads(3));

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cornell.partial");
        let interrupted = bake(load("cornell.glb"), &quick(method), Some(&path), &StopInGather::default());
        assert!(matches!(interrupted, Err(BakeError::Cancelled)));
        assert!(path.exists());
        let resumed = bake(load("cornell.glb"), &quick(method), Some(&path), &Silent).unwrap();
        assert_same(&one, &resumed);
        assert!(!path.exists());
    }
}

#[test]
fn another_seed_gives_another_result() {
    // Negative control of the comparison above.
    for method in METHODS {
        let other = BakeOptions { seed: Some(1), ..quick(method) };
        let a = quick_bake("cornell_empty.glb", method);
        let b = bake(load("cornell_empty.glb"), &other, None, &Silent).unwrap();
        assert!(bytes_of(&a) != bytes_of(&b) && a.signal_basis != b.signal_basis);
    }
}

/// Whether two bakes are the same file.
fn assert_same(a: &BakedScene, b: &BakedScene) {
    assert!(bytes_of(a) == bytes_of(b));
}

fn bytes_of(baked: &BakedScene) -> Vec<u8> {
    let mut bytes = Vec::new();
    baked.write_to(&mut bytes).unwrap();
    bytes
}

#[test]
fn each_method_has_its_own_signals_and_the_rest_follows() {
    let paper = quick_bake("cornell.glb", Method::Paper);
    assert!(paper.surfel_groups.is_empty() && paper.emitters.is_empty() && paper.cluster_signals.is_empty());
    assert!(!paper.probes.is_empty() && paper.clusters.iter().all(|c| c.signal_ranks.f16 == c.rank()));
    let rays_to_surfaces = paper.relight_surfels.iter().filter(|s| **s != NONE).count();
    assert_eq!(paper.surfels.len(), rays_to_surfaces, "every relight ray evaluates light of its own");

    let wide = BakeOptions { near_radius: Some(100.0), ..quick(Method::Hybrid) };
    let hybrid = bake(load("cornell.glb"), &wide, None, &Silent).unwrap();
    assert_eq!(hybrid.emitters.len(), 1, "the ceiling lamp");
    assert!(hybrid.probes.is_empty() && hybrid.clusters.iter().all(|c| c.probe_count == 0));
    assert!(hybrid.clusters.iter().all(|c| c.signal_ranks.f16 == 0 && c.rank() > 0));
    assert!(hybrid.surfels.len() < hybrid.receiver_texels.len());

    let near = BakeOptions { near_radius: Some(1.0), ..quick(Method::Hybrid) };
    let near = bake(load("cornell.glb"), &near, None, &Silent).unwrap();
    assert!(!near.probes.is_empty() && near.clusters.iter().any(|c| c.probe_count > 0 && c.signal_count > 0));
}

#[test]
fn options_win_over_the_quality_and_the_quality_over_the_defaults() {
    let settings = |options: &BakeOptions| {
        bake(load("furnace.glb"), options, None, &Silent).unwrap().into_parts().settings
    };
    let preset = Quality::Production.preset();
    let produced = BakeOptions {
        quality: Some(Quality::Production),
        gather_rays: Some(16),
        receivers: Some(200),
        ..BakeOptions::default()
    };
    let produced = settings(&produced);
    assert_eq!((produced.gather_rays, produced.max_rank), (16, preset.max_rank));
    assert_eq!(produced.max_cluster_error, preset.max_cluster_error);
    let preview = BakeOptions {
        quality: Some(Quality::Preview),
        receivers: Some(200),
        max_cluster_error: Some(0.5),
        ..BakeOptions::default()
    };
    let preview = settings(&preview);
    assert_eq!(
        preview.gather_rays,
        4 * Quality::Preview.preset().gather_rays,
        "few receivers, more rays each"
    );
    assert_eq!(preview.max_cluster_error, 0.5);
}

/// Cancels once some receivers are gathered.
#[derive(Default)]
struct StopInGather {
    gathering: std::sync::atomic::AtomicBool,
    gathered: std::sync::atomic::AtomicU64,
}

impl Progress for StopInGather {
    fn begin(&self, stage: &str, _total: u64) {
        self.gathering.store(stage == "gathering light", std::sync::atomic::Ordering::Relaxed);
    }

    fn advance(&self, steps: u64) {
        if self.gathering.load(std::sync::atomic::Ordering::Relaxed) {
            self.gathered.fetch_add(steps, std::sync::atomic::Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.gathered.load(std::sync::atomic::Ordering::Relaxed) > 0
    }
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    for options in [
        BakeOptions { receivers: Some(0), ..quick(Method::Hybrid) },
        BakeOptions { sh_degree: Some(12), ..quick(Method::Hybrid) },
        BakeOptions { texels_per_meter: Some(f32::NAN), ..quick(Method::Hybrid) },
        BakeOptions { probe_density: Some(-1.0), ..quick(Method::Hybrid) },
        BakeOptions { gather_rays: Some(0), ..quick(Method::Hybrid) },
        BakeOptions { surfel_size: Some(0.0), ..quick(Method::Hybrid) },
        BakeOptions { samples_per_surfel: Some(0), ..quick(Method::Hybrid) },
        BakeOptions { near_radius: Some(f32::INFINITY), ..quick(Method::Hybrid) },
        BakeOptions { max_cluster_error: Some(0.0), ..quick(Method::Hybrid) },
    ] {
        let error = bake(load("furnace.glb"), &options, None, &Silent).unwrap_err();
        assert!(matches!(error, BakeError::Option { .. }), "{error}");
    }
}
