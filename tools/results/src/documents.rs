//! Figures in documents. `<!-- figure NAME -->` and `<!-- /figure -->` enclose what the figures say; a NAME that
//! begins with `table` stands for a whole table.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use probelight_asset::write_atomically;

use crate::figures::Figures;
use crate::lookup;

const OPENING: &str = "<!-- figure ";
const OPENING_END: &str = " -->";
const CLOSING: &str = "<!-- /figure -->";

/// The files whose figures are marked, below the repository's root.
const DOCUMENTS: [&str; 5] =
    ["README.md", "ARCHITECTURE.md", "docs/results.md", "docs/gpu.md", "docs/method.md"];

/// Documents in which every measured quantity must be marked.
const MARKED_THROUGHOUT: [&str; 2] = ["README.md", "docs/results.md"];

/// Units of what is measured.
const UNITS: [&str; 8] = ["%", "ms", "s", "bytes", "kB", "MB", "MiB", "GB/s"];

/// A document as it is and as the figures want it.
pub(crate) struct Document {
    pub(crate) path: PathBuf,
    pub(crate) is: String,
    pub(crate) wanted: String,
}

/// Reads all documents below `root` and fills in their figures.
pub(crate) fn read_all(root: &Path, figures: &Figures) -> anyhow::Result<Vec<Document>> {
    let read = |name: &str| {
        let path = root.join(name);
        let is = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let wanted = filled(&is, figures).with_context(|| name.to_owned())?;
        if MARKED_THROUGHOUT.contains(&name) {
            ensure_marked(&is).with_context(|| name.to_owned())?;
        }
        Ok(Document { path, is, wanted })
    };
    DOCUMENTS.into_iter().map(read).collect()
}

/// The text with all marked figures as they should be.
fn filled(text: &str, figures: &Figures) -> anyhow::Result<String> {
    filled_by(text, |name, _| lookup::value(figures, name))
}

/// The text with all marked figures as `value` has them, given their names and what the text says now.
pub(crate) fn filled_by(
    text: &str,
    value: impl Fn(&str, &str) -> anyhow::Result<String>,
) -> anyhow::Result<String> {
    let mut result = String::new();
    let mut rest = text;
    while let Some((before, marked)) = rest.split_once(OPENING) {
        let (name, marked) = marked.split_once(OPENING_END).context("a figure's name does not end")?;
        let (is, after) =
            marked.split_once(CLOSING).with_context(|| format!("the figure {name} does not end"))?;
        let value = value(name, is).with_context(|| format!("the figure {name}"))?;
        let is_table = value.contains('\n');
        // In Markdown a line that begins with a comment is no text.
        let begins_line = before.is_empty() || before.ends_with('\n');
        ensure!(is_table == begins_line, "the figure {name} must stand {}", place(is_table));
        result += &format!("{before}{OPENING}{name}{OPENING_END}{value}{CLOSING}");
        rest = after;
    }
    Ok(result + rest)
}

fn place(is_table: bool) -> &'static str {
    if is_table { "at the beginning of a line" } else { "within a line" }
}

/// Fails if a quantity with a unit stands outside marked figures.
fn ensure_marked(text: &str) -> anyhow::Result<()> {
    let prose = without_figures(text);
    let words: Vec<&str> = prose.split_whitespace().collect();
    for pair in words.windows(2) {
        let unit = pair[1].trim_end_matches(|c: char| c.is_ascii_punctuation() && c != '%');
        let number = pair[0].trim_matches(|c: char| !c.is_ascii_digit());
        if UNITS.contains(&unit) && number.starts_with(|c: char| c.is_ascii_digit()) {
            bail!("\"{} {}\" is measured but not marked as a figure", pair[0], pair[1]);
        }
    }
    Ok(())
}

/// The text outside marked figures and code blocks.
fn without_figures(text: &str) -> String {
    let outside = |text: &str, opening: &str, closing: &str| {
        let mut parts = text.split(opening);
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |kept, part| kept + part.split_once(closing).map_or("", |(_, after)| after))
    };
    outside(&outside(text, OPENING, CLOSING), "\n```", "\n```\n")
}

/// Writes a file as a whole.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_atomically(path, |file| file.write_all(bytes))
        .with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Bake;

    fn figures() -> Figures {
        let bake = Bake { bytes_per_receiver: 51.4, ..Bake::default() };
        Figures { bakes: [("cornell".into(), bake)].into(), ..Figures::default() }
    }

    #[test]
    fn the_documents_agree_with_the_figures() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let figures = Figures::read(&root.join("docs/results.json")).unwrap();
        for document in read_all(&root, &figures).unwrap() {
            let advice = "run `cargo run --release -p results -- write`";
            assert!(document.is == document.wanted, "{} is out of date: {advice}", document.path.display());
        }
    }

    #[test]
    fn figures_are_filled_in_and_what_is_around_them_stays() {
        let text = "It takes <!-- figure cornell/bytes -->7<!-- /figure --> bytes,\nno more.\n";
        let right = "It takes <!-- figure cornell/bytes -->51<!-- /figure --> bytes,\nno more.\n";
        assert_eq!(filled(text, &figures()).unwrap(), right);
        assert_eq!(filled(right, &figures()).unwrap(), right);
    }

    #[test]
    fn wrong_marks_are_refused() {
        let message = |text: &str| format!("{:#}", filled(text, &figures()).unwrap_err());
        assert!(message("a <!-- figure cornell/bytes -->7").contains("does not end"));
        assert!(message("a <!-- figure cornell/bites -->7<!-- /figure -->").contains("cornell/bites"));
        assert!(message("a <!-- figure rooms/bytes -->7<!-- /figure -->").contains("rooms/bytes"));
        assert!(message("<!-- figure cornell/bytes -->7<!-- /figure -->").contains("within a line"));
        assert!(message("a <!-- figure table bakes -->7<!-- /figure -->").contains("beginning of a line"));
    }

    #[test]
    fn quantities_outside_figures_are_noticed() {
        ensure_marked("two cores, 3 rooms; a <!-- figure x -->5 ms<!-- /figure --> b").unwrap();
        ensure_marked("a\n```sh\nsleep 5 s\n```\nb").unwrap();
        for text in ["it takes 5 ms", "an error of (2.4 %), or so", "≤ 12 bytes."] {
            assert!(ensure_marked(text).is_err(), "{text}");
        }
    }
}
