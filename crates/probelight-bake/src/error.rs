//! Why a bake failed.

use std::path::PathBuf;

/// Why a bake failed.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The caller asked to stop.
    #[error("the bake was interrupted")]
    Cancelled,
    /// An option is outside its range.
    #[error("{option} must be {expected}, not {got}")]
    Option {
        /// The option's name.
        option: &'static str,
        /// The allowed range, in words.
        expected: String,
        /// What was asked for.
        got: String,
    },
    /// No surface of the scene can have light of its own.
    #[error("there is nothing to light: {reason}")]
    NothingToLight {
        /// Why, and what to do.
        reason: String,
    },
    /// The surface could not be laid out in a lightmap.
    #[error("cannot lay out the lightmap: {reason}")]
    Atlas {
        /// What is wrong and what to do.
        reason: String,
    },
    /// What was baked is more than a file can hold.
    #[error(transparent)]
    Result(#[from] probelight_asset::InvalidParts),
    /// The file that remembers an unfinished bake could not be used.
    #[error("cannot {action} the unfinished bake {path}: {source}")]
    Checkpoint {
        /// "read", "write" or "remove".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// Where an unfinished bake would be kept there is a file of another kind.
    #[error(
        "{path} is in the way: an unfinished bake is kept there, but it is a file of another kind (move it, or write the bake somewhere else)"
    )]
    NotACheckpoint {
        /// The file.
        path: PathBuf,
    },
}
