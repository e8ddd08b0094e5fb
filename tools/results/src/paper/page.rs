//! The page: the text of `docs/paper-figures.md` with the figures that were measured.

use std::path::Path;

use anyhow::Context;

use super::Values;
use super::workshop::write_whole;
use crate::documents::filled_by;

const PAGE: &str = "paper-figures.md";

/// Fills values into the page in `out`, which begins as that of the documents.
pub(crate) fn fill(docs: &Path, out: &Path, values: Values) -> anyhow::Result<()> {
    let page = out.join(PAGE);
    let begun = if page.exists() { page.clone() } else { docs.join(PAGE) };
    let text = std::fs::read_to_string(&begun).with_context(|| format!("cannot read {}", begun.display()))?;
    write_whole(&page, filled(&text, &values)?.as_bytes())
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
    fn the_page_is_begun_from_the_documents_and_published_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (docs, out) = (folder.path().join("docs"), folder.path().join("out"));
        std::fs::create_dir(&docs).unwrap();
        std::fs::create_dir_all(out.join("images/paper")).unwrap();
        std::fs::write(docs.join(PAGE), "a <!-- figure a -->1<!-- /figure -->").unwrap();
        std::fs::write(out.join("images/paper/x.png"), "x").unwrap();
        fill(&docs, &out, Values::from([("a".into(), "2".into())])).unwrap();
        publish(&out, &docs).unwrap();
        assert!(std::fs::read_to_string(docs.join(PAGE)).unwrap().contains("-->2<"));
        assert!(docs.join("images/paper/x.png").exists());
    }
}
