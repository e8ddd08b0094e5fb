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
        let lit = lit_scene(name);
        let mut pictures = GpuPictures::new(gpu, &lit);
        for view in GpuView::ALL {
            for shading in [Shading::Diffuse, Shading::Physical] {
                let image = pictures.draw(&lit, ViewOptions { view, shading });
                support::write(&image, view, &format!("/tmp/pics/{name}_{view:?}_{shading:?}.png"));
            }
        }
    }
}
