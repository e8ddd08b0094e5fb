//! `results measure`: bakes scenes and holds them against their reference points.
//!
//! What is finished is kept after each step, so an interrupted measurement goes on where it was. A bake that fails is
//! reported and left out, so that a night's work does not end with the first of them.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::Args;
use serde_json::Value;

use crate::figures::{Bake, Errors, Figures, RandomLights, Scaling, SyntheticScene};
use crate::lookup::{grouped, percent};
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
    /// Folder with setups/NAME.json and points/NAME.csv; may be given several times
    #[arg(long, value_name = "DIR", required = true)]
    truth: Vec<PathBuf>,
    /// Folder for baked files [default: FIGURES without .json]
    #[arg(long, value_name = "DIR")]
    bakes: Option<PathBuf>,
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

/// Errors are told from those of an ideal lightmap.
const FLOOR: &[&str] = &["--floor"];

/// Frames of which the shortest counts.
const FRAMES: &str = "100";

/// The same of synthetic scenes, of which the largest take seconds where a GPU is simulated.
const SYNTHETIC_FRAMES: &str = "10";

/// A measurement under way.
struct Measurement<'a> {
    flags: &'a Flags,
    /// Folder for baked files.
    bakes: PathBuf,
    program: Program,
    figures: Figures,
}

/// A bake to measure.
struct Job<'a> {
    scene: &'a MeasuredScene,
    options: Vec<String>,
}

impl<'a> Job<'a> {
    /// The bakes that are asked for, in order.
    fn all(flags: &Flags, scenes: &'a [MeasuredScene]) -> Vec<Self> {
        let mut jobs = Vec::new();
        for scene in scenes {
            jobs.push(Self { scene, options: flags.options.clone() });
            if flags.variants && scene.name == variants::VARIED_SCENE {
                let options = |text: &str| text.split_whitespace().map(String::from).collect();
                let varied = variants::all_options().into_iter().filter(|text| !text.is_empty());
                jobs.extend(varied.map(|text| Self { scene, options: options(text) }));
            }
        }
        jobs
    }

    /// Its name among the figures' bakes.
    fn name(&self) -> String {
        [std::slice::from_ref(&self.scene.name), &self.options].concat().join(" ")
    }
}

/// Measures what is not yet measured.
pub(crate) fn run(flags: &Flags, root: &Path) -> anyhow::Result<()> {
    let found = truth::find(&flags.scenes, &flags.truth, &flags.only)?;
    for path in &found.absent {
        note(&format!("left out: {} does not exist", path.display()))?;
    }
    let program = Program::new(flags.probelight.clone(), root)?;
    let bakes = flags.bakes.clone().unwrap_or_else(|| flags.out.with_extension(""));
    ensure!(bakes != flags.out, "{} does not end with .json", flags.out.display());
    std::fs::create_dir_all(&bakes).with_context(|| format!("cannot create {}", bakes.display()))?;
    let figures = if flags.out.exists() { Figures::read(&flags.out)? } else { Figures::default() };
    let figures = Figures { machine: machine(), ..figures };
    figures.write(&flags.out)?;
    let mut measurement = Measurement { flags, bakes, program, figures };
    let failed = measurement.measure_all(&Job::all(flags, &found.scenes))?;
    ensure!(
        failed.is_empty(),
        "these were not measured: {}; the same command tries them again",
        failed.join(", ")
    );
    note(&format!("all is in {}", flags.out.display()))
}

impl Measurement<'_> {
    /// Returns what failed, by name.
    fn measure_all(&mut self, jobs: &[Job<'_>]) -> anyhow::Result<Vec<String>> {
        let mut failed = Vec::new();
        let mut keep_failure = |name: String, result: anyhow::Result<()>| {
            let Err(error) = result else { return Ok(()) };
            let said = note(&format!("warning: {name} is left out: {error:#}"));
            failed.push(name);
            said
        };
        for (number, job) in jobs.iter().enumerate() {
            note(&format!("[{} of {}] {}", number + 1, jobs.len(), job.name()))?;
            keep_failure(job.name(), self.measure(job))?;
        }
        for backend in ["cpu", "gpu"].into_iter().filter(|_| self.flags.scaling) {
            keep_failure(format!("frames of synthetic scenes, {backend}"), self.measure_scaling(backend))?;
        }
        Ok(failed)
    }

    /// Measures one bake of a scene, and keeps what is finished.
    fn measure(&mut self, job: &Job<'_>) -> anyhow::Result<()> {
        let (scene, name) = (job.scene, job.name());
        let file = self.bakes.join(format!("{}.plight", name.replace([' ', '/'], "_")));
        let mut bake = match self.figures.bakes.get(&name) {
            Some(bake) if self.is_complete(bake, scene) => return note("  measured before"),
            Some(bake) if file.exists() => bake.clone(),
            _ => self.bake(job, &file)?,
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
                scene.random_sets().map(|set| self.eval(&file, set, "cpu", &[])).collect();
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

    fn bake(&self, job: &Job<'_>, file: &Path) -> anyhow::Result<Bake> {
        let (scene, file) = (shown(&job.scene.path), shown(file));
        let arguments =
            ["bake", &scene, "-o", &file].into_iter().chain(job.options.iter().map(String::as_str));
        let run = self.program.run(&arguments.collect::<Vec<_>>())?;
        let report = &run.report;
        let number = |pointer: &str| {
            report
                .pointer(pointer)
                .and_then(Value::as_f64)
                .with_context(|| format!("bake reports no {pointer}"))
        };
        let (receivers, bytes, seconds) =
            (number("/receivers")? as u64, number("/matrix_bytes_per_receiver")?, number("/seconds")?);
        note(&format!("  baked in {seconds:.0} s: {} receivers of {bytes:.1} bytes", grouped(receivers)))?;
        Ok(Bake {
            format: number("/format_version")? as u64,
            receivers: Some(receivers),
            probes: Some(number("/probes")? as u64),
            bytes_per_receiver: bytes,
            file_bytes: Some(number("/file_bytes")? as u64),
            compression_error: Some(number("/report/mean_cluster_error")?),
            seconds: Some(seconds),
            peak_mib: run.peak_mib,
            ..Bake::default()
        })
    }

    /// The errors of a set, on the CPU and, if asked for, the GPU.
    fn errors(&self, file: &Path, set: &Set) -> anyhow::Result<Errors> {
        let mut errors = self.eval(file, set, "cpu", FLOOR)?;
        note(&format!("  {}: {}", set.name, percent(errors.relative_rmse)))?;
        if self.flags.gpu {
            errors.gpu_relative_rmse = Some(self.eval(file, set, "gpu", &[])?.relative_rmse);
        }
        Ok(errors)
    }

    fn eval(&self, file: &Path, set: &Set, backend: &str, more: &[&str]) -> anyhow::Result<Errors> {
        let [file, setup, points] = [file, &set.setup, &set.points].map(shown);
        let arguments = ["eval", &file, "--setup", &setup, "--points", &points, "--backend", backend];
        let run = self.program.run(&[&arguments, more].concat())?;
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
pub(crate) fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let model = model.unwrap_or_else(|| std::env::consts::ARCH.into());
    format!("{threads} threads of {model}")
}

/// Says what goes on.
pub(crate) fn note(line: &str) -> anyhow::Result<()> {
    Ok(writeln!(std::io::stderr(), "{line}")?)
}

/// A path as an argument.
pub(crate) fn shown(path: impl AsRef<Path>) -> String {
    path.as_ref().display().to_string()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Scenes of these names, a lamp in each.
    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for part in ["setups", "points"] {
            std::fs::create_dir(folder.path().join(part)).unwrap();
        }
        for name in names {
            let setup = format!(r#"{{"scene": "{name}.glb", "lights": [{{"type": "point"}}]}}"#);
            std::fs::write(folder.path().join(format!("setups/{name}_lamp.json")), setup).unwrap();
            std::fs::write(folder.path().join(format!("points/{name}_lamp.csv")), "").unwrap();
            std::fs::write(folder.path().join(format!("{name}.glb")), "").unwrap();
        }
        folder
    }

    fn flags(folder: &Path) -> Flags {
        let testdata = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata");
        Flags {
            out: folder.join("figures.json"),
            scenes: folder.into(),
            truth: vec![folder.into()],
            bakes: None,
            probelight: Some(testdata.join("probelight.sh")),
            gpu: false,
            scaling: false,
            variants: false,
            only: Vec::new(),
            options: Vec::new(),
        }
    }

    fn measured(flags: &Flags) -> Figures {
        Figures::read(&flags.out).unwrap()
    }

    #[test]
    fn all_that_is_asked_for_is_measured() {
        let folder = folder(&["cornell", "hall"]);
        let flags = Flags { variants: true, ..flags(folder.path()) };
        run(&flags, folder.path()).unwrap();
        let bakes = measured(&flags).bakes;
        assert_eq!(bakes.len(), 1 + variants::all_options().len());
        let hall = &bakes["hall"];
        assert_eq!((hall.receivers, hall.still_ms, hall.moving_ms), (Some(1000), Some(1.0), Some(2.0)));
        assert_eq!(hall.sets["hall_lamp"].relative_rmse, 0.1);
        assert!(bakes.contains_key("cornell --method paper"));
    }

    #[test]
    fn what_fails_is_named_and_the_rest_is_measured() {
        let folder = folder(&["broken", "hall"]);
        let flags = flags(folder.path());
        let error = format!("{:#}", run(&flags, folder.path()).unwrap_err());
        assert!(error.contains("not measured: broken;") && !error.contains("hall"), "{error}");
        assert_eq!(measured(&flags).bakes.into_keys().collect::<Vec<_>>(), ["hall"]);
    }

    #[test]
    fn only_what_is_missing_is_measured_again() {
        let folder = folder(&["cornell", "hall"]);
        let flags = flags(folder.path());
        run(&flags, folder.path()).unwrap();
        let mut figures = measured(&flags);
        for bake in figures.bakes.values_mut() {
            bake.bytes_per_receiver = 7.0;
            bake.sets.clear();
        }
        figures.write(&flags.out).unwrap();
        std::fs::remove_file(folder.path().join("figures/hall.plight")).unwrap();
        run(&flags, folder.path()).unwrap();
        let bakes = measured(&flags).bakes;
        assert_eq!((bakes["cornell"].bytes_per_receiver, bakes["hall"].bytes_per_receiver), (7.0, 50.0));
        assert!(bakes.values().all(|bake| bake.sets.len() == 1));
    }
}
