//! Why the runtime refused its input.

use probelight_asset::AssetError;

/// Why a baked scene or a change to it was refused.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// The baked scene contradicts itself, see [`probelight_asset::BakedScene::validate`].
    #[error(transparent)]
    Baked(#[from] AssetError),
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
    /// A light that cannot be.
    #[error(
        "{what} of the lighting is impossible: light must be finite and not negative in each channel, positions \
         finite, directions of length 1"
    )]
    InvalidLighting {
        /// Which part of it.
        what: String,
    },
    /// Settings that are no levels of detail.
    #[error("levels of detail: {reason}")]
    InvalidLod {
        /// What must be.
        reason: &'static str,
    },
    /// A plan for another scene.
    #[error("the plan is one for another scene: make one for this scene")]
    ForeignPlan,
}
