//! File to baked scene.

use std::io::{ErrorKind, Read};

use bytemuck::Pod;
use xxhash_rust::xxh3::{Xxh3Default, xxh3_64};

use crate::error::DecodeError;
use crate::layout::{ALIGNMENT, FORMAT_VERSION, FileHeader, HEADER_LENGTH, MINOR_VERSION, SectionEntry};
use crate::sections::{self, Section};
use crate::textures::decode_textures;
use crate::{BakedParts, BakedScene};

/// Memory for a section grows by this many bytes at least while its bytes arrive, if nobody knows how many will.
const GROWTH: usize = 1 << 20;

impl BakedScene {
    /// Reads a baked file that is in memory.
    ///
    /// # Errors
    /// [`DecodeError::Format`] for anything but a whole, undamaged file of this format version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DecodeError> {
        Self::decode(SectionReader::begin(&mut &*bytes, Some(bytes.len() as u64))?)
    }

    /// Reads a baked file to its end, front to back: from the network, an archive, a pipe. Memory is taken as bytes
    /// arrive, whatever the file claims.
    ///
    /// # Errors
    /// As [`from_bytes`](Self::from_bytes), and those of `source`.
    pub fn from_reader(mut source: impl Read) -> Result<Self, DecodeError> {
        Self::decode(SectionReader::begin(&mut source, None)?)
    }

    /// Reads all sections; those that nobody knows are only checked.
    pub(crate) fn decode(mut reader: SectionReader<'_>) -> Result<Self, DecodeError> {
        reader.check_sections()?;
        let mut draft = Draft::default();
        while let Some(mut body) = reader.next()? {
            match sections::find(body.entry.head.name()) {
                Some(section) => (section.decode)(&mut draft, &mut body)?,
                None => body.skip()?,
            }
        }
        reader.end()?;
        draft.finish()
    }
}

/// A scene of which some sections are read.
#[derive(Default)]
pub(crate) struct Draft {
    pub(crate) parts: BakedParts,
    pub(crate) texture_names: Vec<String>,
    pub(crate) pngs: Vec<u8>,
}

impl Draft {
    fn finish(mut self) -> Result<BakedScene, DecodeError> {
        let scene = std::sync::Arc::make_mut(&mut self.parts.scene);
        scene.textures = decode_textures(self.texture_names, &self.pngs)?;
        BakedScene::new(self.parts).map_err(|error| DecodeError::Format(error.to_string()))
    }
}

/// Hands out the sections of a file one after the other.
pub(crate) struct SectionReader<'a> {
    source: &'a mut dyn Read,
    minor_version: u32,
    /// Whether the file is known to be as long as it claims.
    length_is_known: bool,
    /// Where the next byte lies.
    position: u64,
    entries: Vec<SectionEntry>,
    /// How many of them have been handed out.
    next: usize,
}

impl<'a> SectionReader<'a> {
    /// Reads and checks header and section table of a file whose real length may be known.
    pub(crate) fn begin(source: &'a mut dyn Read, real_length: Option<u64>) -> Result<Self, DecodeError> {
        // A short file of another kind should be told apart from a baked file that was cut off.
        let mut header = Vec::new();
        (&mut *source).take(HEADER_LENGTH as u64).read_to_end(&mut header)?;
        header.resize(HEADER_LENGTH, 0);
        let mut bytes = [0; HEADER_LENGTH];
        bytes.copy_from_slice(&header);
        let header = FileHeader::decode(&bytes, real_length)?;
        let mut table = vec![0; header.table_length()];
        read_exact(source, &mut table)?;
        Ok(Self {
            source,
            minor_version: header.minor_version,
            length_is_known: real_length.is_some(),
            position: (HEADER_LENGTH + table.len()) as u64,
            entries: header.decode_table(&table)?,
            next: 0,
        })
    }

    /// The section table.
    pub(crate) fn entries(&self) -> &[SectionEntry] {
        &self.entries
    }

    /// The file's minor version.
    pub(crate) fn minor_version(&self) -> u32 {
        self.minor_version
    }

    /// Refuses a file that lacks a required section, needs one that nobody knows, or has one with other elements.
    pub(crate) fn check_sections(&self) -> Result<(), DecodeError> {
        for SectionEntry { head, .. } in &self.entries {
            match sections::find(head.name()) {
                None if head.is_required() => {
                    return Err(DecodeError::Format(format!(
                        "it needs its section '{}', which this program does not know; the file has format version \
                         {FORMAT_VERSION}.{}, this program reads {FORMAT_VERSION}.{MINOR_VERSION}: use a newer one, or \
                         bake the scene again",
                        head.name(),
                        self.minor_version
                    )));
                }
                Some(known) if known.head.element_bytes != head.element_bytes => {
                    let (got, wanted) = (head.element_bytes, known.head.element_bytes);
                    let reason =
                        format!("has elements of {got} bytes, not of {wanted}; bake the scene again");
                    return Err(DecodeError::section(head.name(), &reason));
                }
                _ => {}
            }
        }
        let has = |section: &Section| self.entries.iter().any(|e| e.head.name() == section.head.name());
        match sections::ALL.iter().find(|section| section.head.is_required() && !has(section)) {
            Some(missing) => {
                Err(DecodeError::section(missing.head.name(), "is missing; bake the scene again"))
            }
            None => Ok(()),
        }
    }

    /// The next section, whose bytes must be read before the one after it.
    pub(crate) fn next(&mut self) -> Result<Option<SectionBody<'_>>, DecodeError> {
        let Some(entry) = self.entries.get(self.next).copied() else { return Ok(None) };
        self.next += 1;
        let mut padding = [0; ALIGNMENT as usize];
        // The table was checked: sections follow each other without gaps but padding.
        let padding = &mut padding[..(entry.offset - self.position) as usize];
        read_exact(self.source, padding)?;
        if padding.iter().any(|byte| *byte != 0) {
            return Err(DecodeError::format("the space between its sections is not empty"));
        }
        self.position = entry.offset + entry.length;
        Ok(Some(SectionBody { source: self.source, length_is_known: self.length_is_known, entry }))
    }

    /// Sees to it that nothing follows the last section.
    fn end(self) -> Result<(), DecodeError> {
        let mut behind = Vec::new();
        (&mut *self.source).take(1).read_to_end(&mut behind)?;
        if behind.is_empty() { Ok(()) } else { Err(DecodeError::format("it does not end where it should")) }
    }
}

/// The bytes of a section, still to be read.
pub(crate) struct SectionBody<'a> {
    source: &'a mut dyn Read,
    length_is_known: bool,
    pub(crate) entry: SectionEntry,
}

impl SectionBody<'_> {
    /// The section as an array.
    pub(crate) fn array<T: Pod>(&mut self) -> Result<Vec<T>, DecodeError> {
        let count =
            usize::try_from(self.entry.length).map_err(|_| self.refuse("is too large"))? / size_of::<T>();
        let mut values: Vec<T> = Vec::new();
        while values.len() < count {
            let start = values.len();
            let growth = start.max(GROWTH / size_of::<T>());
            let end = if self.length_is_known { count } else { count.min(start + growth) };
            values.resize(end, T::zeroed());
            read_exact(self.source, bytemuck::cast_slice_mut(&mut values[start..]))?;
        }
        self.check(xxh3_64(bytemuck::cast_slice(&values)))?;
        Ok(values)
    }

    /// The section read as JSON.
    pub(crate) fn json<T: serde::de::DeserializeOwned>(&mut self) -> Result<T, DecodeError> {
        let bytes: Vec<u8> = self.array()?;
        serde_json::from_slice(&bytes).map_err(|error| self.refuse(&format!("cannot be understood: {error}")))
    }

    /// Passes over the section; damage is noticed all the same.
    pub(crate) fn skip(&mut self) -> Result<(), DecodeError> {
        let (mut hash, mut buffer) = (Xxh3Default::new(), [0; 1 << 14]);
        let mut rest = self.entry.length;
        while rest > 0 {
            let part = buffer.len().min(usize::try_from(rest).unwrap_or(usize::MAX));
            read_exact(self.source, &mut buffer[..part])?;
            hash.update(&buffer[..part]);
            rest -= part as u64;
        }
        self.check(hash.digest())
    }

    fn check(&self, checksum: u64) -> Result<(), DecodeError> {
        if checksum == self.entry.checksum {
            Ok(())
        } else {
            Err(self.refuse("is damaged; bake the scene again"))
        }
    }

    fn refuse(&self, what: &str) -> DecodeError {
        DecodeError::section(self.entry.head.name(), what)
    }
}

/// Fills `bytes`; a file that ends early is a damaged file.
fn read_exact(source: &mut dyn Read, bytes: &mut [u8]) -> Result<(), DecodeError> {
    source.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => DecodeError::format("it ends too early"),
        _ => DecodeError::Io(error),
    })
}
