//! The page: the text of `docs/paper-figures.md` with the figures that were measured.

use std::path::Path;

use anyhow::Context;

use super::Values;
use crate::documents::{filled_by, write_whole};

const PAGE: &str = "paper-figures.md";

/// What was measured so far, in the folder of the figures.
const VALUES: &str = "work/values.json";

/// Writes the documents' page into `out`, with the values and those of earlier runs filled in.
pub(crate) fn fill(docs: &Path, out: &Path, values: Values) -> anyhow::Result<()> {
    let (kept, page) = (out.join(VALUES), docs.join(PAGE));
    let mut all: Values = match std::fs::read_to_string(&kept) {
        Ok(text) => serde_json::from_str(&text).with_context(|| format!("{} is broken", kept.display()))?,
        Err(_) => Values::new(),
    };
    all.extend(values);
    write_whole(&kept, serde_json::to_string_pretty(&all)?.as_bytes())?;
    let text = std::fs::read_to_string(&page).with_context(|| format!("cannot read {}", page.display()))?;
    write_whole(&out.join(PAGE), filled(&text, &all)?.as_bytes())
}

/// The text with the values in the places of their marks; other marks keep what they have.
fn filled(text: &str, values: &Values) -> anyhow::Result<String> {
    filled_by(text, |name, is| Ok(values.get(name).map_or(is, String::as_str).to_owned()))
}

/// Puts what the page in `out` says, and its pictures, into the documents.
pub(crate) fn publish(out: &Path, docs: &Path) -> anyhow::Result<()> {
    copy(&out.join(PAGE), &docs.join(PAGE))?;
    let (from, to) = (out.join("images/paper"), docs.join("images/paper"));
    std::fs::create_dir_all(&to).with_context(|| format!("cannot create {}", to.display()))?;
    let entries = std::fs::read_dir(&from).with_context(|| format!("cannot read {}", from.display()))?;
    for entry in entries {
        let name = entry?.file_name();
        copy(&from.join(&name), &to.join(&name))?;
    }
    Ok(())
}

fn copy(from: &Path, to: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(from).with_context(|| format!("cannot read {}", from.display()))?;
    write_whole(to, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_made_keeps_its_text() {
        let text = "SSIM <!-- figure a -->1<!-- /figure --> and <!-- figure b -->2<!-- /figure -->.";
        let values = Values::from([("b".into(), "3".into())]);
        let wanted = "SSIM <!-- figure a -->1<!-- /figure --> and <!-- figure b -->3<!-- /figure -->.";
        assert_eq!(filled(text, &values).unwrap(), wanted);
    }

    #[test]
    fn the_page_has_what_was_measured_now_and_before() {
        let folder = tempfile::tempdir().unwrap();
        let (docs, out) = (folder.path().join("docs"), folder.path().join("out"));
        std::fs::create_dir(&docs).unwrap();
        for part in ["images/paper", "work"] {
            std::fs::create_dir_all(out.join(part)).unwrap();
        }
        let text = "a <!-- figure a -->1<!-- /figure --> <!-- figure b -->1<!-- /figure -->";
        std::fs::write(docs.join(PAGE), text).unwrap();
        std::fs::write(out.join("images/paper/x.png"), "x").unwrap();
        for (name, value) in [("a", "2"), ("b", "3")] {
            fill(&docs, &out, Values::from([(name.into(), value.into())])).unwrap();
        }
        publish(&out, &docs).unwrap();
        let page = std::fs::read_to_string(docs.join(PAGE)).unwrap();
        assert!(page.contains("-->2<") && page.contains("-->3<"), "{page}");
        assert!(docs.join("images/paper/x.png").exists());
    }
}
