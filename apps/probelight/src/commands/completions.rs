//! `probelight completions SHELL`

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::cli::Cli;
use crate::console;

const EXAMPLES: &str = "\
Examples:
  probelight completions bash > ~/.local/share/bash-completion/completions/probelight
  probelight completions zsh > ~/.zfunc/_probelight
  probelight completions fish > ~/.config/fish/completions/probelight.fish";

/// Flags of `completions`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub(crate) fn run(flags: &Flags) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(flags.shell, &mut Cli::command(), "probelight", &mut script);
    console::print(String::from_utf8(script)?.trim_end())
}
