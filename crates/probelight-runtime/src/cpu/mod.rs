//! The stages of a frame on the CPU, in the order in which they run.
//!
//! Each stage owns the buffers it writes, so that a frame allocates nothing, and divides its work into parts
//! that do not depend on the number of threads, so that the result does not either.

mod clusters_in_parallel;
pub mod dilate_lightmap;
pub mod gather_receivers;
mod half_float;
pub mod light_relight_points;
pub mod project_clusters;
pub mod relight_probes;
mod texel_copies;

pub use dilate_lightmap::Dilation;
pub use gather_receivers::ReceiverIrradiance;
pub use light_relight_points::{RelightRadiance, SurfaceColors};
pub use project_clusters::ClusterCoefficients;
pub use relight_probes::ProbeRadiance;

/// Values computed together, so that the compiler fills vector registers with them: one AVX-512 register,
/// two of AVX, four of NEON.
const LANES: usize = 16;

/// `a·b + c`, in one operation where the target has it (elsewhere the fused form would be a library call).
#[inline(always)]
fn multiply_add(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}
