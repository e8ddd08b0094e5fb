//! Why the runtime refused its input.

use probelight_scene::Unusable;

/// Why a change to a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
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
    /// A light or sky that makes no sense.
    #[error(transparent)]
    Lighting(#[from] Unusable),
    /// An object that cannot be where it was put.
    #[error("an object cannot be placed so: {0}")]
    Object(#[source] Unusable),
    /// A handle of an object that is not in the scene any more, or is one of another scene.
    #[error("there is no such object in the scene: it was removed, or belongs to another")]
    UnknownObject,
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
