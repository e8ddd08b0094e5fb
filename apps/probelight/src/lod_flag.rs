//! Levels of detail on the command line.

use std::path::Path;

use anyhow::Context;
use probelight_runtime::{LodPreset, LodSettings};

/// Levels of detail and what they are called.
#[derive(Clone, Debug)]
pub(crate) struct LodChoice {
    pub(crate) name: String,
    pub(crate) settings: LodSettings,
}

/// Parses `PRESET` or `FILE.json`, and `@SCALE` behind it, by which all distances are multiplied.
pub(crate) fn parse_lod(text: &str) -> anyhow::Result<LodChoice> {
    let (name, scale) = match text.rsplit_once('@') {
        Some((name, scale)) => (name, Some(scale)),
        None => (text, None),
    };
    let mut settings = match LodPreset::by_name(name) {
        Some(preset) => preset.settings(),
        None => read(name.as_ref())?,
    };
    if let Some(scale) = scale {
        let scale: f32 = scale
            .parse()
            .ok()
            .filter(|scale| *scale > 0.0)
            .context("expected a number above zero behind @")?;
        settings = settings.with_distances_scaled(scale);
    }
    settings.check()?;
    Ok(LodChoice { name: text.into(), settings })
}

fn read(path: &Path) -> anyhow::Result<LodSettings> {
    let names = LodPreset::ALL.map(LodPreset::name).join(", ");
    let text = std::fs::read_to_string(path).with_context(|| {
        format!("{} is neither one of {names} nor a file that can be read", path.display())
    })?;
    serde_json::from_str(&text).with_context(|| format!("{} holds no levels of detail", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_and_files_are_read_and_scaled() {
        assert_eq!(parse_lod("medium").unwrap().settings, LodPreset::Medium.settings());
        let near = parse_lod("published@0.5").unwrap();
        assert_eq!((near.name.as_str(), near.settings.levels[1].distance), ("published@0.5", 10.0));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("lod.json");
        std::fs::write(&file, serde_json::to_string(&LodPreset::Low.settings()).unwrap()).unwrap();
        assert_eq!(parse_lod(file.to_str().unwrap()).unwrap().settings, LodPreset::Low.settings());
    }

    #[test]
    fn what_is_neither_says_so() {
        let error = |text| format!("{:#}", parse_lod(text).unwrap_err());
        assert!(error("mediun").contains("medium"), "{}", error("mediun"));
        assert!(error("medium@zero").contains("number"));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("lod.json");
        std::fs::write(&file, r#"{"levels": []}"#).unwrap();
        assert!(error(file.to_str().unwrap()).contains("at least one level"));
    }
}
