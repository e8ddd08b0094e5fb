//! `docs/file-format.md` tells the truth about the file.

use crate::layout::{FORMAT_VERSION, HEADER_LENGTH, MINOR_VERSION, SectionEntry};
use crate::sections;

/// The rows of the table of sections: name, need, bytes of an element.
fn documented(document: &str) -> Vec<[String; 3]> {
    let rows = document.lines().skip_while(|line| !line.starts_with("## Sections"));
    let rows = rows.take_while(|line| !line.starts_with("### ")).filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, name, need, bytes, ..] = cells[..] else { return None };
        let name = name.strip_prefix('`')?.strip_suffix('`')?;
        Some([name, need, bytes].map(String::from))
    });
    rows.collect()
}

fn document() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/file-format.md");
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn every_section_is_documented_and_nothing_else() {
    let declared: Vec<[String; 3]> = sections::ALL
        .iter()
        .map(|section| {
            let need = if section.head.is_required() { "required" } else { "optional" };
            [section.head.name().into(), need.into(), section.head.element_bytes.to_string()]
        })
        .collect();
    assert_eq!(documented(&document()), declared);
    let without_probes: String = document().lines().filter(|l| !l.contains("`probes`")).collect();
    assert_ne!(documented(&without_probes), declared, "a missing row is noticed");
}

#[test]
fn versions_and_sizes_are_documented() {
    let document = document();
    for stated in [
        format!("format version {FORMAT_VERSION}.{MINOR_VERSION}"),
        format!("## Header, {HEADER_LENGTH} bytes"),
        format!("## Section table, {} bytes a section", size_of::<SectionEntry>()),
    ] {
        assert!(document.contains(&stated), "{stated}");
    }
}
