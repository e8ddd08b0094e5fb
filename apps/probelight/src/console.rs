//! What the user sees: progress and notes on standard error, results on standard output.

use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use probelight_trace::Progress;
use serde::Serialize;

use crate::interrupt;

/// Standard error for people, standard output for results.
pub(crate) struct Console {
    quiet: bool,
    bar: ProgressBar,
}

impl Console {
    /// Progress is shown only to people: not with `quiet`, not when standard error is a file or a pipe.
    pub(crate) fn new(quiet: bool) -> Self {
        let is_shown = !quiet && std::io::stderr().is_terminal();
        let bar = if is_shown { ProgressBar::no_length() } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{msg:<28} {wide_bar} {percent:>3} %  {eta:>4} left");
        bar.set_style(style.expect("the template is valid"));
        Self { quiet, bar }
    }

    /// A line for people on standard error, unless they want quiet.
    pub(crate) fn note(&self, line: impl AsRef<str>) {
        if !self.quiet {
            // Nobody reads notes if standard error is closed.
            self.bar.suspend(|| _ = writeln!(std::io::stderr(), "{}", line.as_ref()));
        }
    }

    /// A note on something that the user may want to change.
    pub(crate) fn warn(&self, line: impl Display) {
        self.note(format!("warning: {line}"));
    }

    /// Takes the progress bar off the screen.
    pub(crate) fn clear_progress(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Console {
    fn begin(&self, stage: &str, total: u64) {
        self.bar.reset();
        self.bar.set_length(total);
        self.bar.set_message(stage.to_owned());
        self.bar.enable_steady_tick(Duration::from_millis(200));
    }

    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }

    fn is_cancelled(&self) -> bool {
        interrupt::is_requested()
    }
}

/// Prints a command's result on standard output.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn print(text: impl std::fmt::Display) -> anyhow::Result<()> {
    writeln!(std::io::stdout().lock(), "{text}")?;
    Ok(())
}

/// Prints a command's result as one JSON object on standard output.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(serde_json::to_string_pretty(value)?)
}
