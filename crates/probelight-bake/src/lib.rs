//! The bake: everything that is computed once for a static scene.
//!
//! One step a file, in this order:
//!
//! | step | file | result |
//! | --- | --- | --- |
//! | settings | `options` | defaults derived from the scene's scale |
//! | walls | `cut` | large triangles cut where walls stand on them, so that no chart runs under a wall |
//! | lit sides | `sides` | which sides of the triangles have light of their own |
//! | layout | `atlas`, `layout` | lightmap charts at the wanted density |
//! | receivers | `receivers` | texels with a sample point in open air; dilation |
//! | probes | `voxels`, `probes` | where radiance is measured |
//! | relight rays | `relight` | what each probe sees |
//! | clusters | `air_spaces`, `partition` | groups of receivers that share a matrix |
//! | transport | `gather`, `probe_choice`, `transport` | the matrix α of each group (\[SED\] eq. 3–4) |
//! | compression | `compress` | truncated, split, quantised (\[SED\] eq. 6) |
//! | file | `assemble` | the [`probelight_asset::BakedScene`] and its report |

mod air_spaces;
mod assemble;
mod atlas;
mod bake;
mod checkpoint;
mod compress;
mod cut;
mod error;
mod gather;
mod layout;
mod options;
mod partition;
mod point_grid;
mod probe_choice;
mod probes;
mod receivers;
mod relight;
mod sides;
mod surface_samples;
mod transport;
mod voxels;

pub use bake::bake;
pub use error::BakeError;
pub use options::{BakeOptions, DEFAULT_MAX_RECEIVERS};
