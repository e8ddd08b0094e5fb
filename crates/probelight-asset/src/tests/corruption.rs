//! Damage of any kind is refused, and nothing that a file may say makes the reader panic.

use proptest::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use probelight_scene::Texture;

use super::{baked_scene, encoded, refusal};
use crate::layout::{HEADER_LENGTH, MINOR_VERSION, SectionEntry, SectionHead, encode_front};
use crate::read::SectionReader;
use crate::sections::{self, Section};
use crate::textures::{decode_textures, encode_textures};
use crate::{BakedParts, BakedScene};

/// Bytes of header and table of the fixture, which has every section.
fn front_length() -> usize {
    HEADER_LENGTH + sections::ALL.len() * size_of::<SectionEntry>()
}

/// The sections of a file in order.
pub(super) fn split(bytes: &[u8]) -> Vec<(SectionHead, Vec<u8>)> {
    let count = u32::from_le_bytes(bytes[24..28].try_into().unwrap()) as usize;
    let table = &bytes[HEADER_LENGTH..][..count * size_of::<SectionEntry>()];
    let table: Vec<SectionEntry> = bytemuck::pod_collect_to_vec(table);
    let content = |entry: &SectionEntry| bytes[entry.offset as usize..][..entry.length as usize].to_vec();
    table.iter().map(|entry| (entry.head, content(entry))).collect()
}

/// A file with these sections and valid checksums.
pub(super) fn join(sections: &[(SectionHead, Vec<u8>)]) -> Vec<u8> {
    let borrowed: Vec<(SectionHead, &[u8])> =
        sections.iter().map(|(head, bytes)| (*head, &bytes[..])).collect();
    let (mut file, entries) = encode_front(MINOR_VERSION, &borrowed);
    for ((_, bytes), entry) in sections.iter().zip(entries) {
        file.resize(entry.offset as usize, 0);
        file.extend_from_slice(bytes);
    }
    file
}

/// The fixture's file with a first section that claims to be longer than any file.
pub(super) fn claiming(head: SectionHead, length: u64) -> Vec<u8> {
    let mut sections = split(&encoded(&baked_scene()));
    sections.retain(|section| section.0.name() != head.name());
    sections.insert(0, (head, Vec::new()));
    let mut file = join(&sections);
    let count = sections.len();
    let entries: &mut [SectionEntry] =
        bytemuck::cast_slice_mut(&mut file[HEADER_LENGTH..][..count * size_of::<SectionEntry>()]);
    entries[0].length = length;
    let mut end = entries[0].offset + length;
    for entry in &mut entries[1..] {
        entry.offset = end.next_multiple_of(64);
        end = entry.offset + entry.length;
    }
    file[16..24].copy_from_slice(&end.to_le_bytes());
    reseal_front(&mut file);
    file
}

/// Makes the checksums of header and table right again after a change to either.
fn reseal_front(file: &mut [u8]) {
    let count = u32::from_le_bytes(file[24..28].try_into().unwrap()) as usize;
    let end = (HEADER_LENGTH + count * size_of::<SectionEntry>()).min(file.len());
    let table = xxh3_64(&file[HEADER_LENGTH..end]);
    file[48..56].copy_from_slice(&table.to_le_bytes());
    let header = xxh3_64(&file[..56]);
    file[56..64].copy_from_slice(&header.to_le_bytes());
}

/// The fixture's file with one section changed behind valid checksums.
fn with_section(section: Section, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut sections = split(&encoded(&baked_scene()));
    change(&mut sections.iter_mut().find(|other| other.0 == section.head).unwrap().1);
    join(&sections)
}

/// Replaces text inside a JSON section.
fn with_text(section: Section, from: &str, to: &str) -> Vec<u8> {
    with_section(section, |bytes| {
        let text = String::from_utf8(bytes.clone()).unwrap();
        assert!(text.contains(from), "{from} is not in {text}");
        *bytes = text.replacen(from, to, 1).into_bytes();
    })
}

#[test]
fn taking_a_file_apart_and_joining_it_changes_nothing() {
    let bytes = encoded(&baked_scene());
    assert_eq!(join(&split(&bytes)), bytes);
    let declared: Vec<SectionHead> = sections::ALL.iter().map(|section| section.head).collect();
    assert_eq!(split(&bytes).iter().map(|section| section.0).collect::<Vec<_>>(), declared);
}

#[test]
fn every_flipped_byte_is_noticed() {
    let good = encoded(&baked_scene());
    for at in 0..good.len() {
        for mask in [1u8 << (at % 8), 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= mask;
            assert!(BakedScene::from_bytes(&bytes).is_err(), "byte {at} changed by {mask:#x} is not noticed");
        }
    }
}

#[test]
fn every_truncation_is_noticed() {
    let good = encoded(&baked_scene());
    for length in 0..good.len() {
        refusal(&good[..length]);
        // The length is right when the file is opened, but reading finds its end earlier.
        let cut =
            SectionReader::begin(&mut &good[..length], Some(good.len() as u64)).and_then(BakedScene::decode);
        assert!(cut.is_err(), "{length} bytes");
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
    for version in [0u32, 9, 11, u32::MAX] {
        let mut bytes = encoded(&baked_scene());
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        reseal_front(&mut bytes);
        assert!(refusal(&bytes).contains(&format!("format version {version},")));
    }
}

#[test]
fn sections_cannot_claim_more_than_the_file_holds() {
    let good = encoded(&baked_scene());
    for section in 0..sections::ALL.len() {
        let entry = HEADER_LENGTH + section * size_of::<SectionEntry>();
        for claim in [u64::MAX, u64::MAX - 63, 1 << 63, 1 << 40, good.len() as u64] {
            for field in [24, 32] {
                let mut bytes = good.clone();
                bytes[entry + field..][..8].copy_from_slice(&claim.to_le_bytes());
                reseal_front(&mut bytes);
                refusal(&bytes);
            }
        }
    }
    let mut bytes = good;
    bytes[24..28].copy_from_slice(&u32::MAX.to_le_bytes());
    reseal_front(&mut bytes);
    assert!(refusal(&bytes).contains("4294967295 sections"));
}

/// Where the first texture's PNG file starts in its section, and where it claims its width and height.
const PNG: usize = 8;
const PNG_SIZE: std::ops::Range<usize> = PNG + 16..PNG + 24;

#[test]
fn textures_cannot_claim_more_than_they_hold() {
    let texture = |change: fn(&mut Vec<u8>)| refusal(&with_section(sections::TEXTURES, change));
    assert!(texture(|bytes| bytes[PNG_SIZE].fill(0xff)).contains("cannot hold"));
    assert!(texture(|bytes| bytes[PNG + 24] = 16).contains("texture 0 ('noise.png') is damaged"));
    assert!(texture(|bytes| bytes.truncate(bytes.len() - 9)).contains("cut off"));
    assert!(texture(|bytes| bytes.push(0)).contains("belongs to no texture"));
    assert!(texture(|bytes| bytes[..8].fill(0xff)).contains("cut off"));
    assert!(texture(|bytes| bytes.clear()).contains("cut off"));
}

#[test]
fn textures_cannot_claim_far_more_than_the_file_together() {
    let png = |side: u32| {
        let plain = Texture {
            name: String::new(),
            width: side,
            height: side,
            rgba8: vec![0; side as usize * side as usize * 4].into(),
        };
        encode_textures(&[plain]).unwrap()
    };
    // 4096² plain texels, as often as fit into a GiB, and once more.
    let plain = png(4096);
    let decoded = |count| decode_textures(vec![String::new(); count], &plain.repeat(count));
    assert!(decoded(17).unwrap_err().to_string().contains("all textures together"));
    assert_eq!(decoded(2).unwrap().len(), 2);
}

#[test]
fn lightmaps_cannot_claim_more_than_they_use() {
    let field = r#""lightmap_height":6"#;
    for height in ["4294967294", "1000000000", "0"] {
        let bytes = with_text(sections::INFO, field, &format!(r#""lightmap_height":{height}"#));
        assert!(refusal(&bytes).contains("lightmap of 2 × "), "{height}");
    }
}

#[test]
fn unreadable_json_names_its_section() {
    let bytes = with_text(sections::INFO, r#""seed":"#, r#""weed":"#);
    assert!(refusal(&bytes).contains("its section 'info' cannot be understood"));
    let bytes = with_section(sections::DESCRIPTION, |bytes| *bytes = b"[".repeat(100_000));
    assert!(refusal(&bytes).contains("'description'"));
}

#[test]
fn arrays_of_odd_length_are_refused() {
    for section in &sections::ALL[3..] {
        let bytes = with_section(*section, |bytes| bytes.push(0));
        // An array of bytes has no odd length, but a wrong one.
        let words = match section.head.name() {
            "source-instances" => "cannot be understood",
            "column-exponents" => "the clusters need",
            "ray-gains" => "gains of",
            "receiver-errors" => "receivers' errors for",
            _ => "ends within an element",
        };
        assert!(refusal(&bytes).contains(words), "{}", section.head.name());
    }
}

/// What decodes must be valid and be written again as the same scene.
fn decode_never_panics(bytes: &[u8]) {
    if let Ok(baked) = BakedScene::from_bytes(bytes) {
        BakedScene::new(BakedParts::clone(&baked)).unwrap();
        let again = BakedScene::from_bytes(&encoded(&baked)).unwrap();
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
        edits in prop::collection::vec((0..sections::ALL.len(), any::<prop::sample::Index>(), any::<u32>()), 1..4),
        resize in prop::option::of((0..sections::ALL.len(), 0usize..300)),
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
        edits in prop::collection::vec((12..front_length(), any::<u8>()), 1..6),
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
