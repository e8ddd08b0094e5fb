//! `results measure`: bakes scenes and holds them against their reference points.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde_json::Value;

use crate::figures::{Bake, Errors, Figures, RandomLights, Scaling, SyntheticScene};
use crate::program::Program;
use crate::truth::{self, MeasuredScene, Set};
use crate::variants;

/// Flags of `measure`.
#[derive(Args)]
pub(crate) struct Flags {
    /// Figures to write; what is already there is not measured again
    #[arg(short, long, value_name = "FIGURES.json")]
    out: PathBuf,
    /// Folder with scenes; those that are absent are left out
    #[arg(long, value_name = "DIR")]
    scenes: PathBuf,
    /// Folder with setups/NAME.json and points/NAME.csv
    #[arg(long, value_name = "DIR")]
    truth: PathBuf,
    /// Folder for baked files
    #[arg(long, value_name = "DIR", default_value = "out/results")]
    bakes: PathBuf,
    /// The program to measure [default: this workspace's, built first]
    #[arg(long, value_name = "PROBELIGHT")]
    probelight: Option<PathBuf>,
    /// Also let a GPU compute the light
    #[arg(long)]
    gpu: bool,
    /// Also measure frames of synthetic scenes of 50,000 to 8 million receivers
    #[arg(long)]
    scaling: bool,
    /// Also bake the Cornell box with each setting changed: some thirty bakes
    #[arg(long, conflicts_with = "options")]
    variants: bool,
    /// Scenes to measure [default: all]
    #[arg(value_name = "SCENE")]
    only: Vec<String>,
    /// Options for all bakes
    #[arg(last = true, value_name = "BAKE_OPTION")]
    options: Vec<String>,
}

/// Frames of which the shortest counts.
const FRAMES: &str = "100";

/// The same of synthetic scenes, of which the largest take seconds where a GPU is simulated.
const SYNTHETIC_FRAMES: &str = "10";

/// A measurement under way.
struct Measurement<'a> {
    flags: &'a Flags,
    program: Program,
    figures: Figures,
}

/// Measures what is not yet measured.
pub(crate) fn run(flags: &Flags, root: &Path) -> anyhow::Result<()> {
    let scenes = truth::find(&flags.scenes, &flags.truth, &flags.only)?;
    let program = Program::new(flags.probelight.clone(), root)?;
    std::fs::create_dir_all(&flags.bakes)
        .with_context(|| format!("cannot create {}", flags.bakes.display()))?;
    let figures = if flags.out.exists() { Figures::read(&flags.out)? } else { Figures::default() };
    let mut measurement = Measurement { flags, program, figures: Figures { machine: machine(), ..figures } };
    for scene in &scenes {
        measurement.measure(scene, &flags.options)?;
        if flags.variants && scene.name == variants::VARIED_SCENE {
            for options in variants::all_options() {
                let options: Vec<String> = options.split_whitespace().map(String::from).collect();
                measurement.measure(scene, &options)?;
            }
        }
    }
    if flags.scaling {
        for backend in ["cpu", "gpu"] {
            measurement.measure_scaling(backend)?;
        }
    }
    Ok(())
}

impl Measurement<'_> {
    /// Measures one bake of a scene, and keeps what is finished.
    fn measure(&mut self, scene: &MeasuredScene, options: &[String]) -> anyhow::Result<()> {
        let name = [std::slice::from_ref(&scene.name), options].concat().join(" ");
        let file = self.flags.bakes.join(format!("{}.plight", name.replace([' ', '/'], "_")));
        let mut bake = match self.figures.bakes.get(&name) {
            Some(bake) if file.exists() => bake.clone(),
            Some(bake) if self.is_complete(bake, scene) => return Ok(()),
            _ => self.bake(scene, options, &file)?,
        };
        self.keep(&name, &bake)?;
        for set in scene.named_sets() {
            if !bake.sets.get(&set.name).is_some_and(|errors| self.has_all_backends(errors)) {
                let errors = self.errors(&file, set)?;
                bake.sets.insert(set.name.clone(), errors);
                self.keep(&name, &bake)?;
            }
        }
        if bake.random_lights.is_none() {
            let errors: anyhow::Result<Vec<Errors>> =
                scene.random_sets().map(|set| self.errors(&file, set)).collect();
            bake.random_lights = RandomLights::of(&errors?);
        }
        if let Some(set) = scene.frame_set().filter(|_| bake.moving_ms.is_none()) {
            bake.still_ms = Some(self.shortest_frame(&file, set, false)?);
            bake.moving_ms = Some(self.shortest_frame(&file, set, true)?);
        }
        self.keep(&name, &bake)
    }

    /// Whether there is nothing left to measure of a bake.
    fn is_complete(&self, bake: &Bake, scene: &MeasuredScene) -> bool {
        let has_set =
            |set: &Set| bake.sets.get(&set.name).is_some_and(|errors| self.has_all_backends(errors));
        scene.named_sets().all(has_set)
            && (bake.random_lights.is_some() || scene.random_sets().next().is_none())
            && (bake.moving_ms.is_some() || scene.frame_set().is_none())
    }

    fn has_all_backends(&self, errors: &Errors) -> bool {
        errors.gpu_relative_rmse.is_some() || !self.flags.gpu
    }

    fn keep(&mut self, name: &str, bake: &Bake) -> anyhow::Result<()> {
        self.figures.bakes.insert(name.to_owned(), bake.clone());
        self.figures.write(&self.flags.out)
    }

    fn bake(&self, scene: &MeasuredScene, options: &[String], file: &Path) -> anyhow::Result<Bake> {
        note(&format!("baking {} {}", scene.name, options.join(" ")))?;
        let (scene, file) = (shown(&scene.path), shown(file));
        let arguments = ["bake", &scene, "-o", &file].into_iter().chain(options.iter().map(String::as_str));
        let run = self.program.run(&arguments.collect::<Vec<_>>())?;
        let report = &run.report;
        let number = |pointer: &str| {
            report
                .pointer(pointer)
                .and_then(Value::as_f64)
                .with_context(|| format!("bake reports no {pointer}"))
        };
        Ok(Bake {
            format: number("/format_version")? as u64,
            receivers: Some(number("/receivers")? as u64),
            probes: Some(number("/probes")? as u64),
            bytes_per_receiver: number("/matrix_bytes_per_receiver")?,
            file_bytes: Some(number("/file_bytes")? as u64),
            compression_error: Some(number("/report/mean_cluster_error")?),
            seconds: Some(number("/seconds")?),
            peak_mib: run.peak_mib,
            ..Bake::default()
        })
    }

    /// The errors of a set, on the CPU and, if asked for, the GPU.
    fn errors(&self, file: &Path, set: &Set) -> anyhow::Result<Errors> {
        note(&format!("  {}", set.name))?;
        let mut errors = self.eval(file, set, "cpu")?;
        if self.flags.gpu {
            errors.gpu_relative_rmse = Some(self.eval(file, set, "gpu")?.relative_rmse);
        }
        Ok(errors)
    }

    fn eval(&self, file: &Path, set: &Set, backend: &str) -> anyhow::Result<Errors> {
        let [file, setup, points] = [file, &set.setup, &set.points].map(shown);
        let arguments = ["eval", &file, "--setup", &setup, "--points", &points, "--backend", backend];
        let run = self.program.run(&arguments)?;
        serde_json::from_value(run.report).with_context(|| format!("errors of {}", set.name))
    }

    fn shortest_frame(&self, file: &Path, set: &Set, lights_move: bool) -> anyhow::Result<f64> {
        let [file, setup] = [file, &set.setup].map(shown);
        let mut arguments = vec!["bench", &file, "--setup", &setup, "--backend", "cpu", "--frames", FRAMES];
        arguments.extend(lights_move.then_some("--moving-lights"));
        let run = self.program.run(&arguments)?;
        let shortest = run.report.pointer("/scenes/0/frame/shortest_ms").and_then(Value::as_f64);
        shortest.context("bench reports no frame")
    }

    fn measure_scaling(&mut self, backend: &str) -> anyhow::Result<()> {
        if self.figures.scaling.contains_key(backend) {
            return Ok(());
        }
        note(&format!("frames of synthetic scenes, {backend}"))?;
        let run =
            self.program.run(&["bench", "--scaling", "--backend", backend, "--frames", SYNTHETIC_FRAMES])?;
        let scaling = scaling_of(&run.report).context("bench reports other figures than are expected")?;
        self.figures.scaling.insert(backend.to_owned(), scaling);
        self.figures.write(&self.flags.out)
    }
}

/// What is kept of `bench --scaling --json`.
fn scaling_of(report: &Value) -> Option<Scaling> {
    let scene = |scene: &Value| {
        Some(SyntheticScene {
            receivers: scene["receivers"].as_u64()?,
            megabytes: scene["frame"]["bytes"].as_f64()? * 1e-6,
            shortest_ms: scene["frame"]["shortest_ms"].as_f64()?,
            of_copy: scene["frame"]["of_copy"].as_f64()?,
        })
    };
    Some(Scaling {
        device: report["device"].as_str()?.to_owned(),
        copy_gb_per_s: report["copy_gb_per_s"].as_f64()?,
        scenes: report["scenes"].as_array()?.iter().map(scene).collect::<Option<_>>()?,
    })
}

/// What measures: the processor and how many threads it runs.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let model = model.unwrap_or_else(|| std::env::consts::ARCH.into());
    format!("{threads} threads of {model}")
}

fn note(line: &str) -> anyhow::Result<()> {
    Ok(writeln!(std::io::stderr(), "{line}")?)
}

fn shown(path: impl AsRef<Path>) -> String {
    path.as_ref().display().to_string()
}
