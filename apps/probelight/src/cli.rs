//! The command line as a whole; each command's own flags are beside its code.

use std::num::NonZeroU16;

use clap::{Args, Parser, Subcommand};

#[cfg(feature = "window")]
use crate::commands::view;
use crate::commands::{
    bake, bench, completions, demo, eval, eval_lod, export, info, man, reference, render, web,
};
use crate::console::Console;

const TOUR: &str = "\
A first tour:
  probelight                                       bake a bundled scene, draw pictures into ./out
  probelight bake room.glb -o room.plight          precompute light transport, once per scene
  probelight render room.plight -o room.png        light it by the lights of its glTF file
  probelight render room.plight --setup night.json --camera door -o night.png
                                                   other lights, another camera: no new bake

`probelight help COMMAND` explains a command and shows examples.";

/// Real-time global illumination: bake a static scene once, then change its lights, sky, emission and colours
/// and see the indirect light follow.
#[derive(Parser)]
#[command(name = "probelight", version, after_help = TOUR, max_term_width = 100)]
pub(crate) struct Cli {
    /// Flags that every command has.
    #[command(flatten)]
    pub(crate) global: GlobalFlags,
    /// Without one: `demo`.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// Flags that every command has.
#[derive(Args)]
pub(crate) struct GlobalFlags {
    /// Print no progress and no notes; errors are still printed
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Worker threads [default: one per core]; results do not depend on it
    #[arg(long, global = true, value_name = "N")]
    pub(crate) threads: Option<NonZeroU16>,
}

/// What to do.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Bake a bundled scene, move its light, compare with a path tracer (this runs when no command is given)
    Demo(demo::Flags),
    /// Precompute a scene's light transport: glTF in, .plight out
    Bake(bake::Flags),
    /// Describe a baked file
    Info(info::Flags),
    /// Picture of a baked file, or of a scene, under given lights
    Render(render::Flags),
    /// Look at a scene in a window: move its lights and objects, bake it, compare it with the truth
    #[cfg(feature = "window")]
    View(view::Flags),
    /// Write a page for browsers that shows a baked scene and relights it
    Web(web::Flags),
    /// Write a baked scene for other programs: glTF, and its light as a lightmap
    Export(export::Flags),
    /// Path-traced truth: a picture, or irradiance at given points (slow)
    Reference(reference::Flags),
    /// Measure a baked file's error against reference points
    Eval(eval::Flags),
    /// Compare levels of detail with none: time, bytes, pictures
    EvalLod(eval_lod::Flags),
    /// Measure how fast the stages of a frame are, and how near to what the memory allows
    Bench(bench::Flags),
    /// Print a completion script for a shell
    Completions(completions::Flags),
    /// Write the manual pages into a folder
    Man(man::Flags),
}

impl Default for Command {
    fn default() -> Self {
        Self::Demo(demo::Flags::default())
    }
}

impl Command {
    /// Does it.
    pub(crate) fn run(self, console: &Console) -> anyhow::Result<()> {
        match self {
            Self::Demo(flags) => demo::run(&flags, console),
            Self::Bake(flags) => bake::run(flags, console),
            Self::Info(flags) => info::run(&flags),
            Self::Render(flags) => render::run(flags, console),
            #[cfg(feature = "window")]
            Self::View(flags) => view::run(&flags, console),
            Self::Web(flags) => web::run(&flags, console),
            Self::Reference(flags) => reference::run(flags, console),
            Self::Eval(flags) => eval::run(&flags, console),
            Self::Export(flags) => export::run(&flags, console),
            Self::EvalLod(flags) => eval_lod::run(&flags, console),
            Self::Bench(flags) => bench::run(&flags, console),
            Self::Completions(flags) => completions::run(&flags),
            Self::Man(flags) => man::run(&flags, console),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn texts_of_help_fit_a_hundred_columns() {
        let command = Cli::command();
        for command in command.get_subcommands().chain([&command]) {
            let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let longest = text.lines().max_by_key(|line| line.chars().count());
            assert!(longest.is_none_or(|line| line.chars().count() <= 98), "{longest:?}");
        }
    }
}
