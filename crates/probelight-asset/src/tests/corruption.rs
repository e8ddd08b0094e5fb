//! Damage of any kind is refused, and nothing that a file may say makes the reader panic.

use proptest::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use super::{baked_scene, decoded, encoded, refusal};
use crate::layout::{HEADER_LENGTH, SectionEntry, TABLE_LENGTH, Tag, encode_front, tag};
use crate::{BakedParts, BakedScene};

/// The sections of a file in order.
fn split(bytes: &[u8]) -> Vec<(Tag, Vec<u8>)> {
    let table: Vec<SectionEntry> =
        bytemuck::pod_collect_to_vec(&bytes[HEADER_LENGTH..HEADER_LENGTH + TABLE_LENGTH]);
    let content = |entry: &SectionEntry| bytes[entry.offset as usize..][..entry.length as usize].to_vec();
    table.iter().map(|entry| (entry.tag, content(entry))).collect()
}

/// A file with these sections and valid checksums.
fn join(sections: &[(Tag, Vec<u8>)]) -> Vec<u8> {
    let borrowed: Vec<(Tag, &[u8])> = sections.iter().map(|(tag, bytes)| (*tag, &bytes[..])).collect();
    let (mut file, entries) = encode_front(&borrowed);
    for ((_, bytes), entry) in sections.iter().zip(entries) {
        file.resize(entry.offset as usize, 0);
        file.extend_from_slice(bytes);
    }
    file
}

/// Makes the checksums of header and table right again after a change to either.
fn reseal_front(file: &mut [u8]) {
    let table = xxh3_64(&file[HEADER_LENGTH..HEADER_LENGTH + TABLE_LENGTH]);
    file[24..32].copy_from_slice(&table.to_le_bytes());
    let header = xxh3_64(&file[..56]);
    file[56..64].copy_from_slice(&header.to_le_bytes());
}

/// The fixture's file with one section changed behind valid checksums.
fn with_section(tag: Tag, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut sections = split(&encoded(&baked_scene()));
    change(&mut sections.iter_mut().find(|section| section.0 == tag).unwrap().1);
    join(&sections)
}

/// Replaces text inside a JSON section.
fn with_text(tag: Tag, from: &str, to: &str) -> Vec<u8> {
    with_section(tag, |bytes| {
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert!(text.contains(from), "{from} is not in {text}");
        *bytes = text.replacen(from, to, 1).into_bytes();
    })
}

#[test]
fn taking_a_file_apart_and_joining_it_changes_nothing() {
    let bytes = encoded(&baked_scene());
    assert_eq!(join(&split(&bytes)), bytes);
    assert_eq!(split(&bytes).iter().map(|section| section.0).collect::<Vec<_>>(), tag::ALL);
}

#[test]
fn every_flipped_byte_is_noticed() {
    let good = encoded(&baked_scene());
    for at in 0..good.len() {
        for mask in [1u8 << (at % 8), 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= mask;
            assert!(decoded(&bytes).is_err(), "byte {at} changed by {mask:#x} is not noticed");
        }
    }
}

#[test]
fn every_truncation_is_noticed() {
    let good = encoded(&baked_scene());
    for length in 0..good.len() {
        refusal(&good[..length]);
        // The length is right when the file is opened, but reading finds its end earlier.
        assert!(BakedScene::decode(&good[..length], good.len() as u64).is_err(), "{length} bytes");
    }
    assert!(refusal(&good[..good.len() - 1]).contains("bytes long"));
    assert!(refusal(&[good, vec![0]].concat()).contains("bytes long"));
}

#[test]
fn other_files_are_called_foreign() {
    for bytes in [&b""[..], b"glTF", &[0; 5000], b"\x89PNG\r\n\x1a\n and so on"] {
        assert!(refusal(bytes).contains("does not start like one"));
    }
}

#[test]
fn other_versions_are_named() {
    for version in [0u32, 5, 7, u32::MAX] {
        let mut bytes = encoded(&baked_scene());
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        reseal_front(&mut bytes);
        assert!(refusal(&bytes).contains(&format!("format version {version},")));
    }
}

#[test]
fn sections_cannot_claim_more_than_the_file_holds() {
    let good = encoded(&baked_scene());
    for section in 0..tag::ALL.len() {
        let entry = HEADER_LENGTH + section * size_of::<SectionEntry>();
        for claim in [u64::MAX, u64::MAX - 63, 1 << 63, 1 << 40, good.len() as u64] {
            for field in [8, 16] {
                let mut bytes = good.clone();
                bytes[entry + field..][..8].copy_from_slice(&claim.to_le_bytes());
                reseal_front(&mut bytes);
                refusal(&bytes);
            }
        }
    }
    let mut bytes = good;
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    reseal_front(&mut bytes);
    assert!(refusal(&bytes).contains("4294967295 sections"));
}

#[test]
fn textures_cannot_claim_more_than_they_hold() {
    let huge = r#""width":4294967295,"height":4294967295"#;
    let bytes = with_text(tag::DESCRIPTION, r#""width":3,"height":2"#, huge);
    assert!(refusal(&bytes).contains("cannot hold"));
    let bytes = with_text(tag::DESCRIPTION, r#""width":3,"height":2"#, r#""width":2,"height":3"#);
    assert!(refusal(&bytes).contains("texture 0 ('noise.png') is damaged"));
    let bytes = with_section(tag::TEXTURES, |bytes| bytes.truncate(bytes.len() - 9));
    assert!(refusal(&bytes).contains("cut off"));
    let bytes = with_section(tag::TEXTURES, |bytes| bytes.push(0));
    assert!(refusal(&bytes).contains("belongs to no texture"));
}

#[test]
fn lightmaps_cannot_claim_more_than_they_use() {
    let field = r#""lightmap_height":6"#;
    for height in ["4294967294", "1000000000", "0"] {
        let bytes = with_text(tag::INFO, field, &format!(r#""lightmap_height":{height}"#));
        assert!(refusal(&bytes).contains("lightmap of 2 × "), "{height}");
    }
}

#[test]
fn unreadable_json_names_its_section() {
    let bytes = with_text(tag::INFO, r#""seed":"#, r#""weed":"#);
    assert!(refusal(&bytes).contains("its section 'info' cannot be understood"));
    let bytes = with_section(tag::DESCRIPTION, |bytes| *bytes = b"[".repeat(100_000));
    assert!(refusal(&bytes).contains("'descript'"));
}

#[test]
fn arrays_of_odd_length_are_refused() {
    for tag in &tag::ALL[3..] {
        let bytes = with_section(*tag, |bytes| bytes.push(0));
        // An array of bytes has no odd length, but a wrong one.
        let words = match *tag {
            tag::COLUMN_EXPONENTS => "the clusters need",
            tag::RELIGHT_GAINS => "gains of",
            tag::RECEIVER_ERRORS => "receivers' errors for",
            _ => "is damaged",
        };
        assert!(refusal(&bytes).contains(words));
    }
}

/// What decodes must be valid and be written again as the same scene.
fn decode_never_panics(bytes: &[u8]) {
    if let Ok(baked) = decoded(bytes) {
        BakedScene::new(BakedParts::clone(&baked)).unwrap();
        let again = decoded(&encoded(&baked)).unwrap();
        assert_eq!(format!("{again:?}"), format!("{baked:?}"));
    }
}

#[test]
fn every_byte_behind_valid_checksums_may_change() {
    let sections = split(&encoded(&baked_scene()));
    for section in 0..sections.len() {
        for at in 0..sections[section].1.len() {
            for value in [0, 0x7f, 0xff] {
                let mut changed = sections.clone();
                changed[section].1[at] = value;
                decode_never_panics(&join(&changed));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_content_behind_valid_checksums_is_survived(
        edits in prop::collection::vec((0..tag::ALL.len(), any::<prop::sample::Index>(), any::<u32>()), 1..4),
        resize in prop::option::of((0..tag::ALL.len(), 0usize..300)),
    ) {
        let mut sections = split(&encoded(&baked_scene()));
        for (section, at, value) in edits {
            let bytes = &mut sections[section].1;
            let at = at.index(bytes.len().max(4) / 4) * 4;
            if let Some(word) = bytes.get_mut(at..at + 4) {
                // Small numbers are the ones that get past the first checks.
                let value = if value % 3 == 0 { value } else { value % 16 };
                word.copy_from_slice(&value.to_le_bytes());
            }
        }
        if let Some((section, length)) = resize {
            sections[section].1.resize(length, 1);
        }
        decode_never_panics(&join(&sections));
    }

    #[test]
    fn any_front_behind_valid_checksums_is_survived(
        edits in prop::collection::vec((12..HEADER_LENGTH + TABLE_LENGTH, any::<u8>()), 1..6),
    ) {
        let mut bytes = encoded(&baked_scene());
        for (at, value) in edits {
            bytes[at] = value;
        }
        reseal_front(&mut bytes);
        decode_never_panics(&bytes);
    }

    #[test]
    fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        decode_never_panics(&bytes);
    }
}
