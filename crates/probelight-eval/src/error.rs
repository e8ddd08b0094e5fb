//! Why a comparison could not be made.

use std::path::PathBuf;

/// Why a comparison could not be made.
#[derive(Debug, thiserror::Error)]
pub enum EvalError {
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
    /// The file is not a table of reference points.
    #[error("{path}, line {line}: {reason}")]
    Points {
        /// The file.
        path: PathBuf,
        /// Where, counted from 1.
        line: usize,
        /// What is wrong and what to do.
        reason: String,
    },
    /// The two sides of a comparison do not belong together.
    #[error("cannot compare: {reason}")]
    Mismatch {
        /// What does not fit.
        reason: String,
    },
}

impl EvalError {
    /// An [`EvalError::Mismatch`].
    pub(crate) fn mismatch(reason: impl Into<String>) -> Self {
        Self::Mismatch { reason: reason.into() }
    }
}
