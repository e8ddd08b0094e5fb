//! Measures Probelight and keeps the documents' figures true.
//!
//! `measure` bakes scenes, holds them against reference points and times their frames; it writes one JSON file.
//! `write` puts such figures into `docs/results.json` and from there into the documents. `compare` shows two
//! measurements side by side. `paper` makes the published figures again. A test fails while the documents say anything else than `docs/results.json`.

mod compare;
mod documents;
mod figures;
mod lookup;
mod measure;
mod paper;
mod program;
mod tables;
mod truth;
mod variants;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::{Parser, Subcommand};

use crate::figures::Figures;

const EXAMPLES: &str = "\
Examples (after `cargo run --release -p results --`):
  measure -o out/after.json --scenes assets/scenes --truth TRUTH            every scene that is there
  measure -o out/after.json --scenes SCENES --truth TRUTH cornell --variants --gpu
  measure -o out/plain.json --scenes SCENES --truth TRUTH cornell -- --metric plain
  measure -o out/random.json --scenes SCENES --truth TRUTH --truth RANDOM   random lights, too
  compare docs/results.json out/after.json                                  before and after, as Markdown
  write --from out/after.json                                               new figures, and the documents with them
  write                                                                     the documents, after an edit
  paper -o out/paper --scenes SCENES --truth TRUTH                          the published figures, and their page
  paper -o out/paper --scenes SCENES --truth TRUTH 14 bases --publish       some of them, into docs/

TRUTH holds setups/NAME.json and points/NAME.csv: tables as `probelight reference --points` writes them.
Baked files are kept in the folder out/after/ beside out/after.json. An interrupted measurement goes on where it was, and
tries again what failed; to begin anew, or for another program, name another file.";

/// Measures Probelight and keeps the documents' figures true.
#[derive(Parser)]
#[command(after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake scenes, compare them with reference points, time their frames
    Measure(measure::Flags),
    /// Write docs/results.json into the documents
    Write {
        /// Take over these figures first
        #[arg(long, value_name = "FIGURES.json")]
        from: Option<PathBuf>,
    },
    /// Make the published figures again, with this project's scenes
    Paper(paper::Flags),
    /// Show two measurements side by side
    Compare {
        /// Figures to compare with
        before: PathBuf,
        /// Figures to compare
        after: PathBuf,
    },
}

fn main() -> ExitCode {
    let result = run(Cli::parse().command);
    if let Err(error) = &result {
        // If even that fails, the exit code still tells.
        let _ = writeln!(std::io::stderr(), "error: {error:#}");
    }
    if result.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run(command: Command) -> anyhow::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    match command {
        Command::Measure(flags) => measure::run(&flags, &root),
        Command::Paper(flags) => paper::run(&flags, &root),
        Command::Write { from } => write(&root, from.as_deref()),
        Command::Compare { before, after } => {
            let comparison = compare::comparison(&Figures::read(&before)?, &Figures::read(&after)?);
            Ok(write!(std::io::stdout(), "{comparison}")?)
        }
    }
}

/// Takes over figures and fills them in wherever documents quote them.
fn write(root: &Path, from: Option<&Path>) -> anyhow::Result<()> {
    let path = root.join("docs/results.json");
    let mut figures = Figures::read(&path)?;
    if let Some(from) = from {
        figures.adopt(Figures::read(from)?);
        figures.write(&path)?;
    }
    for document in documents::read_all(root, &figures)? {
        if document.is != document.wanted {
            std::fs::write(&document.path, &document.wanted)
                .with_context(|| format!("cannot write {}", document.path.display()))?;
            writeln!(std::io::stderr(), "wrote {}", document.path.display())?;
        }
    }
    Ok(())
}
