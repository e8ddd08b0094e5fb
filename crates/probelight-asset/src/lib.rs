//! The baked file of Probelight (`.plight`): what the bake hands to the runtime.
//!
//! [`BakedScene`] is the schema in memory. [`write`](BakedScene::write) and
//! [`read`](BakedScene::read) move it to and from a versioned, sectioned, checksummed file.

mod baked_scene;
mod error;

pub use baked_scene::{
    BakeReport, BakeSettings, BakedScene, Cluster, LightmapFace, LightmapLayout, NONE, Probe, RelightPoint,
};
pub use error::AssetError;
