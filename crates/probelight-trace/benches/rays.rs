//! Ray throughput on the atrium: `cargo bench -p probelight-trace`. For the same rays through Embree see
//! `tools/embree-bench`.

mod ray_sets;

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use probelight_trace::Tracer;

fn rays(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/atrium.glb");
    let scene = probelight_scene::load_gltf(&path).expect("the bundled atrium loads");
    let tracer = Tracer::new(Arc::new(scene));
    let gather = ray_sets::gather_rays(&tracer, 512);
    let segments = ray_sets::visibility_segments(&tracer, &gather);

    let mut group = criterion.benchmark_group("atrium");
    group.sample_size(10);
    group.throughput(Throughput::Elements(gather.len() as u64));
    group.bench_function("closest hit, gather rays", |bencher| {
        bencher.iter(|| gather.iter().filter(|ray| black_box(tracer.closest_hit(ray)).is_some()).count());
    });
    group.throughput(Throughput::Elements(segments.len() as u64));
    group.bench_function("occlusion, visibility segments", |bencher| {
        bencher.iter(|| segments.iter().filter(|ray| tracer.is_occluded(ray)).count());
    });
    group.finish();
}

criterion_group!(benches, rays);
criterion_main!(benches);
