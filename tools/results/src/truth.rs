//! Scenes and what is known about them: a folder of scenes, and others with `setups/NAME.json` and `points/NAME.csv`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use serde_json::Value;

/// Part of the names of sets that are summed up, see `tools/random-lightings.py`.
const RANDOM: &str = "_random_";

/// A scene and its sets of reference points.
#[derive(Debug)]
pub(crate) struct MeasuredScene {
    /// Its file's name without extension.
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    /// By name; of those with one name, that of the last folder.
    pub(crate) sets: Vec<Set>,
}

/// What there is to measure.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// By name.
    pub(crate) scenes: Vec<MeasuredScene>,
    /// Files of scenes that have reference points but do not exist.
    pub(crate) absent: Vec<PathBuf>,
}

/// Light and reference points.
#[derive(Clone, Debug)]
pub(crate) struct Set {
    pub(crate) name: String,
    pub(crate) setup: PathBuf,
    pub(crate) points: PathBuf,
    /// Number of point, spot and directional lights.
    analytic_lights: usize,
}

impl MeasuredScene {
    /// The sets that count by themselves.
    pub(crate) fn named_sets(&self) -> impl Iterator<Item = &Set> {
        self.sets.iter().filter(|set| !set.is_random())
    }

    /// The sets of random lights.
    pub(crate) fn random_sets(&self) -> impl Iterator<Item = &Set> {
        self.sets.iter().filter(|set| set.is_random())
    }

    /// The light under which frames are measured: as few lights as there are, but one that can move.
    pub(crate) fn frame_set(&self) -> Option<&Set> {
        self.named_sets().filter(|set| set.analytic_lights > 0).min_by_key(|set| set.analytic_lights)
    }
}

impl Set {
    fn is_random(&self) -> bool {
        self.name.contains(RANDOM)
    }
}

/// The scenes in `scenes` for which `truth` has reference points, by name; those named `only`, or all.
pub(crate) fn find(scenes: &Path, truth: &[PathBuf], only: &[String]) -> anyhow::Result<Found> {
    let mut sets: BTreeMap<String, Vec<Set>> = BTreeMap::new();
    for folder in truth {
        add_sets(folder, &mut sets)?;
    }
    let shown = truth.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ");
    let names: Vec<String> = sets.keys().cloned().collect();
    if let Some(unknown) = only.iter().find(|name| !names.contains(name)) {
        bail!("{shown} has no reference points of {unknown}, only of {}", names.join(", "));
    }
    let mut found = Found::default();
    for name in names.into_iter().filter(|name| only.is_empty() || only.contains(name)) {
        let path = scenes.join(format!("{name}.glb"));
        ensure!(path.exists() || only.is_empty(), "{} does not exist", path.display());
        if path.exists() {
            let sets = sets.remove(&name).unwrap_or_default();
            found.scenes.push(MeasuredScene { name, path, sets });
        } else {
            found.absent.push(path);
        }
    }
    ensure!(!found.scenes.is_empty(), "{} has none of the scenes that {shown} knows", scenes.display());
    Ok(found)
}

/// Adds the sets of a folder, by scene.
fn add_sets(truth: &Path, sets: &mut BTreeMap<String, Vec<Set>>) -> anyhow::Result<()> {
    let folder = truth.join("setups");
    let entries = std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut setups: Vec<PathBuf> = entries.map(|e| Ok(e?.path())).collect::<std::io::Result<_>>()?;
    setups.sort();
    for setup in setups {
        let Some(name) = setup.file_stem().and_then(|stem| stem.to_str()).map(str::to_owned) else {
            continue;
        };
        let points = truth.join("points").join(format!("{name}.csv"));
        if points.exists() {
            let (scene, analytic_lights) = scene_and_lights(&setup)?;
            let sets = sets.entry(scene).or_default();
            sets.retain(|set| set.name != name);
            sets.push(Set { name, setup, points, analytic_lights });
            sets.sort_by(|a, b| a.name.cmp(&b.name));
        }
    }
    Ok(())
}

/// The scene that a setup is for, and the number of its analytic lights.
fn scene_and_lights(setup: &Path) -> anyhow::Result<(String, usize)> {
    let read = || -> anyhow::Result<(String, usize)> {
        let setup: Value = serde_json::from_str(&std::fs::read_to_string(setup)?)?;
        let scene = setup["scene"].as_str().context("it names no scene")?;
        let lights = setup["lights"].as_array().context("it has no lights")?;
        let analytic = lights.iter().filter(|light| light["type"] != "sky").count();
        Ok((scene.trim_end_matches(".glb").to_owned(), analytic))
    };
    read().with_context(|| format!("{} is no setup", setup.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Truth of two scenes, of which only `a` is there.
    fn folders() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for part in ["setups", "points"] {
            std::fs::create_dir(folder.path().join(part)).unwrap();
        }
        let lamp = r#"{"type": "point"}"#;
        for (name, scene, lights) in [
            ("a_sky", "a", r#"{"type": "sky"}"#.to_owned()),
            ("a_night", "a", format!("{lamp}, {lamp}")),
            ("a_lamp", "a", lamp.to_owned()),
            ("a_random_00", "a", lamp.to_owned()),
            ("b_sky", "b", String::new()),
        ] {
            let setup = format!(r#"{{"scene": "{scene}.glb", "lights": [{lights}]}}"#);
            std::fs::write(folder.path().join(format!("setups/{name}.json")), setup).unwrap();
            std::fs::write(folder.path().join(format!("points/{name}.csv")), "").unwrap();
        }
        std::fs::write(folder.path().join("setups/unmeasured.json"), "{}").unwrap();
        std::fs::write(folder.path().join("a.glb"), "").unwrap();
        folder
    }

    #[test]
    fn scenes_that_are_absent_are_left_out() {
        let folder = folders();
        let Found { scenes, absent } = find(folder.path(), &[folder.path().into()], &[]).unwrap();
        assert_eq!((scenes.len(), absent), (1, vec![folder.path().join("b.glb")]));
        let names: Vec<&str> = scenes[0].named_sets().map(|set| set.name.as_str()).collect();
        assert_eq!((scenes[0].name.as_str(), names), ("a", vec!["a_lamp", "a_night", "a_sky"]));
        assert_eq!(scenes[0].random_sets().count(), 1);
        assert_eq!(scenes[0].frame_set().unwrap().name, "a_lamp");
    }

    #[test]
    fn scenes_that_are_asked_for_must_be_there() {
        let folder = folders();
        let find = |name: &str| find(folder.path(), &[folder.path().into()], &[name.into()]);
        assert!(find("a").is_ok());
        assert!(format!("{:#}", find("b").unwrap_err()).contains("b.glb does not exist"));
        assert!(format!("{:#}", find("c").unwrap_err()).contains("only of a, b"));
    }

    #[test]
    fn sets_come_from_all_folders() {
        let (folder, other) = (folders(), folders());
        let set = |part: &str, name: &str| other.path().join(part).join(name);
        std::fs::rename(set("setups", "a_sky.json"), set("setups", "a_dusk.json")).unwrap();
        std::fs::rename(set("points", "a_sky.csv"), set("points", "a_dusk.csv")).unwrap();
        let names = |truth: &[PathBuf]| -> Vec<String> {
            let scenes = find(folder.path(), truth, &[]).unwrap().scenes;
            scenes[0].named_sets().map(|set| set.name.clone()).collect()
        };
        let both = [folder.path().to_owned(), other.path().to_owned()];
        assert_eq!(names(&both), ["a_dusk", "a_lamp", "a_night", "a_sky"]);
        assert_eq!(names(&both[1..]), ["a_dusk", "a_lamp", "a_night"]);
    }
}
