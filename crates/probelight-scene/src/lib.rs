//! Validated input of Probelight: a scene's triangles and materials in world space, lights, cameras and
//! the setup files that describe them.
//!
//! Everything downstream may rely on what [`Scene`] promises: finite positions, indices in range, no
//! triangle without area, unit normals.
//!
//! | feature | on by default | what it brings |
//! | --- | --- | --- |
//! | `files` | yes | `Setup::load`; without it setups are parsed in memory |
//! | `gltf` | yes | `load_gltf` and `parse_gltf`, which also read the files that a scene names |
//!
//! In browsers (`wasm32-unknown-unknown`) take neither, or `gltf` for scenes that are one file and come as bytes.

#[cfg(feature = "gltf")]
mod animated_model;
mod camera;
mod camera_path;
mod content_hash;
mod error;
#[cfg(feature = "gltf")]
mod gltf_import;
#[cfg(feature = "gltf")]
mod implausible;
mod light;
mod material;
mod object;
mod scene;
mod setup;
mod source;
mod unusable;

#[cfg(feature = "gltf")]
pub use animated_model::AnimatedModel;
pub use camera::Camera;
pub use camera_path::CameraPath;
pub use error::{SceneError, Warning};
#[cfg(feature = "gltf")]
pub use gltf_import::{load_animated_gltf, load_gltf, parse_animated_gltf, parse_gltf};
pub use light::{Illumination, Light, Lighting, Sky, range_window};
pub use material::{AlphaMode, Material, Texture, TextureSlot};
pub use object::{Object, Placement};
pub use scene::{Bounds, Scene};
pub use setup::{Keyframe, LightMotion, LightTrack, MaterialColors, ObjectPath, Setup, sun_at};
pub use source::{SourceInstance, SourceTriangle, Sources};
pub use unusable::Unusable;
