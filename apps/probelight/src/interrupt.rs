//! Ctrl-C: work is asked to stop, and stops between two steps without leaving half a file.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

static REQUESTED: AtomicBool = AtomicBool::new(false);
static ENDS_AT_ONCE: AtomicBool = AtomicBool::new(false);

/// Makes Ctrl-C (and a termination signal) ask for the end. A second one ends the program at once.
pub(crate) fn install() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) || ENDS_AT_ONCE.load(Ordering::Relaxed) {
            std::process::exit(crate::INTERRUPTED.into());
        }
    })
    .context("cannot listen for Ctrl-C")
}

/// From now on the first one does: nobody asks, and nothing is written that could be left half done.
pub(crate) fn end_at_once() {
    ENDS_AT_ONCE.store(true, Ordering::Relaxed);
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
