//! Where things lie in a baked file: header, section table, alignment.

use bytemuck::{Pod, Zeroable};
use xxhash_rust::xxh3::xxh3_64;

use crate::error::DecodeError;

#[cfg(target_endian = "big")]
compile_error!("baked files are little-endian arrays that are read without conversion");

/// First bytes of every baked file. The first byte is not text, the last shows newline conversion.
const MAGIC: [u8; 8] = *b"\x89PLIGHT\n";

/// Version of the format that this crate writes and reads.
pub const FORMAT_VERSION: u32 = 10;

/// Counts additions that older readers of the same version may skip: optional sections, fields of JSON sections.
pub(crate) const MINOR_VERSION: u32 = 0;

/// Sections start at multiples of this, so that a mapped file's arrays are aligned for vector registers and
/// cache lines.
pub(crate) const ALIGNMENT: u64 = 64;

/// No file has more sections: the table is small, whatever a header claims.
const MAX_SECTIONS: u32 = 1024;

/// In [`SectionHead::flags`]: who does not know the section cannot use the file.
const REQUIRED: u32 = 1;

/// The first 64 bytes of the file.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct FileHeader {
    magic: [u8; 8],
    version: u32,
    pub(crate) minor_version: u32,
    /// Bytes of the whole file.
    file_length: u64,
    section_count: u32,
    /// Zero.
    reserved: [u32; 5],
    /// xxh3 of the section table.
    table_checksum: u64,
    /// xxh3 of the header's bytes before this field.
    header_checksum: u64,
}

/// Bytes of the header.
pub(crate) const HEADER_LENGTH: usize = size_of::<FileHeader>();

/// What a section is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SectionHead {
    /// Lower-case letters, digits and hyphens, padded with zeros.
    name: [u8; 16],
    flags: u32,
    /// Bytes of each element of the array that it holds; 1 for what is no array.
    pub(crate) element_bytes: u32,
}

/// One row of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SectionEntry {
    pub(crate) head: SectionHead,
    /// Bytes from the start of the file, a multiple of [`ALIGNMENT`].
    pub(crate) offset: u64,
    /// Bytes without padding.
    pub(crate) length: u64,
    /// xxh3 of these bytes.
    pub(crate) checksum: u64,
}

impl SectionHead {
    /// `name` has at most 16 bytes.
    pub(crate) const fn new(name: &str, is_required: bool, element_bytes: usize) -> Self {
        let (text, mut padded) = (name.as_bytes(), [0; 16]);
        let mut i = 0;
        while i < text.len() {
            padded[i] = text[i];
            i += 1;
        }
        let flags = if is_required { REQUIRED } else { 0 };
        Self { name: padded, flags, element_bytes: element_bytes as u32 }
    }

    /// The name without its padding.
    pub(crate) fn name(&self) -> &str {
        str::from_utf8(&self.name).unwrap_or_default().trim_end_matches('\0')
    }

    /// Whether readers that do not know the section must refuse the file.
    pub(crate) fn is_required(&self) -> bool {
        self.flags == REQUIRED
    }

    fn is_well_formed(&self) -> bool {
        let is_letter = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-';
        let length = self.name.iter().take_while(|c| is_letter(**c)).count();
        let is_padded = self.name[length..].iter().all(|c| *c == 0);
        length > 0 && is_padded && self.flags & !REQUIRED == 0 && self.element_bytes > 0
    }
}

/// The next multiple of [`ALIGNMENT`]; `None` on overflow.
fn aligned(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}

/// Header and table of a file with these sections.
pub(crate) fn encode_front(
    minor_version: u32,
    sections: &[(SectionHead, &[u8])],
) -> (Vec<u8>, Vec<SectionEntry>) {
    let mut end = (HEADER_LENGTH + size_of::<SectionEntry>() * sections.len()) as u64;
    let mut entries = Vec::with_capacity(sections.len());
    for (head, bytes) in sections {
        let offset = end.next_multiple_of(ALIGNMENT);
        let length = bytes.len() as u64;
        end = offset + length;
        entries.push(SectionEntry { head: *head, offset, length, checksum: xxh3_64(bytes) });
    }
    let table: &[u8] = bytemuck::cast_slice(&entries);
    let mut header = FileHeader {
        magic: MAGIC,
        version: FORMAT_VERSION,
        minor_version,
        file_length: end,
        section_count: entries.len() as u32,
        reserved: [0; 5],
        table_checksum: xxh3_64(table),
        header_checksum: 0,
    };
    header.header_checksum = header.checksum();
    ([bytemuck::bytes_of(&header), table].concat(), entries)
}

impl FileHeader {
    fn checksum(&self) -> u64 {
        xxh3_64(&bytemuck::bytes_of(self)[..HEADER_LENGTH - size_of::<u64>()])
    }

    /// Takes the header apart. Refuses what is not a whole baked file of this version; `real_length` is the file's
    /// length if it is known.
    pub(crate) fn decode(bytes: &[u8; HEADER_LENGTH], real_length: Option<u64>) -> Result<Self, DecodeError> {
        let header: Self = bytemuck::pod_read_unaligned(bytes);
        let fail = |reason: String| Err(DecodeError::Format(reason));
        if header.magic != MAGIC {
            return fail("it does not start like one; write one with `probelight bake`".into());
        }
        if header.version != FORMAT_VERSION {
            return fail(format!(
                "it has format version {}, and this program reads version {FORMAT_VERSION}; bake the scene \
                 again, or use the program that wrote it",
                header.version
            ));
        }
        if header.header_checksum != header.checksum() || header.reserved != [0; 5] {
            return fail("its header is damaged; bake the scene again".into());
        }
        if let Some(length) = real_length.filter(|length| *length != header.file_length) {
            return fail(format!(
                "it should be {} bytes long but has {length}; copy it anew or bake the scene again",
                header.file_length
            ));
        }
        if header.section_count > MAX_SECTIONS {
            return fail(format!("it has {} sections, at most {MAX_SECTIONS}", header.section_count));
        }
        Ok(header)
    }

    /// Bytes of the section table.
    pub(crate) fn table_length(&self) -> usize {
        self.section_count as usize * size_of::<SectionEntry>()
    }

    /// Takes the section table apart. Afterwards sections have different names, follow each other without gaps but
    /// padding, hold whole elements, and end where the file ends: no claimed length exceeds the file.
    pub(crate) fn decode_table(&self, table: &[u8]) -> Result<Vec<SectionEntry>, DecodeError> {
        if xxh3_64(table) != self.table_checksum {
            return Err(DecodeError::format("its section table is damaged; bake the scene again"));
        }
        let entries: Vec<SectionEntry> = bytemuck::pod_collect_to_vec(table);
        let mut end = Some((HEADER_LENGTH + table.len()) as u64);
        for (i, SectionEntry { head, offset, length, .. }) in entries.iter().enumerate() {
            let refuse = |what: &str| Err(DecodeError::section(head.name(), what));
            if !head.is_well_formed() {
                return Err(DecodeError::Format(format!("row {i} of its section table makes no sense")));
            }
            if entries[..i].iter().any(|earlier| earlier.head.name == head.name) {
                return refuse("is there twice");
            }
            if end.and_then(aligned) != Some(*offset) {
                return refuse("is misplaced");
            }
            if !length.is_multiple_of(head.element_bytes.into()) {
                return refuse("ends within an element");
            }
            end = offset.checked_add(*length);
        }
        if end != Some(self.file_length) {
            return Err(DecodeError::format("its sections do not end where the file ends"));
        }
        Ok(entries)
    }
}
