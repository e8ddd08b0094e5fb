//! Pictures of the GPU: against the CPU's, and against pictures that were looked at.
#![cfg(feature = "gpu")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;
mod support;

use probelight_render::gpu::{GpuView, Shading, ViewOptions};
use support::{GpuPictures, lit_scene};

#[test]
fn scratch() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    for name in ["cornell", "rooms", "atrium"] {
        let t = std::time::Instant::now();
        let lit = lit_scene(name);
        println!("{name} bake {:?}", t.elapsed());
        let t = std::time::Instant::now();
        let mut pictures = GpuPictures::new(gpu, &lit);
        println!("{name} new {:?}", t.elapsed());
        for view in GpuView::ALL {
            for shading in [Shading::Diffuse, Shading::Physical] {
                let t = std::time::Instant::now();
                let image = pictures.draw(&lit, ViewOptions { view, shading });
                println!("{name} {view:?} {shading:?} {:?}", t.elapsed());
                support::write(&image, view, &format!("/tmp/pics/{name}_{view:?}_{shading:?}.png"));
            }
        }
        use probelight_render::*;
        for (output, view) in [
            (RenderOutput::Full, GpuView::Full),
            (RenderOutput::Direct, GpuView::Direct),
            (RenderOutput::Indirect, GpuView::Indirect),
            (RenderOutput::Irradiance, GpuView::Irradiance),
        ] {
            let options = RenderOptions { output, ..RenderOptions::default() };
            let image =
                render(View::of(&lit.runtime), &lit.camera, &options, &probelight_trace::Silent).unwrap();
            support::write(&image, view, &format!("/tmp/pics/{name}_{view:?}_CPU.png"));
        }
    }
}
