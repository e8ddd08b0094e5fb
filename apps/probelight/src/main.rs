//! The program `probelight`: bake a scene once, then light it in any way and look at it.
//!
//! Each command is a file in `commands`: its raw flags (clap), the settings resolved from them, and what it
//! does. Everything ends in [`main`], the only place that prints an error and chooses the exit code.

mod animation;
mod backend;
mod bake_settings;
mod bench_report;
mod bundled;
mod cli;
mod commands;
mod console;
mod error_map;
mod export;
mod input;
mod interrupt;
mod lod_flag;
mod matrix_figures;
mod movers;
mod output;
mod planning_clock;
mod points;
mod sample_points;
mod stage_clock;
mod studio;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::cli::Cli;
use crate::console::Console;

/// Exit code of a program ended by Ctrl-C, by custom 128 + SIGINT.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    // Wrong usage and --help end here, with clap's own exit codes 2 and 0.
    let cli = Cli::parse();
    let console = Console::new(cli.global.quiet);
    match run(cli, &console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(_) if interrupt::is_requested() => {
            console.clear_progress();
            report("interrupted");
            ExitCode::from(INTERRUPTED)
        }
        Err(error) => {
            console.clear_progress();
            report(&format!("error: {}", sentence_of(&error)));
            ExitCode::FAILURE
        }
    }
}

fn run(cli: Cli, console: &Console) -> anyhow::Result<()> {
    interrupt::install()?;
    if let Some(threads) = cli.global.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get() as usize).build_global()?;
    }
    cli.command.unwrap_or_default().run(console)
}

/// Whether the reader of our standard output went away, as `head` does: no error of ours.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let mut causes = error.chain().filter_map(|cause| cause.downcast_ref::<std::io::Error>());
    causes.any(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}

/// The error and its causes in one line. Libraries' messages may already quote their cause; it is not said twice.
fn sentence_of(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |said, cause| {
        if said.is_empty() {
            cause
        } else if said.contains(&cause) {
            said
        } else {
            format!("{said}: {cause}")
        }
    })
}

/// Prints the last line of a failed run; if even that fails, the exit code still tells.
fn report(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_said_once() {
        let error = anyhow::anyhow!("disk full").context("cannot write x: disk full").context("bake failed");
        assert_eq!(sentence_of(&error), "bake failed: cannot write x: disk full");
    }
}
