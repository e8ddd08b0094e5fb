//! Bakes of the bundled scenes: closed forms and structural promises.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_math::glam::Vec2;
use probelight_math::sh::Y00;
use probelight_scene::{Scene, load_gltf};
use probelight_trace::{Progress, Silent};

fn load(name: &str) -> Arc<Scene> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name);
    Arc::new(load_gltf(&path).unwrap())
}

fn quick() -> BakeOptions {
    BakeOptions {
        receivers: Some(1500),
        gather_rays: Some(64),
        relight_rays: Some(64),
        sh_degree: Some(4),
        ..BakeOptions::default()
    }
}

fn quick_bake(name: &str) -> BakedScene {
    bake(load(name), &quick(), None, &Silent).unwrap()
}

/// Irradiance of every receiver when every probe coefficient (0, 0) is `constant` and the others are zero.
fn irradiance_under_constant_radiance(baked: &BakedScene, radiance: f32) -> Vec<f32> {
    let lambda = radiance / Y00;
    let mut irradiance = Vec::new();
    for cluster in &baked.clusters {
        let (columns, height) = (baked.column_count(cluster), cluster.receiver_count as usize);
        let coefficients: Vec<f32> = (0..cluster.rank as usize)
            .map(|k| {
                let row =
                    &baked.signal_basis[cluster.signal_basis_offset as usize + k * columns..][..columns];
                let constant: f32 = row[..cluster.probe_count as usize].iter().map(|v| v.to_f32()).sum();
                constant * lambda * baked.row_scales[cluster.row_scale_offset as usize + k]
            })
            .collect();
        let basis = &baked.receiver_basis[cluster.receiver_basis_offset as usize..];
        irradiance.extend((0..height).map(|r| {
            coefficients.iter().enumerate().map(|(k, b)| basis[k * height + r].to_f32() * b).sum::<f32>()
        }));
    }
    irradiance
}

#[test]
fn closed_rooms_turn_constant_radiance_into_pi_times_it() {
    for name in ["furnace.glb", "cornell_empty.glb"] {
        let baked = quick_bake(name);
        let irradiance = irradiance_under_constant_radiance(&baked, 2.0);
        let expected = 2.0 * std::f32::consts::PI;
        let mean = irradiance.iter().sum::<f32>() / irradiance.len() as f32;
        assert!((mean / expected - 1.0).abs() < 2e-3, "{name}: {mean} instead of {expected}");
        let worst = irradiance.iter().map(|e| (e / expected - 1.0).abs()).fold(0.0, f32::max);
        assert!(worst < 0.03, "{name}: one receiver is off by {worst}");
        assert_eq!(baked.report.uncovered_fraction, 0.0);
    }
}

#[test]
fn every_texel_has_one_receiver_and_charts_never_overlap() {
    let baked = quick_bake("cornell.glb");
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
fn floor_texels_under_the_blocks_are_invalid() {
    let baked = quick_bake("cornell.glb");
    let share = baked.report.invalid_texels as f64 / baked.report.chart_texels as f64;
    // The blocks stand on 2 × 1.65² m² of about 190 m².
    assert!((0.005..0.06).contains(&share), "{share}");
    let empty = quick_bake("cornell_empty.glb").report;
    assert!((empty.invalid_texels as f64) < 0.002 * empty.chart_texels as f64);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads_or_an_interruption() {
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(load("rooms.glb"), &quick(), None, &Silent).unwrap())
    };
    let one = with_threads(1);
    assert_same(&one, &with_threads(3));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rooms.partial");
    let interrupted = bake(load("rooms.glb"), &quick(), Some(&path), &StopInGather::default());
    assert!(matches!(interrupted, Err(BakeError::Cancelled)));
    assert!(path.exists());
    let resumed = bake(load("rooms.glb"), &quick(), Some(&path), &Silent).unwrap();
    assert_same(&one, &resumed);
    assert!(!path.exists());
}

#[test]
fn another_seed_gives_another_result() {
    // Negative control of the comparison above.
    let other = BakeOptions { seed: Some(1), ..quick() };
    let a = quick_bake("cornell_empty.glb");
    let b = bake(load("cornell_empty.glb"), &other, None, &Silent).unwrap();
    assert!(a.signal_basis != b.signal_basis);
}

fn assert_same(a: &BakedScene, b: &BakedScene) {
    assert_eq!(a.receiver_texels, b.receiver_texels);
    assert_eq!(a.probes, b.probes);
    assert_eq!(a.relight_points, b.relight_points);
    assert_eq!(a.clusters, b.clusters);
    assert!(a.receiver_basis == b.receiver_basis && a.signal_basis == b.signal_basis);
    assert_eq!(a.row_scales, b.row_scales);
    assert_eq!(a.report, b.report);
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
        BakeOptions { receivers: Some(0), ..quick() },
        BakeOptions { sh_degree: Some(12), ..quick() },
        BakeOptions { texels_per_meter: Some(f32::NAN), ..quick() },
        BakeOptions { probe_density: Some(-1.0), ..quick() },
        BakeOptions { gather_rays: Some(0), ..quick() },
    ] {
        let error = bake(load("furnace.glb"), &options, None, &Silent).unwrap_err();
        assert!(matches!(error, BakeError::Option { .. }), "{error}");
    }
}
