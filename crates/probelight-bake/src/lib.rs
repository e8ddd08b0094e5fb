//! The bake: everything that is computed once for a static scene.
//!
//! One step a file, in this order:
//!
//! | step | file | result |
//! | --- | --- | --- |
//! | wishes | `options` | what was asked for, completed by the scene's scale; settings once the steps have decided |
//! | walls | `cut` | large triangles cut where walls stand on them, so that no chart runs under a wall |
//! | open air | `air` | where light can be; which sides of the triangles have light of their own |
//! | layout | `atlas`, `layout` | lightmap charts at the wanted density |
//! | receivers | `receivers`, `texel_points` | texels with sample points in open air; dilation |
//! | probes | `voxels`, `probes` | where radiance is measured |
//! | relight rays | `relight` | what each probe sees |
//! | outlooks | `air_spaces` | which receivers and probes can exchange light at all |
//! | light | `surfels`, `emitters`, `scene_light` | where the runtime evaluates light |
//! | ensemble | `light_ensemble` | what random plausible lightings make of it |
//! | clusters | `partition` | groups of receivers that share a matrix |
//! | transport | `gather`, `view`, `patch_choice`, `probe_choice`, `transport` | the matrix of each group (\[SED\] eq. 3–4) |
//! | compression | `metric`, `compress`, `quantize` | truncated, split, packed (\[SED\] eq. 6) |
//! | file | `assemble` | the [`probelight_asset::BakedScene`] and its report |
//!
//! `groundwork` runs the steps up to the outlooks; what they made, its `Groundwork`, is all that later steps
//! read. `steps` has what makes them stop when asked. `group_worker` runs transport and compression for each cluster, `bake` all of them.

mod air;
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
mod groundwork;
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
mod quantize;
mod receivers;
mod relight;
mod scene_light;
mod site;
#[cfg(test)]
mod small_scene;
mod steps;
mod surface_samples;
mod surfels;
mod texel_points;
mod transport;
mod view;
mod voxels;

pub use bake::bake;
pub use error::BakeError;
pub use options::{BakeOptions, DEFAULT_MAX_RECEIVERS, Preset, Quality, RELIGHT_RAY_BUDGET};
