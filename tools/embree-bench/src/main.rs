//! Measures ray throughput of `probelight-trace` and Embree on one thread: the same mesh, the same rays in the
//! same order, all made beforehand, the two taking turns so that a busy machine slows both.
//!
//! ```text
//! cargo run --release -p embree-bench -- [SCENE.glb] [LIBEMBREE.so]
//! ```
//!
//! Embree is opened at run time. Without a path the usual names are tried; get it by
//! `apt-get install libembree3-3`, or as version 4 out of the Python wheel `embreex` (a .zip file).

mod embree;
#[path = "../../../crates/probelight-trace/benches/ray_sets/mod.rs"]
mod ray_sets;

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use embree::{Embree, RayHit};
use probelight_scene::Scene;
use probelight_trace::{Ray, Tracer};

/// Random surface points, 256 rays each.
const RECEIVERS: u32 = 2048;

/// How often each side traces all rays; the fastest time of each turn counts.
const ROUNDS: usize = 9;

/// Rays one side traces before it is the other's turn: so few milliseconds that other work on the machine
/// leaves many turns undisturbed.
const RAYS_PER_TURN: usize = 4096;

/// Names under which Linux distributions install Embree.
const USUAL_NAMES: [&str; 4] = ["libembree4.so.4", "libembree4.so", "libembree3.so.3", "libembree3.so"];

fn main() -> Result<()> {
    let mut arguments = std::env::args_os().skip(1);
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenes/atrium.glb");
    let path = PathBuf::from(arguments.next().unwrap_or_else(|| bundled.into()));
    let scene = Arc::new(probelight_scene::load_gltf(&path)?);
    let embree = open_embree(arguments.next(), &scene)?;
    let tracer = Tracer::new(scene.clone());
    println!(
        "{}: {} triangles; Embree {}.{}.{}",
        path.display(),
        scene.triangles.len(),
        embree.version / 10_000,
        embree.version / 100 % 100,
        embree.version % 100
    );

    let gather = ray_sets::gather_rays(&tracer, RECEIVERS);
    let segments = ray_sets::visibility_segments(&tracer, &gather);
    report(
        "closest hit, gather rays",
        &gather,
        |rays| rays.iter().filter(|ray| tracer.closest_hit(ray).is_some()).count(),
        |rays| rays.iter_mut().filter_map(|ray| traced(&embree, ray)).count(),
    );
    report(
        "occlusion, visibility segments",
        &segments,
        |rays| rays.iter().filter(|ray| tracer.is_occluded(ray)).count(),
        |rays| rays.iter_mut().filter_map(|ray| embree.is_occluded(ray).then_some(())).count(),
    );
    Ok(())
}

fn traced(embree: &Embree, ray: &mut RayHit) -> Option<(u32, f32)> {
    embree.intersect(ray);
    ray.hit()
}

fn open_embree(wanted: Option<OsString>, scene: &Scene) -> Result<Embree> {
    if let Some(name) = wanted {
        return Embree::new(&name, scene);
    }
    USUAL_NAMES.iter().find_map(|name| Embree::new(OsStr::new(name), scene).ok()).context(
        "no Embree found: `apt-get install libembree3-3`, or give the path of a libembree .so as second \
         argument (the Python wheel `embreex` holds one of version 4)",
    )
}

/// Lets both sides trace `rays` in turns and prints millions of rays a second, their ratio, and how many rays
/// each says hit something.
fn report(what: &str, rays: &[Ray], ours: impl Fn(&[Ray]) -> usize, theirs: impl Fn(&mut [RayHit]) -> usize) {
    let queries: Vec<RayHit> = rays.iter().map(RayHit::new).collect();
    let turns = rays.len().div_ceil(RAYS_PER_TURN);
    let mut best = vec![[Duration::MAX; 2]; turns];
    let mut hits = [0, 0];
    for _ in 0..ROUNDS {
        // Embree overwrites its queries, so each round gets fresh ones, made outside the measured time.
        let mut queries = queries.clone();
        hits = [0, 0];
        let turns = rays.chunks(RAYS_PER_TURN).zip(queries.chunks_mut(RAYS_PER_TURN));
        for (best, (rays, queries)) in best.iter_mut().zip(turns) {
            let start = Instant::now();
            hits[0] += ours(rays);
            let middle = Instant::now();
            hits[1] += theirs(queries);
            best[0] = best[0].min(middle - start);
            best[1] = best[1].min(middle.elapsed());
        }
    }
    let [our_time, their_time] = [0, 1].map(|side| best.iter().map(|turn| turn[side]).sum::<Duration>());
    let [our_hits, their_hits] = hits;
    let rate = |time: Duration| rays.len() as f64 / time.as_secs_f64() * 1e-6;
    println!(
        "{what}: {} rays; Probelight {:.2} Mrays/s, Embree {:.2} Mrays/s, ratio {:.2}; hits {our_hits} and {their_hits}",
        rays.len(),
        rate(our_time),
        rate(their_time),
        rate(our_time) / rate(their_time),
    );
}
