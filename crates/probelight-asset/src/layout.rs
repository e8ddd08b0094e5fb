//! Where things lie in a baked file: header, section table, alignment.

use bytemuck::{Pod, Zeroable};
use xxhash_rust::xxh3::xxh3_64;

use crate::error::DecodeError;

#[cfg(target_endian = "big")]
compile_error!("baked files are little-endian arrays that are read without conversion");

/// First bytes of every baked file. The first byte is not text, the last shows newline conversion.
const MAGIC: [u8; 8] = *b"\x89PLIGHT\n";

/// Version of the format that this crate writes and reads.
pub(crate) const FORMAT_VERSION: u32 = 6;

/// Sections start at multiples of this, so that a mapped file's arrays are aligned for vector registers and
/// cache lines.
pub(crate) const ALIGNMENT: u64 = 64;

/// Name of a section in the table: ASCII, padded with zeros.
pub(crate) type Tag = [u8; 8];

/// The sections of a file. It holds each of them once, in the order of [`tag::ALL`].
pub(crate) mod tag {
    use super::Tag;

    macro_rules! tags {
        ($($(#[$doc:meta])* $name:ident = $bytes:literal;)*) => {
            $($(#[$doc])* pub(crate) const $name: Tag = *$bytes;)*
            /// All sections in file order.
            pub(crate) const ALL: &[Tag] = &[$($name),*];
        };
    }

    tags! {
        /// JSON: what [`crate::BakedInfo`] shows.
        INFO = b"info\0\0\0\0";
        /// JSON: materials, lights, cameras, warnings, the list of textures.
        DESCRIPTION = b"descript";
        /// The textures' PNG files, one after the other.
        TEXTURES = b"textures";
        /// `[f32; 3]` a vertex.
        POSITIONS = b"position";
        /// `[f32; 3]` a vertex.
        NORMALS = b"normals\0";
        /// `[f32; 4]` a vertex.
        TANGENTS = b"tangents";
        /// `[f32; 2]` a vertex.
        UV0 = b"uv0\0\0\0\0\0";
        /// `[f32; 2]` a vertex, or empty.
        UV1 = b"uv1\0\0\0\0\0";
        /// `[u32; 3]` a triangle.
        TRIANGLES = b"triangle";
        /// `u32` a triangle.
        TRIANGLE_MATERIAL = b"trimater";
        /// `[f32; 6]` a lit face.
        FACES = b"faces\0\0\0";
        /// `u32` a triangle.
        BACK_FACES = b"backface";
        /// `[u32; 2]` a dilated texel.
        DILATION = b"dilation";
        /// 28 bytes a light sample.
        LIGHT_SAMPLES = b"litsampl";
        /// `[u32; 2]` a surfel.
        SURFELS = b"surfels\0";
        /// Two `u32` and an `f32` a group.
        SURFEL_GROUPS = b"surfgrou";
        /// A `u32` and three `f32` an emitter.
        EMITTERS = b"emitters";
        /// `[f32; 4]` a probe.
        PROBES = b"probes\0\0";
        /// `[f32; 3]` a relight ray.
        RELIGHT_DIRECTIONS = b"raydirec";
        /// `u32` a relight ray of a probe.
        RELIGHT_SURFELS = b"raysurfe";
        /// `u8` a relight ray of a probe.
        RELIGHT_GAINS = b"raygains";
        /// 112 bytes a cluster.
        CLUSTERS = b"clusters";
        /// `u32` a scalar signal of a cluster.
        CLUSTER_SIGNALS = b"clusigna";
        /// `u32` a probe of a cluster.
        CLUSTER_PROBES = b"cluprobe";
        /// `u32` a receiver.
        RECEIVER_TEXELS = b"texels\0\0";
        /// `u8` a receiver.
        RECEIVER_ERRORS = b"receverr";
        /// `u32` a word of packed values of U.
        RECEIVER_BASIS = b"basis-u\0";
        /// `u32` a word of packed values of ΣVᵀ.
        SIGNAL_BASIS = b"basis-sv";
        /// `f32` a row of ΣVᵀ.
        ROW_SCALES = b"rowscale";
        /// `u8` a column of ΣVᵀ.
        COLUMN_EXPONENTS = b"colexpon";
    }
}

/// The first 64 bytes of the file.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct FileHeader {
    magic: [u8; 8],
    version: u32,
    section_count: u32,
    /// Bytes of the whole file.
    file_length: u64,
    /// xxh3 of the section table.
    table_checksum: u64,
    /// Zero.
    reserved: [u64; 3],
    /// xxh3 of the header's bytes before this field.
    header_checksum: u64,
}

/// Bytes of the header.
pub(crate) const HEADER_LENGTH: usize = size_of::<FileHeader>();

/// One row of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SectionEntry {
    /// What the section holds.
    pub(crate) tag: Tag,
    /// Bytes from the start of the file, a multiple of [`ALIGNMENT`].
    pub(crate) offset: u64,
    /// Bytes without padding.
    pub(crate) length: u64,
    /// xxh3 of these bytes.
    pub(crate) checksum: u64,
}

/// Bytes of the section table.
pub(crate) const TABLE_LENGTH: usize = tag::ALL.len() * size_of::<SectionEntry>();

/// The next multiple of [`ALIGNMENT`]; `None` on overflow.
fn aligned(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}

/// Header and table of a file with `sections` in [`tag::ALL`]'s order.
pub(crate) fn encode_front(sections: &[(Tag, &[u8])]) -> (Vec<u8>, Vec<SectionEntry>) {
    let mut end = (HEADER_LENGTH + TABLE_LENGTH) as u64;
    let mut entries = Vec::with_capacity(sections.len());
    for (tag, bytes) in sections {
        let offset = end.next_multiple_of(ALIGNMENT);
        end = offset + bytes.len() as u64;
        entries.push(SectionEntry {
            tag: *tag,
            offset,
            length: bytes.len() as u64,
            checksum: xxh3_64(bytes),
        });
    }
    let table: &[u8] = bytemuck::cast_slice(&entries);
    let mut header = FileHeader {
        magic: MAGIC,
        version: FORMAT_VERSION,
        section_count: entries.len() as u32,
        file_length: end,
        table_checksum: xxh3_64(table),
        reserved: [0; 3],
        header_checksum: 0,
    };
    header.header_checksum = header.checksum();
    ([bytemuck::bytes_of(&header), table].concat(), entries)
}

impl FileHeader {
    fn checksum(&self) -> u64 {
        xxh3_64(&bytemuck::bytes_of(self)[..HEADER_LENGTH - size_of::<u64>()])
    }

    /// Refuses what is not a whole baked file of this version; `file_length` is the file's real length.
    fn check(&self, file_length: u64) -> Result<(), DecodeError> {
        let fail = |reason: String| Err(DecodeError::Format(reason));
        if self.magic != MAGIC {
            return fail("it does not start like one; write one with `probelight bake`".into());
        }
        if self.version != FORMAT_VERSION {
            return fail(format!(
                "it has format version {}, and this program reads version {FORMAT_VERSION}; bake the scene \
                 again, or use the program that wrote it",
                self.version
            ));
        }
        if self.header_checksum != self.checksum() || self.reserved != [0; 3] {
            return fail("its header is damaged; bake the scene again".into());
        }
        if self.file_length != file_length {
            return fail(format!(
                "it should be {} bytes long but has {file_length}; copy it anew or bake the scene again",
                self.file_length
            ));
        }
        if self.section_count as usize != tag::ALL.len() {
            return fail(format!("it has {} sections instead of {}", self.section_count, tag::ALL.len()));
        }
        Ok(())
    }
}

/// Checks header and table and returns the table. Afterwards the sections are known to follow each other
/// without gaps but padding, and to end where the file ends: no claimed length exceeds the file.
pub(crate) fn decode_front(bytes: &[u8], file_length: u64) -> Result<Vec<SectionEntry>, DecodeError> {
    let (header, table) = bytes.split_at(HEADER_LENGTH);
    let header: FileHeader = bytemuck::pod_read_unaligned(header);
    header.check(file_length)?;
    if xxh3_64(table) != header.table_checksum {
        return Err(DecodeError::format("its section table is damaged; bake the scene again"));
    }
    let entries: Vec<SectionEntry> = bytemuck::pod_collect_to_vec(table);
    let mut end = Some(bytes.len() as u64);
    for (entry, tag) in entries.iter().zip(tag::ALL) {
        let misplaced = || DecodeError::Format(format!("its section '{}' is misplaced", tag_name(tag)));
        if entry.tag != *tag || end.and_then(aligned) != Some(entry.offset) {
            return Err(misplaced());
        }
        end = entry.offset.checked_add(entry.length);
    }
    if end != Some(file_length) {
        return Err(DecodeError::format("its sections do not end where the file ends"));
    }
    Ok(entries)
}

/// A tag as text.
pub(crate) fn tag_name(tag: &Tag) -> String {
    let length = tag.iter().position(|byte| *byte == 0).unwrap_or(tag.len());
    String::from_utf8_lossy(&tag[..length]).into_owned()
}
