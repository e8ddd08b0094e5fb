//! A folder in which tests run the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

const SETUP: &str = r#"{ "version": 1, "name": "test", "scene": "cornell.glb", "use_emissive": false,
  "lights": [{"type": "point", "position": [2.78, 4.6, 2.8], "intensity": [12, 11, 9]}],
  "cameras": [{"name": "front", "position": [2.78, 2.73, -8], "target": [2.78, 2.73, 0], "up": [0, 1, 0],
               "vfov_deg": 39.3, "width": 48, "height": 32}] }"#;

/// Rows on the floor and on the left wall, and one in free space.
const POINTS: &str = "\
position_x,position_y,position_z,normal_x,normal_y,normal_z,kind
1.0,0,1.0,0,1,0,0
4.5,0,0.8,0,1,0,0
0.6,0,4.9,0,1,0,0
2.7,2.5,1.0,0,1,0,1
";

/// A folder with a setup and a table of points.
pub(crate) struct Workplace {
    pub(crate) folder: TempDir,
}

impl Workplace {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("setup.json"), SETUP).unwrap();
        fs::write(folder.path().join("points.csv"), POINTS).unwrap();
        fs::copy(bundled("cornell.glb"), folder.path().join("cornell.glb")).unwrap();
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the program in the folder; arguments are separated by spaces.
    pub(crate) fn run(&self, arguments: &str) -> Output {
        let arguments = arguments.split_whitespace();
        Command::new(env!("CARGO_BIN_EXE_probelight"))
            .args(arguments)
            .current_dir(&self.folder)
            .output()
            .unwrap()
    }

    /// Runs the program, which must succeed, and returns its standard output.
    pub(crate) fn succeed(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    /// As [`Self::succeed`] with `--json`: standard output must be one JSON object.
    pub(crate) fn json(&self, arguments: &str) -> Value {
        let value: Value = serde_json::from_str(&self.succeed(&format!("{arguments} --json"))).unwrap();
        assert!(value.is_object());
        value
    }

    pub(crate) fn bake(&self) {
        self.succeed(
            "bake cornell.glb -o cornell.plight --receivers 600 --rays 64 --relight-rays 64 --grid 300",
        );
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

pub(crate) fn bundled(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name)
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}
