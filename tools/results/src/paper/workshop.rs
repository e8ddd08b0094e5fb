//! The folder in which figures are made, and the program that makes them.
//!
//! What a run of the program yields is kept together with all that went in, so that the same figures are not made twice
//! and changed ones are.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use serde_json::{Value, json};

use crate::documents::write_whole;
use crate::measure::{note, shown};
use crate::program::Program;

/// Where figures are made.
pub(crate) struct Workshop {
    program: Program,
    /// Folders with `.glb` files.
    scenes: [PathBuf; 2],
    /// With `setups/NAME.json` and `points/NAME.csv`.
    truth: PathBuf,
    /// What is kept between runs.
    work: PathBuf,
    /// Finished pictures.
    images: PathBuf,
}

/// How a picture is rendered.
pub(crate) struct Shot<'a> {
    /// Unique among the pictures.
    pub(crate) name: String,
    /// A baked file.
    pub(crate) file: &'a Path,
    pub(crate) setup: &'a Path,
    /// Further flags of `render`.
    pub(crate) flags: &'a str,
}

impl Workshop {
    /// Makes the folders that are missing in `out`. Models that are not among the scenes are among the bundled `objects`.
    pub(crate) fn new(
        program: Program,
        [scenes, objects]: [&Path; 2],
        truth: &Path,
        out: &Path,
    ) -> anyhow::Result<Self> {
        let absolute = |path: &Path| {
            path.canonicalize().with_context(|| format!("cannot find the folder {}", path.display()))
        };
        let (scenes, truth) = ([absolute(scenes)?, absolute(objects)?], absolute(truth)?);
        let (work, images) = (out.join("work"), out.join("images/paper"));
        for folder in [&work, &images] {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
        }
        Ok(Self { program, scenes, truth, work: absolute(&work)?, images: absolute(&images)? })
    }

    /// The file of a scene or of an object.
    pub(crate) fn scene(&self, name: &str) -> anyhow::Result<PathBuf> {
        let [scene, bundled] = self.scenes.each_ref().map(|folder| folder.join(format!("{name}.glb")));
        if bundled.exists() { Ok(bundled) } else { existing(scene) }
    }

    /// Lights of the truth.
    pub(crate) fn setup(&self, name: &str) -> anyhow::Result<PathBuf> {
        existing(self.truth.join(format!("setups/{name}.json")))
    }

    /// Reference points of the truth.
    pub(crate) fn points(&self, name: &str) -> anyhow::Result<PathBuf> {
        existing(self.truth.join(format!("points/{name}.csv")))
    }

    /// Where a finished picture lies.
    pub(crate) fn image(&self, name: &str) -> PathBuf {
        self.images.join(name)
    }

    /// A file or folder among what is kept.
    pub(crate) fn kept(&self, name: &str) -> PathBuf {
        self.work.join(name)
    }

    /// Writes a file for the program to read.
    pub(crate) fn draft(&self, name: &str, text: &str) -> anyhow::Result<PathBuf> {
        let path = self.kept(name);
        write_whole(&path, text.as_bytes())?;
        Ok(path)
    }

    /// Bakes a scene and returns the file.
    pub(crate) fn bake(&self, scene: &str, options: &str) -> anyhow::Result<PathBuf> {
        let name = [scene, options].join(" ").trim().replace(' ', "_");
        let file = self.kept(&format!("{name}.plight"));
        let mut arguments = vec!["bake".into(), shown(&self.scene(scene)?), "-o".into(), shown(&file)];
        arguments.extend(options.split_whitespace().map(String::from));
        self.run(&format!("bake_{name}"), &arguments, Some(&file))?;
        Ok(file)
    }

    /// What `info` says of a baked file.
    pub(crate) fn info(&self, file: &Path) -> anyhow::Result<Value> {
        Ok(self.program.run(&["info", &shown(file)])?.report)
    }

    /// Renders a linear picture and returns its file.
    pub(crate) fn render(&self, shot: &Shot<'_>) -> anyhow::Result<PathBuf> {
        let picture = self.kept(&format!("{}.exr", shot.name));
        let mut arguments =
            ["render", &shown(shot.file), "--setup", &shown(shot.setup)].map(String::from).to_vec();
        arguments.extend(shot.flags.split_whitespace().map(String::from));
        arguments.extend(["-o".into(), shown(&picture)]);
        self.run(&format!("render_{}", shot.name), &arguments, Some(&picture))?;
        Ok(picture)
    }

    /// Runs a command that prints JSON, unless the same was run before and its `output` is still there.
    pub(crate) fn run(
        &self,
        name: &str,
        arguments: &[String],
        output: Option<&Path>,
    ) -> anyhow::Result<Value> {
        let (kept, inputs) = (self.kept(&format!("{name}.run")), self.inputs(arguments)?);
        let is_there = output.is_none_or(Path::exists);
        if let Some(report) = report_of(&kept, &inputs).filter(|_| is_there) {
            return Ok(report);
        }
        note(&format!("  {}", name.replace('_', " ")))?;
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let report = self.program.run(&arguments)?.report;
        write_whole(&kept, json!({ "inputs": inputs, "report": report }).to_string().as_bytes())?;
        Ok(report)
    }

    /// The arguments, each with what the file among those that are kept holds that it names.
    fn inputs(&self, arguments: &[String]) -> anyhow::Result<Vec<String>> {
        let with_content = |argument: &String| {
            let path = Path::new(argument);
            let is_kept = path.starts_with(&self.work) && path.exists();
            let content = match path.extension().and_then(|extension| extension.to_str()) {
                Some("json" | "csv") if is_kept => std::fs::read_to_string(path)?,
                // A bake's own output is no input: the other arguments say all.
                Some("plight") if is_kept && arguments.first().is_none_or(|command| command != "bake") => {
                    format!("{:?}", path.metadata()?.modified()?)
                }
                _ => String::new(),
            };
            Ok(argument.clone() + &content)
        };
        arguments.iter().map(with_content).collect()
    }
}

/// What a run with the same inputs reported.
fn report_of(kept: &Path, inputs: &[String]) -> Option<Value> {
    let mut kept: Value = serde_json::from_str(&std::fs::read_to_string(kept).ok()?).ok()?;
    (kept["inputs"] == json!(inputs)).then(|| kept["report"].take())
}

fn existing(path: PathBuf) -> anyhow::Result<PathBuf> {
    ensure!(path.exists(), "{} does not exist", path.display());
    Ok(path)
}

/// A number of a report.
pub(crate) fn number(report: &Value, pointer: &str) -> anyhow::Result<f64> {
    report
        .pointer(pointer)
        .and_then(Value::as_f64)
        .with_context(|| format!("the program reports no {pointer}"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A workshop whose program counts its runs in a file and writes its last argument.
    fn workshop(folder: &Path) -> Workshop {
        let program = folder.join("program.sh");
        let script = format!("#!/bin/sh\necho run >> {}/runs\n: > \"$4\"\necho '{{}}'\n", folder.display());
        std::fs::write(&program, script).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        std::fs::write(folder.join("room.glb"), "").unwrap();
        let program = Program::new(Some(program), folder).unwrap();
        Workshop::new(program, [folder, folder], folder, &folder.join("out")).unwrap()
    }

    #[test]
    fn what_was_made_of_the_same_is_not_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let workshop = workshop(folder.path());
        let runs = || std::fs::read_to_string(folder.path().join("runs")).unwrap().lines().count();
        let bake = || workshop.bake("room", "").unwrap();
        let (file, again) = (bake(), bake());
        assert_eq!((file == again, runs()), (true, 1));
        workshop.bake("room", "--grid 0").unwrap();
        assert_eq!(runs(), 2);
        std::fs::remove_file(&file).unwrap();
        bake();
        assert_eq!(runs(), 3);
        let look = |text: &str| {
            let setup = workshop.draft("setup.json", text).unwrap();
            workshop
                .run("look", &["eval", "x", "y", "/dev/null", &shown(&setup)].map(String::from), None)
                .unwrap();
        };
        ["{}", "{}", "{ }"].iter().for_each(|text| look(text));
        assert_eq!(runs(), 5);
    }

    #[test]
    fn what_is_missing_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let workshop = workshop(folder.path());
        let message = |error: anyhow::Error| format!("{error:#}");
        assert!(message(workshop.scene("hall").unwrap_err()).contains("hall.glb does not exist"));
        assert!(message(workshop.setup("hall_area").unwrap_err()).contains("hall_area.json"));
        assert!(message(number(&json!({ "a": "b" }), "/a").unwrap_err()).contains("reports no /a"));
    }
}
