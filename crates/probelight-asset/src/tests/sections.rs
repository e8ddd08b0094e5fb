//! Files with other sections: those of newer writers, and impossible ones.

use std::borrow::Cow;
use std::io::Read;

use proptest::prelude::*;

use super::corruption::{join, split};
use super::{baked_scene, checked, encoded, refusal};
use crate::layout::{MINOR_VERSION, SectionHead};
use crate::sections;
use crate::tests::fixture::baked_parts;
use crate::write::write_sections;
use crate::{BakedInfo, BakedScene, DecodeError};

type Sections = Vec<(SectionHead, Vec<u8>)>;

/// A section that this version does not know.
fn unknown(is_required: bool, bytes: usize) -> (SectionHead, Vec<u8>) {
    (SectionHead::new("cells-of-air", is_required, 4), vec![7; bytes])
}

fn changed(change: impl FnOnce(&mut Sections)) -> Vec<u8> {
    let mut sections = split(&encoded(&baked_scene()));
    change(&mut sections);
    join(&sections)
}

fn shown(baked: &BakedScene) -> String {
    format!("{baked:?}")
}

#[test]
fn unknown_optional_sections_are_passed_over_wherever_they_are() {
    let expected = shown(&baked_scene());
    for place in 0..=sections::ALL.len() {
        let bytes = changed(|sections| sections.insert(place, unknown(false, 100_000)));
        assert_eq!(shown(&BakedScene::from_bytes(&bytes).unwrap()), expected, "at {place}");
        let info = BakedInfo::from_reader(&bytes[..]).unwrap();
        assert_eq!((&info.sections[place].name[..], info.sections[place].required), ("cells-of-air", false));
    }
}

#[test]
fn damage_in_unknown_sections_is_noticed() {
    let mut bytes = changed(|sections| sections.push(unknown(false, 20_000)));
    let middle = bytes.len() - 10_000;
    bytes[middle] ^= 1;
    assert!(refusal(&bytes).contains("'cells-of-air' is damaged"));
}

#[test]
fn unknown_required_sections_are_refused_with_the_versions() {
    let mut sections = split(&encoded(&baked_scene()));
    sections.push(unknown(true, 8));
    let sections: Vec<_> = sections.into_iter().map(|(head, bytes)| (head, Cow::from(bytes))).collect();
    let mut bytes = Vec::new();
    write_sections(MINOR_VERSION + 3, &sections, &mut bytes).unwrap();
    for reason in [refusal(&bytes), BakedInfo::from_reader(&bytes[..]).unwrap_err().to_string()] {
        assert!(reason.contains("needs its section 'cells-of-air'"), "{reason}");
        assert!(reason.contains("version 10.3,") && reason.contains("reads 10.0"), "{reason}");
    }
}

#[test]
fn newer_minor_versions_are_read() {
    let sections = split(&encoded(&baked_scene()));
    let sections: Vec<_> = sections.into_iter().map(|(head, bytes)| (head, Cow::from(bytes))).collect();
    let mut bytes = Vec::new();
    write_sections(MINOR_VERSION + 1, &sections, &mut bytes).unwrap();
    assert_eq!(shown(&BakedScene::from_bytes(&bytes).unwrap()), shown(&baked_scene()));
    assert_eq!(BakedInfo::from_reader(&bytes[..]).unwrap().format_minor_version, MINOR_VERSION + 1);
}

#[test]
fn sections_twice_are_refused() {
    for section in split(&encoded(&baked_scene())) {
        let name = section.0.name().to_string();
        let bytes = changed(|sections| sections.push(section));
        assert!(refusal(&bytes).contains(&format!("'{name}' is there twice")));
    }
    let bytes = changed(|sections| sections.extend([unknown(false, 4), unknown(false, 8)]));
    assert!(refusal(&bytes).contains("'cells-of-air' is there twice"));
}

#[test]
fn missing_sections_are_refused_if_they_are_required() {
    for (place, section) in sections::ALL.iter().enumerate() {
        let bytes = changed(|sections| drop(sections.remove(place)));
        match section.head.is_required() {
            true => assert!(refusal(&bytes).contains(&format!("'{}' is missing", section.head.name()))),
            // Source triangles without their instances make no sense, nor some of the grid's walls, which is another matter.
            false if section.head.name() == "source-instances" => {
                assert!(refusal(&bytes).contains("source instance"));
            }
            false if section.head.name().starts_with("grid") => {
                assert!(refusal(&bytes).contains("the grid"), "{}", refusal(&bytes));
            }
            false => assert!(BakedScene::from_bytes(&bytes).unwrap().scene.sources.triangles.is_empty()),
        }
    }
}

#[test]
fn scenes_without_a_source_write_no_such_sections() {
    let mut parts = baked_parts();
    std::sync::Arc::make_mut(&mut parts.scene).sources = Default::default();
    let baked = checked(parts);
    let sections = split(&encoded(&baked));
    assert_eq!(sections.len(), sections::ALL.len() - 2);
    assert!(sections.iter().all(|(head, _)| !head.name().starts_with("source")));
    assert_eq!(shown(&BakedScene::from_bytes(&encoded(&baked)).unwrap()), shown(&baked));
}

#[test]
fn grids_without_walls_write_no_such_sections() {
    let mut parts = baked_parts();
    (parts.grid_cell_blocks, parts.grid_cells, parts.grid_planes) = Default::default();
    let baked = checked(parts);
    let sections = split(&encoded(&baked));
    assert_eq!(sections.len(), sections::ALL.len() - 3);
    assert_eq!(shown(&BakedScene::from_bytes(&encoded(&baked)).unwrap()), shown(&baked));
}

#[test]
fn elements_of_another_size_are_refused() {
    for (place, section) in sections::ALL.iter().enumerate() {
        let bytes = changed(|sections| {
            let (head, bytes) = &mut sections[place];
            let wider = head.element_bytes as usize + 4;
            *head = SectionHead::new(head.name(), head.is_required(), wider);
            bytes.resize(bytes.len().next_multiple_of(wider), 0);
        });
        let name = section.head.name();
        assert!(refusal(&bytes).contains(&format!("'{name}' has elements of")), "{name}");
    }
}

#[test]
fn names_are_short_plain_words() {
    for name in ["", "Faces", "two words", "caf\u{e9}", "a\0b"] {
        let bytes = changed(|sections| sections.push((SectionHead::new(name, false, 4), Vec::new())));
        assert!(refusal(&bytes).contains("row 38 of its section table makes no sense"), "{name:?}");
    }
    for section in sections::ALL {
        assert!(section.head.name().len() <= 16 && sections::find(section.head.name()).is_some());
    }
}

/// Hands out a few bytes at a time, as a socket may.
struct Trickle<'a>(&'a [u8]);

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let length = buffer.len().min(7);
        self.0.read(&mut buffer[..length])
    }
}

#[test]
fn any_reader_will_do() {
    let bytes = encoded(&baked_scene());
    assert_eq!(shown(&BakedScene::from_reader(Trickle(&bytes)).unwrap()), shown(&baked_scene()));
    for length in 0..bytes.len() {
        let refused = BakedScene::from_reader(&bytes[..length]);
        assert!(matches!(refused, Err(DecodeError::Format(_))), "{length} bytes");
    }
    let longer = [&bytes[..], &[0]].concat();
    let reason = BakedScene::from_reader(&longer[..]).unwrap_err().to_string();
    assert!(reason.contains("does not end where it should"), "{reason}");
}

#[test]
fn a_stream_that_claims_much_takes_no_memory() {
    // A terabyte behind valid checksums: only its first bytes are there.
    let sections = [(unknown(false, 0).0, 1u64 << 40), (sections::POSITIONS.head, 12 << 36)];
    for (head, claim) in sections {
        let bytes = super::corruption::claiming(head, claim);
        let reason = BakedScene::from_reader(&bytes[..]).unwrap_err().to_string();
        assert!(reason.contains("ends too early"), "{reason}");
        assert!(refusal(&bytes).contains("bytes long"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Known sections in any order, unknown ones among them.
    #[test]
    fn the_order_of_sections_does_not_matter(
        order in Just((0..sections::ALL.len()).collect::<Vec<_>>()).prop_shuffle(),
        unknown_at in prop::option::of((0..sections::ALL.len(), 0usize..50)),
    ) {
        let sections = split(&encoded(&baked_scene()));
        let mut shuffled: Sections = order.iter().map(|place| sections[*place].clone()).collect();
        if let Some((place, elements)) = unknown_at {
            shuffled.insert(place, unknown(false, 4 * elements));
        }
        let read = BakedScene::from_bytes(&join(&shuffled)).unwrap();
        prop_assert_eq!(shown(&read), shown(&baked_scene()));
    }
}
