//! `results paper`: makes the figures of \[SED\] again, with this project's program, scenes and reference points.
//!
//! | module | makes |
//! | --- | --- |
//! | `workshop` | the folder with what is kept, and runs of the program |
//! | `setups`, `sheets`, `strokes`, `chart` | what the figures share: setup files, contact sheets, arrows, charts |
//! | `light_vectors` | figure 4 |
//! | `movers` | figures 11 and 12 |
//! | `surfaces` | figure 13 |
//! | `density` | figure 14 and the table of bases |
//! | `levels` | figures 3, 15 and 16 |
//! | `speed` | figures 17 and 18 |
//! | `page` | the page, with what was measured filled in |

mod chart;
mod density;
mod levels;
mod light_vectors;
mod movers;
mod page;
mod setups;
mod sheets;
mod speed;
mod strokes;
mod surfaces;
mod workshop;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::ensure;
use clap::{Args, ValueEnum};

use crate::measure::{machine, note};
use crate::program::Program;
use workshop::Workshop;

/// Flags of `paper`.
#[derive(Args)]
pub(crate) struct Flags {
    /// Folder for the page and its pictures; what is already there is not made again
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Folder with scenes: cornell, cornell_empty, rooms, atrium, water_bottle, fox
    #[arg(long, value_name = "DIR")]
    scenes: PathBuf,
    /// Folder with setups/NAME.json and points/NAME.csv
    #[arg(long, value_name = "DIR")]
    truth: PathBuf,
    /// The program to use [default: this workspace's, built first]
    #[arg(long, value_name = "PROBELIGHT")]
    probelight: Option<PathBuf>,
    /// Also put the page and its pictures into docs/
    #[arg(long)]
    publish: bool,
    /// Figures to make [default: all]
    #[arg(value_name = "FIGURE")]
    only: Vec<Figure>,
}

/// A figure of the paper, or what belongs to one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// Degrees of spherical harmonics
    #[value(name = "3")]
    Degrees,
    /// Directional irradiance around a point, and its light vector
    #[value(name = "4")]
    LightVectors,
    /// Colour bleeding on an object
    #[value(name = "11")]
    Bleeding,
    /// Shadow of a character that moves
    #[value(name = "12")]
    Shadow,
    /// Normal maps and gloss on the scene itself
    #[value(name = "13")]
    Surfaces,
    /// Density of the grid
    #[value(name = "14")]
    Density,
    /// Table of bases, lobes and spacings of the grid
    #[value(name = "bases")]
    Bases,
    /// Pictures with and without levels of detail
    #[value(name = "15")]
    Levels,
    /// Drawing distance
    #[value(name = "16")]
    Distances,
    /// Speed against similarity
    #[value(name = "17")]
    Speed,
    /// Number of receivers
    #[value(name = "18")]
    Receivers,
}

/// What the page says in the places of its marks, by name.
type Values = BTreeMap<String, String>;

impl Figure {
    /// As the command line has it.
    fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
    }

    fn make(self, workshop: &Workshop) -> anyhow::Result<Values> {
        match self {
            Self::Degrees => levels::degrees(workshop),
            Self::LightVectors => light_vectors::draw(workshop),
            Self::Bleeding => movers::bleeding(workshop),
            Self::Shadow => movers::shadow(workshop),
            Self::Surfaces => surfaces::draw(workshop),
            Self::Density => density::pictures(workshop),
            Self::Bases => density::bases(workshop),
            Self::Levels => levels::with_and_without(workshop),
            Self::Distances => levels::distances(workshop),
            Self::Speed => speed::against_similarity(workshop),
            Self::Receivers => speed::against_receivers(workshop),
        }
    }
}

/// Makes the figures that are asked for, and the page. One that fails does not stop the others.
pub(crate) fn run(flags: &Flags, root: &Path) -> anyhow::Result<()> {
    let program = Program::new(flags.probelight.clone(), root)?;
    let objects = root.join("assets/objects");
    let workshop = Workshop::new(program, [&flags.scenes, &objects], &flags.truth, &flags.out)?;
    let figures = if flags.only.is_empty() { Figure::value_variants() } else { &flags.only };
    let mut failed = Vec::new();
    for figure in figures {
        note(&format!("figure {}", figure.name()))?;
        let made = figure.make(&workshop).and_then(|mut values| {
            values.insert("machine".into(), machine());
            page::fill(&root.join("docs"), &flags.out, values)
        });
        if let Err(error) = made {
            note(&format!("warning: figure {} is left out: {error:#}", figure.name()))?;
            failed.push(figure.name());
        }
    }
    ensure!(
        failed.is_empty(),
        "these figures were not made: {}; the same command tries them again",
        failed.join(", ")
    );
    if flags.publish {
        page::publish(&flags.out, &root.join("docs"))?;
    }
    note(&format!("all is in {}", flags.out.display()))
}
