//! `probelight man DIR`

use std::path::PathBuf;

use clap::{Args, CommandFactory};

use crate::cli::Cli;
use crate::console::Console;
use crate::output;

const EXAMPLES: &str = "\
Examples:
  probelight man ~/.local/share/man/man1       then: man probelight, man probelight-bake";

/// Flags of `man`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// Folder for the pages; created if missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Writes one page per command.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    output::create_folder(&flags.folder)?;
    clap_mangen::generate_to(Cli::command().disable_help_subcommand(true), &flags.folder)?;
    console.note(format!("wrote the manual pages to {}", flags.folder.display()));
    Ok(())
}
