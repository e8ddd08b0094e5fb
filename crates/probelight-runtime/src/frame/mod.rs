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

mod border_records;
mod box_tree;
mod bytes;
mod change_tables;
mod fill_tables;
mod governor;
mod grid_reach;
mod input;
mod lod;
mod plan;
mod planner;
mod plans;
mod presets;
mod relight_table;
mod sight;
mod similarity_search;
mod stage;
mod waiting;
mod workload;
mod zones;

#[cfg(any(feature = "cpu", test))]
pub(crate) use border_records::BORDER_SLOT;
pub(crate) use border_records::{BorderRecord, border_records};
pub use bytes::stage_bytes;
#[cfg(feature = "gpu")]
pub(crate) use bytes::{Held, stage_bytes_with};
#[cfg(any(feature = "cpu", test))]
pub(crate) use change_tables::ChangeTerm;
pub(crate) use change_tables::{BLOCK, ChangeTables, Lists};
#[cfg(any(feature = "cpu", test))]
pub(crate) use fill_tables::FillRecord;
pub(crate) use fill_tables::FillTables;
pub use governor::LodGovernor;
pub use input::{Budget, FrameInput, View};
pub use lod::{LodChanges, LodLevel, LodSettings};
pub(crate) use plan::ReceiverPlace;
#[cfg(feature = "cpu")]
pub(crate) use plan::leading;
pub(crate) use plan::matrix_bytes;
pub use plan::{ClusterExtent, FADE_STEPS, FramePlan, ProbeExtent};
pub use planner::Planner;
pub(crate) use planner::Thresholds;
pub(crate) use plans::FramePlans;
pub use presets::LodPreset;
pub(crate) use relight_table::RelightTable;
#[cfg(feature = "gpu")]
pub(crate) use relight_table::first_weight;
pub use similarity_search::SimilaritySearch;
pub use stage::{PerStage, Stage, StageTimings};
#[cfg(feature = "cpu")]
pub(crate) use waiting::{Admission, ProbeTurn, urgency};
#[cfg(test)]
pub(crate) use waiting::{NEXT_TO_NOTHING, URGENCY_STEP_BITS};
#[cfg(any(feature = "cpu", test))]
pub(crate) use waiting::{PROBES_A_TURN, PROBES_SHARE};
pub(crate) use waiting::{URGENCIES, Waiting};
pub use workload::Workload;
pub use zones::LodZones;
