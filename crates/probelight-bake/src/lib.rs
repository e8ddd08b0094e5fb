//! The bake: everything that is computed once for a static scene.
//!
//! One step a file, in this order:
//!
//! | step | file | result |
//! | --- | --- | --- |
//! | wishes | `options` | what was asked for, completed by the scene's scale; settings once the steps have decided |
//! | open air | `air` | where light can be; which sides of the triangles have light of their own |
//! | ground | `ground` | the prepared scene, by the steps below |
//! | · walls | `ground/cut` | large triangles cut where walls stand on them, so that no chart runs under a wall |
//! | · layout | `ground/atlas`, `layout` | lightmap charts at the wanted density |
//! | · receivers | `ground/receivers`, `texel_points` | texels with sample points in open air; dilation |
//! | · probes | `ground/probes`, `relight` | where radiance is measured, and what is seen from there |
//! | · grid | `ground/grid` | where light in free space is kept, if that is asked for |
//! | · outlooks | `ground/outlooks`, `site` | which places and probes can exchange light at all |
//! | light | `light` | surfels and emitters, where the runtime evaluates light; what random plausible lightings make of them |
//! | clusters | `partition` | groups of sites that share a matrix |
//! | transport | `transport` | the matrix of each group (\[SED\] eq. 3–4) |
//! | compression | `compression` | truncated, split, packed (\[SED\] eq. 6) |
//! | file | `assemble` | the [`probelight_asset::BakedScene`] and its report |
//!
//! `ground` runs the steps up to the outlooks; what they made, its `Groundwork`, is all that later steps read.
//! `group_worker` runs transport and compression for each cluster, `bake` all of them; `checkpoint` keeps what is
//! finished. `steps` has what makes long steps stop when asked.

mod air;
mod assemble;
mod bake;
mod byte_budget;
mod checkpoint;
mod compression;
mod error;
mod ground;
mod group_worker;
mod light;
mod options;
mod partition;
#[cfg(test)]
mod small_scene;
mod steps;
mod surface_samples;
mod transport;

pub use bake::bake;
pub use checkpoint::discard_checkpoint;
pub use error::BakeError;
pub use options::{BakeOptions, DEFAULT_MAX_RECEIVERS, Preset, Quality, RELIGHT_RAY_BUDGET};
