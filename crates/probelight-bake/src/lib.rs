//! The bake: everything that is computed once for a static scene.
//!
//! One step a file, in this order:
//!
//! | step | file | result |
//! | --- | --- | --- |
//! | settings | `options`, `quality` | defaults derived from the scene's scale, and presets |
//! | walls | `cut` | large triangles cut where walls stand on them, so that no chart runs under a wall |
//! | lit sides | `sides` | which sides of the triangles have light of their own |
//! | layout | `atlas`, `layout` | lightmap charts at the wanted density |
//! | receivers | `receivers`, `texel_points` | texels with sample points in open air; dilation |
//! | probes | `voxels`, `probes` | where radiance is measured |
//! | relight rays | `relight` | what each probe sees |
//! | outlooks | `air_spaces` | which receivers and probes can exchange light at all |
//! | light | `surfels`, `emitters`, `scene_light` | where the runtime evaluates light |
//! | ensemble | `light_ensemble` | what random plausible lightings make of it |
//! | clusters | `partition` | groups of receivers that share a matrix |
//! | transport | `gather`, `patch_choice`, `probe_choice`, `transport` | the matrix of each group (\[SED\] eq. 3–4) |
//! | compression | `metric`, `compress`, `quantize` | truncated, split, packed (\[SED\] eq. 6) |
//! | file | `assemble` | the [`probelight_asset::BakedScene`] and its report |
//!
//! `group_worker` runs the last steps but one for each cluster, `bake` all of them.

mod air_spaces;
mod assemble;
mod atlas;
mod bake;
mod blur_balance;
mod checkpoint;
mod compress;
mod cut;
mod emitters;
mod error;
mod error_feedback;
mod gather;
mod group_worker;
mod layout;
mod light_ensemble;
mod metric;
mod options;
mod partition;
mod patch_choice;
mod point_grid;
mod probe_choice;
mod probes;
mod quality;
mod quantize;
mod receivers;
mod relight;
mod scene_light;
mod sides;
#[cfg(test)]
mod small_scene;
mod surface_samples;
mod surfels;
mod texel_points;
mod transport;
mod voxels;

pub use bake::bake;
pub use error::BakeError;
pub use options::{BakeOptions, DEFAULT_MAX_RECEIVERS, RELIGHT_RAY_BUDGET};
pub use quality::{Preset, Quality};
