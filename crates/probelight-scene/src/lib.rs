//! Validated input of Probelight: a scene's triangles and materials in world space, lights, cameras and
//! the setup files that describe them.
//!
//! Everything downstream may rely on what [`Scene`] promises: finite positions, indices in range, no
//! triangle without area, unit normals.

mod camera;
mod content_hash;
mod error;
mod gltf_import;
mod implausible;
mod light;
mod material;
mod scene;
mod setup;
mod source;
mod unusable;

pub use camera::Camera;
pub use error::{SceneError, Warning};
pub use gltf_import::{load_gltf, parse_gltf};
pub use light::{Illumination, Light, Lighting, Sky, range_window};
pub use material::{AlphaMode, Material, Texture, TextureSlot};
pub use scene::{Bounds, Scene};
pub use setup::Setup;
pub use source::{SourceInstance, SourceTriangle, Sources};
pub use unusable::Unusable;
