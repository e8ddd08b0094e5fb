//! The baked file of Probelight (`.plight`): what the bake hands to the runtime.
//!
//! [`BakedParts`] is the schema in memory, [`BakedScene`] the same after its promises were checked.
//! `BakedScene::write` and `BakedScene::read` move it to and from a versioned, sectioned, checksummed file;
//! `BakedScene::read_info` reads a summary only. [`BakedScene::write_to`], [`BakedScene::from_reader`] and
//! [`BakedInfo::from_reader`] do so with any stream.
//!
//! # Layout of the file
//!
//! ```text
//!   byte 0           64              64 + 48 n                                        file end
//!        ┌───────────┬─────────────────┬───┬──────────────┬───┬──────────────┬───┬─  ─┬─────────────┐
//!        │  header   │  section table  │ 0 │  section 0   │ 0 │  section 1   │ 0 │ …  │ section n-1 │
//!        └─────┬─────┴───────┬─────────┴───┴──────────────┴───┴──────────────┴───┴─  ─┴─────────────┘
//!              │             │             ▲ every section starts at a multiple of 64, zeros between
//!              │             └─ n × { name [u8; 16], required u32, bytes of an element u32,
//!              │                      offset u64, length u64, xxh3 u64 }
//!              └─ { magic [u8; 8], version u32, minor version u32, file length u64, n u32, zeros [u32; 5],
//!                   xxh3 of the table u64, xxh3 of the bytes before u64 }
//! ```
//!
//! Everything is little-endian. Sections are arrays as they lie in memory, so that a mapped file can be used
//! in place and a streamed one is read front to back; settings, report and the scene's small parts are JSON,
//! textures PNG. Sections are found by their names. A reader passes over those that it does not know, unless they are
//! required: then it refuses the file. `docs/file-format.md` lists the sections; `sections.rs` declares them.
//!
//! Every byte is covered by a checksum or has one allowed value, so damage anywhere is noticed. The header
//! states the file's length and sections follow each other without gaps, so no claimed length exceeds the
//! file; where the real length is unknown, memory is taken as bytes arrive. Only a PNG unpacks to more than its size,
//! within limits. Checksums are against accidents, not against forgers: content behind valid checksums is checked as
//! well ([`BakedScene::new`]).
//!
//! # Features
//!
//! | feature | on by default | what it brings |
//! | --- | --- | --- |
//! | `files` | yes | `BakedScene::read`, `BakedScene::write` and `write_atomically` |
//!
//! In browsers (`wasm32-unknown-unknown`) leave it away: [`BakedScene::from_bytes`] reads what was downloaded.

#[cfg(feature = "files")]
mod atomic_file;
mod baked_scene;
mod border_blends;
mod cluster;
mod description;
mod error;
#[cfg(feature = "files")]
mod file;
mod grid;
mod grid_basis;
mod info;
mod layout;
mod light;
mod lightmap_layout;
mod lit_mesh;
mod matrix_bytes;
pub mod packed;
mod read;
mod sections;
mod settings;
#[cfg(all(test, feature = "files"))]
mod tests;
mod textures;
mod validate;
mod write;

#[cfg(feature = "files")]
pub use atomic_file::write_atomically;
pub use baked_scene::{BakedParts, BakedScene, ERROR_STEPS, NONE};
pub use border_blends::BorderBlend;
pub use cluster::Cluster;
#[cfg(feature = "files")]
pub use error::AssetError;
pub use error::{DecodeError, InvalidParts};
pub use grid::{
    BLOCK_EDGE, CELL_PLANES, GridBlock, GridCell, GridLayout, GridVertex, MAX_GRID_LEVELS, VertexPlace,
    index_of, places_of,
};
pub use grid_basis::{CosineReading, GridBasis, GridBasisKind, GridLobe, MAX_GRID_ROWS};
pub use info::{BakedInfo, SectionInfo};
pub use layout::FORMAT_VERSION;
pub use light::{Emitter, LightSample, Probe, Surfel, SurfelGroup};
pub use lightmap_layout::{LightmapFace, LightmapLayout};
pub use lit_mesh::LitMesh;
pub use matrix_bytes::MatrixBytes;
pub use packed::GAIN_STEPS;
pub use settings::{BakeReport, BakeSettings, Method, Metric, Storage};
pub use validate::{MAX_RELIGHT_RAYS, MAX_SH_DEGREE};
