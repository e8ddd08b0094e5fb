//! Why a baked file was refused.

#[cfg(feature = "files")]
use std::path::{Path, PathBuf};

/// Why a baked file could not be read or written.
#[cfg(feature = "files")]
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

/// The parts of a baked scene contradict each other, see [`crate::BakedScene::new`].
#[derive(Debug, thiserror::Error)]
#[error("the baked scene cannot be used: {reason}")]
pub struct InvalidParts {
    /// What is wrong and where.
    pub reason: String,
}

/// Why bytes could not be read as a baked scene.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The bytes could not be had.
    #[error("cannot read the baked scene: {0}")]
    Io(#[from] std::io::Error),
    /// The bytes are not a baked file this version can use; says what is wrong and what to do.
    #[error("this is not a usable baked file: {0}")]
    Format(String),
}

impl DecodeError {
    /// A [`DecodeError::Format`].
    pub(crate) fn format(reason: impl Into<String>) -> Self {
        Self::Format(reason.into())
    }

    /// One section is wrong.
    pub(crate) fn section(name: &str, what: &str) -> Self {
        Self::Format(format!("its section '{name}' {what}"))
    }

    /// Adds the path.
    #[cfg(feature = "files")]
    pub(crate) fn at(self, path: &Path) -> AssetError {
        match self {
            Self::Io(source) => AssetError::Io { action: "read", path: path.into(), source },
            Self::Format(reason) => AssetError::Format { path: path.into(), reason },
        }
    }
}
