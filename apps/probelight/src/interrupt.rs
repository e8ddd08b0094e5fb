//! Ctrl-C: work is asked to stop, and stops between two steps without leaving half a file.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Makes Ctrl-C (and a termination signal) ask for the end. A second one ends the program at once.
pub(crate) fn install() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(crate::INTERRUPTED.into());
        }
    })
    .context("cannot listen for Ctrl-C")
}

/// Whether the user asked for the end.
pub(crate) fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Fails if the user asked for the end; for places between two stages of work.
pub(crate) fn check() -> anyhow::Result<()> {
    anyhow::ensure!(!is_requested(), "interrupted");
    Ok(())
}
