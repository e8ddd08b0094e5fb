//! The stages of a frame on the CPU, in the order in which they run.
//!
//! Each stage owns the buffers it writes, so that a frame allocates nothing, and divides its work into parts
//! that do not depend on the number of threads, so that the result does not either.

mod blend_borders;
mod choose_work;
pub mod dilate_lightmap;
mod direct_light;
pub mod gather_receivers;
mod light_rays;
pub mod light_surfels;
mod lit_surfels;
mod padded_end;
mod patch_tree;
mod per_thread;
pub mod project_clusters;
pub mod relight_probes;
mod scatter;
mod share_flux;
mod stretches;
mod unpack;

pub(crate) use choose_work::ChooseWork;
pub use dilate_lightmap::Dilation;
pub use gather_receivers::ReceiverIrradiance;
pub use light_surfels::ScalarSignals;
pub use project_clusters::ClusterCoefficients;
pub use relight_probes::ProbeRadiance;

/// Values computed together: one AVX-512 register, two of AVX, four of NEON.
type Lanes = wide::f32x16;

/// Number of values in [`Lanes`].
const LANES: usize = 16;

/// The first [`LANES`] values of a slice.
#[inline(always)]
fn load(values: &[f32]) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&values[..LANES]);
    Lanes::new(lanes)
}
