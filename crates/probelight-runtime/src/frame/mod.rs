//! What a frame is asked for, and what it computes: the same on both backends.
//!
//! ```text
//!  FrameInput (who looks, what moves, what it may cost) ─┐
//!  LodSettings (levels by distance and direction) ───────┼─► FramePlan: an extent for each cluster and probe
//!  BakedScene ───────────────────────────────────────────┘
//! ```
//!
//! What is stored is ordered so that less of it is a prefix ([`BakedScene`](probelight_asset::BakedScene)). Kernels know
//! two numbers of everything: how many are stored, by which they find their way, and how many this frame computes.
//! What lies beyond keeps the value that it had.

mod box_tree;
mod bytes;
mod input;
mod lod;
mod plan;
mod planner;
mod plans;
mod presets;
mod relight_table;
mod sight;
mod stage;
mod zones;

pub use bytes::stage_bytes;
#[cfg(feature = "gpu")]
pub(crate) use bytes::{Held, stage_bytes_with};
pub use input::{Budget, FrameInput, View};
pub use lod::{LodLevel, LodSettings};
pub(crate) use plan::ReceiverPlace;
#[cfg(feature = "cpu")]
pub(crate) use plan::leading;
pub use plan::{ClusterExtent, FramePlan, ProbeExtent};
pub use planner::Planner;
pub(crate) use plans::FramePlans;
pub use presets::LodPreset;
pub(crate) use relight_table::RelightTable;
#[cfg(feature = "gpu")]
pub(crate) use relight_table::first_weight;
pub use stage::{PerStage, Stage, StageTimings};
pub use zones::LodZones;
