//! The baked file of Probelight (`.plight`): what the bake hands to the runtime.
//!
//! [`BakedScene`] is the schema in memory. [`BakedScene::write`] and [`BakedScene::read`] move it to and
//! from a versioned, sectioned, checksummed file; [`BakedScene::read_info`] reads a summary only.
//!
//! # Layout of the file
//!
//! ```text
//!   byte 0           64                992                                          file end
//!        ┌───────────┬─────────────────┬──────────────┬───┬──────────────┬───┬─  ─┬─────────────┐
//!        │  header   │  section table  │  section 0   │ 0 │  section 1   │ 0 │ …  │ section 28  │
//!        └─────┬─────┴───────┬─────────┴──────────────┴───┴──────────────┴───┴─  ─┴─────────────┘
//!              │             │         ▲ every section starts at a multiple of 64, zeros between
//!              │             └─ 29 × { name [u8; 8], offset u64, length u64, xxh3 u64 }
//!              └─ { magic [u8; 8], version u32, sections u32, file length u64, xxh3 of the table u64,
//!                   zeros [u8; 24], xxh3 of the bytes before u64 }
//! ```
//!
//! Everything is little-endian. Sections are arrays as they lie in memory, so that a mapped file can be used
//! in place and a streamed one is read front to back; settings, report and the scene's small parts are JSON,
//! textures PNG. The order is the order of use: a summary needs the first section, a renderer without
//! indirect light the first ten. `docs/file-format.md` lists the sections.
//!
//! Every byte is covered by a checksum or has one allowed value, so damage anywhere is noticed. The header
//! states the file's length and sections follow each other without gaps, so no claimed length exceeds the
//! file; only a PNG unpacks to more than its size, and by no more than deflate can. Checksums are against
//! accidents, not against forgers: content behind valid checksums is checked as well
//! ([`BakedScene::validate`]).

mod atomic_file;
mod baked_scene;
mod border_blends;
mod cluster_record;
mod description;
mod error;
mod info;
mod layout;
pub mod packed;
mod read;
#[cfg(test)]
mod tests;
mod textures;
mod validate;
mod write;

pub use atomic_file::write_atomically;
pub use baked_scene::{
    BakeReport, BakeSettings, BakedScene, Cluster, ERROR_STEPS, Emitter, LightSample, LightmapFace,
    LightmapLayout, Method, Metric, NONE, Probe, Storage, Surfel, SurfelGroup,
};
pub use border_blends::BorderBlend;
pub use error::AssetError;
pub use info::{BakedInfo, SectionInfo};
pub use packed::GAIN_STEPS;
