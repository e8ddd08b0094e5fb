//! File to baked scene.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;

use bytemuck::Pod;
use xxhash_rust::xxh3::xxh3_64;

use crate::cluster_record::ClusterRecord;
use crate::description::{DescriptionSection, InfoSection, decode_json};
use crate::error::DecodeError;
use crate::layout::{HEADER_LENGTH, SectionEntry, TABLE_LENGTH, Tag, decode_front, tag, tag_name};
use crate::textures::decode_textures;
use crate::{AssetError, BakedParts, BakedScene, Cluster, LightmapLayout};

impl BakedScene {
    /// Reads a file that [`write`](Self::write) has written.
    ///
    /// # Errors
    /// [`AssetError::Format`] for anything but a whole, undamaged file of this format version;
    /// [`AssetError::Io`] if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, AssetError> {
        let (file, length) = open(path)?;
        Self::decode(file, length).map_err(|error| error.at(path))
    }

    /// Reads all of a file of `file_length` bytes, front to back.
    pub(crate) fn decode(source: impl Read, file_length: u64) -> Result<Self, DecodeError> {
        let mut sections = SectionReader::begin(source, file_length)?;
        let info: InfoSection = sections.json(tag::INFO)?;
        let description: DescriptionSection = sections.json(tag::DESCRIPTION)?;
        let textures = decode_textures(&description.textures, &sections.array::<u8>(tag::TEXTURES)?)?;
        let mut scene = description.into_scene(textures);
        scene.positions = sections.array(tag::POSITIONS)?;
        scene.normals = sections.array(tag::NORMALS)?;
        scene.tangents = sections.array(tag::TANGENTS)?;
        scene.uv0 = sections.array(tag::UV0)?;
        scene.uv1 = sections.array(tag::UV1)?;
        scene.triangles = sections.array(tag::TRIANGLES)?;
        scene.triangle_material = sections.array(tag::TRIANGLE_MATERIAL)?;
        // Fields are evaluated in the order they are written here, which is the order in the file.
        let parts = BakedParts {
            scene: scene.into(),
            scene_hash: info.scene_hash,
            settings: info.settings,
            report: info.report,
            lightmap: LightmapLayout {
                width: info.lightmap_width,
                height: info.lightmap_height,
                pages: info.lightmap_pages,
                faces: sections.array(tag::FACES)?,
                back_faces: sections.array(tag::BACK_FACES)?,
                dilation: sections.array(tag::DILATION)?,
            },
            light_samples: sections.array(tag::LIGHT_SAMPLES)?,
            surfels: sections.array(tag::SURFELS)?,
            surfel_groups: sections.array(tag::SURFEL_GROUPS)?,
            emitters: sections.array(tag::EMITTERS)?,
            probes: sections.array(tag::PROBES)?,
            relight_directions: sections.array(tag::RELIGHT_DIRECTIONS)?,
            relight_surfels: sections.array(tag::RELIGHT_SURFELS)?,
            relight_gains: sections.array(tag::RELIGHT_GAINS)?,
            clusters: sections.array::<ClusterRecord>(tag::CLUSTERS)?.iter().map(Cluster::from).collect(),
            cluster_signals: sections.array(tag::CLUSTER_SIGNALS)?,
            cluster_probes: sections.array(tag::CLUSTER_PROBES)?,
            receiver_texels: sections.array(tag::RECEIVER_TEXELS)?,
            receiver_errors: sections.array(tag::RECEIVER_ERRORS)?,
            receiver_basis: sections.array(tag::RECEIVER_BASIS)?,
            signal_basis: sections.array(tag::SIGNAL_BASIS)?,
            row_scales: sections.array(tag::ROW_SCALES)?,
            column_exponents: sections.array(tag::COLUMN_EXPONENTS)?,
        };
        Self::new(parts).map_err(|error| DecodeError::Format(error.to_string()))
    }
}

/// Opens a file and learns its length.
pub(crate) fn open(path: &Path) -> Result<(BufReader<File>, u64), AssetError> {
    let opened = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
    let (length, file) = opened.map_err(|source| DecodeError::Io(source).at(path))?;
    Ok((BufReader::new(file), length))
}

/// Hands out the sections of a file one after the other, each checked.
pub(crate) struct SectionReader<R> {
    source: R,
    /// Bytes read so far.
    position: u64,
    entries: std::vec::IntoIter<SectionEntry>,
}

impl<R: Read> SectionReader<R> {
    /// Reads and checks header and section table.
    pub(crate) fn begin(mut source: R, file_length: u64) -> Result<Self, DecodeError> {
        let mut front = [0; HEADER_LENGTH + TABLE_LENGTH];
        // A short file of another kind should be told apart from a baked file that was cut off.
        let available = front.len().min(usize::try_from(file_length).unwrap_or(usize::MAX));
        read_exact(&mut source, &mut front[..available])?;
        let entries = decode_front(&front, file_length)?;
        Ok(Self { source, position: front.len() as u64, entries: entries.into_iter() })
    }

    /// The table's entries that are still to be read.
    pub(crate) fn entries(&self) -> &[SectionEntry] {
        self.entries.as_slice()
    }

    /// The next section, which must be `tag`, as an array.
    pub(crate) fn array<T: Pod>(&mut self, tag: Tag) -> Result<Vec<T>, DecodeError> {
        let damaged = || DecodeError::Format(format!("its section '{}' is damaged", tag_name(&tag)));
        let entry = self.entries.next().filter(|entry| entry.tag == tag).ok_or_else(damaged)?;
        self.skip_padding(entry.offset)?;
        let length = usize::try_from(entry.length).map_err(|_| damaged())?;
        if length % size_of::<T>() != 0 {
            return Err(damaged());
        }
        // `decode_front` has seen that the section lies within the file.
        let mut values = vec![T::zeroed(); length / size_of::<T>()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        read_exact(&mut self.source, bytes)?;
        self.position = entry.offset + entry.length;
        if xxh3_64(bytes) != entry.checksum {
            return Err(damaged());
        }
        Ok(values)
    }

    /// The next section, which must be `tag`, read as JSON.
    pub(crate) fn json<T: serde::de::DeserializeOwned>(&mut self, tag: Tag) -> Result<T, DecodeError> {
        let bytes: Vec<u8> = self.array(tag)?;
        decode_json(&tag_name(&tag), &bytes)
    }

    fn skip_padding(&mut self, offset: u64) -> Result<(), DecodeError> {
        let mut padding = [0; crate::layout::ALIGNMENT as usize];
        let padding = &mut padding[..(offset - self.position) as usize];
        read_exact(&mut self.source, padding)?;
        if padding.iter().any(|byte| *byte != 0) {
            return Err(DecodeError::format("the space between its sections is not empty"));
        }
        Ok(())
    }
}

/// Fills `bytes`; a file that ends early is a damaged file.
fn read_exact(source: &mut impl Read, bytes: &mut [u8]) -> Result<(), DecodeError> {
    source.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => DecodeError::format("it ends too early"),
        _ => DecodeError::Io(error),
    })
}
