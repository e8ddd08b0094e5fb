//! Why a baked file was refused.

use std::path::{Path, PathBuf};

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

/// The parts of a baked scene contradict each other, see [`crate::BakedScene::new`].
#[derive(Debug, thiserror::Error)]
#[error("the baked scene cannot be used: {reason}")]
pub struct InvalidParts {
    /// What is wrong and where.
    pub reason: String,
}

/// What stops the decoding of a file whose path is the caller's business.
#[derive(Debug)]
pub(crate) enum DecodeError {
    /// The bytes could not be had.
    Io(std::io::Error),
    /// The bytes are wrong; says what is wrong and what to do.
    Format(String),
}

impl DecodeError {
    /// A [`DecodeError::Format`].
    pub(crate) fn format(reason: impl Into<String>) -> Self {
        Self::Format(reason.into())
    }

    /// Adds the path.
    pub(crate) fn at(self, path: &Path) -> AssetError {
        match self {
            Self::Io(source) => AssetError::Io { action: "read", path: path.into(), source },
            Self::Format(reason) => AssetError::Format { path: path.into(), reason },
        }
    }
}

impl From<std::io::Error> for DecodeError {
    fn from(source: std::io::Error) -> Self {
        Self::Io(source)
    }
}
