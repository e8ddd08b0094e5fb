//! The program `probelight`, run as a user runs it.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use serde_json::Value;

/// How often a running program's memory is looked at.
const POLL: Duration = Duration::from_millis(20);

/// A built program.
pub(crate) struct Program {
    path: PathBuf,
}

/// What a run printed and took.
pub(crate) struct Run {
    pub(crate) report: Value,
    /// Largest resident memory, MiB; `None` where the system does not tell.
    pub(crate) peak_mib: Option<f64>,
}

impl Program {
    /// The program at `path`, or else that of this workspace, which is built first.
    pub(crate) fn new(path: Option<PathBuf>, root: &Path) -> anyhow::Result<Self> {
        if let Some(path) = path {
            return Ok(Self { path });
        }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let build = ["build", "--release", "--quiet", "--package", "probelight"];
        let status =
            Command::new(cargo).args(build).current_dir(root).status().context("cannot run cargo")?;
        ensure!(status.success(), "the program could not be built");
        let here = std::env::current_exe().context("cannot find out where this program is")?;
        Ok(Self { path: here.with_file_name(format!("probelight{}", std::env::consts::EXE_SUFFIX)) })
    }

    /// Runs a command that prints one JSON object, or nothing, as `render --animate` does.
    pub(crate) fn run(&self, arguments: &[&str]) -> anyhow::Result<Run> {
        let shown = || format!("{} {}", self.path.display(), arguments.join(" "));
        let mut child = Command::new(&self.path)
            .args(arguments)
            .args(["--json", "--quiet"])
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot run {}", shown()))?;
        let (output, status, peak_mib) = watch(&mut child).with_context(shown)?;
        ensure!(status.success(), "{} failed ({status})", shown());
        let output = if output.trim().is_empty() { "null" } else { &output };
        let report = serde_json::from_str(output).with_context(|| format!("{} printed no JSON", shown()))?;
        Ok(Run { report, peak_mib })
    }
}

/// Waits for the end of a program; returns what it printed, how it ended, and its largest memory.
fn watch(child: &mut Child) -> anyhow::Result<(String, ExitStatus, Option<f64>)> {
    let Some(mut stdout) = child.stdout.take() else { bail!("it has no output") };
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        stdout.read_to_string(&mut text).map(|_| text)
    });
    let mut peak_mib = None;
    let status = loop {
        peak_mib = peak_memory(child.id()).or(peak_mib);
        if let Some(status) = child.try_wait()? {
            break status;
        }
        std::thread::sleep(POLL);
    };
    let Ok(text) = reader.join() else { bail!("its output could not be read") };
    Ok((text?, status, peak_mib))
}

/// The largest resident memory of a process so far, MiB, as Linux counts it.
fn peak_memory(process: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn run(script: &str) -> anyhow::Result<Run> {
        let shell = Program { path: "sh".into() };
        shell.run(&["-c", script])
    }

    #[test]
    fn reports_are_read() {
        assert_eq!(run("true").unwrap().report, Value::Null);
        let run = run("sleep 0.1; echo '{\"a\": 1}'").unwrap();
        assert_eq!(run.report["a"], 1);
        assert!(!cfg!(target_os = "linux") || run.peak_mib.is_some_and(|mib| mib > 0.1 && mib < 1000.0));
    }

    #[test]
    fn failures_are_said() {
        let message = |script| format!("{:#}", run(script).err().unwrap());
        assert!(message("exit 3").contains("failed"));
        assert!(message("echo text").contains("printed no JSON"));
        let missing = Program { path: "no-such-program".into() };
        assert!(format!("{:#}", missing.run(&[]).err().unwrap()).contains("cannot run no-such-program"));
    }
}
