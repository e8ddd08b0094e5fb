//! Why the runtime refused its input.

use probelight_scene::SceneError;

/// Why a baked scene or a change to it was refused.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// The baked scene's geometry or materials are not usable.
    #[error("the baked scene's geometry is not usable: {0}")]
    Scene(#[from] SceneError),
    /// Parts of the baked scene do not fit together.
    #[error("the baked scene contradicts itself ({reason}); bake it again")]
    Inconsistent {
        /// What does not fit.
        reason: String,
    },
    /// A material index out of range.
    #[error("there is no material {material}: the scene has {count}, counted from 0")]
    UnknownMaterial {
        /// The index asked for.
        material: usize,
        /// Number of materials.
        count: usize,
    },
    /// A colour that is not finite or negative.
    #[error("{quantity} of material {material} must be finite and not negative in each channel")]
    InvalidColor {
        /// "base colour" or "emission".
        quantity: &'static str,
        /// The material.
        material: usize,
    },
}
