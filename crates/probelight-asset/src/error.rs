//! Why a baked file was refused.

use std::path::PathBuf;

/// Why a baked file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// "read" or "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The bytes are not a baked file this version can use.
    #[error("{path} is not a usable baked file: {reason}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
}
