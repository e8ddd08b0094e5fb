//! How long work tells its caller where it stands, and is told to stop.

/// Watches long work. Implementations must be cheap: `advance` is called from many threads.
pub trait Progress: Sync {
    /// A stage begins that consists of `total` steps.
    fn begin(&self, stage: &str, total: u64);

    /// `steps` more of the current stage are done.
    fn advance(&self, steps: u64);

    /// Whether the work should stop; it then returns early with its own error for that.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody watches.
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &str, _total: u64) {}

    fn advance(&self, _steps: u64) {}
}

/// The work was stopped because [`Progress::is_cancelled`] asked for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;
