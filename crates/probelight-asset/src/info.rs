//! What a baked file is about, without reading its arrays.

use std::io::Read;

use serde::Serialize;

use crate::description::InfoSection;
use crate::error::DecodeError;
use crate::layout::{FORMAT_VERSION, SectionEntry};
use crate::read::SectionReader;
use crate::sections::{self, Section};
use crate::{BakeReport, BakeSettings, GridLayout};

/// Summary of a baked file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BakedInfo {
    /// Version of the file format.
    pub format_version: u32,
    /// Counts what newer files of that version have besides.
    pub format_minor_version: u32,
    /// Bytes of the whole file.
    pub file_bytes: u64,
    /// Hash of the source scene's content.
    pub scene_hash: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// Width of the lightmap, texels.
    pub lightmap_width: u32,
    /// Height of all lightmap pages together, texels.
    pub lightmap_height: u32,
    /// Number of lightmap pages.
    pub lightmap_pages: u32,
    /// Number of receivers.
    pub receivers: u64,
    /// Number of light samples.
    pub light_samples: u64,
    /// Number of surfels.
    pub surfels: u64,
    /// Number of surfel groups.
    pub surfel_groups: u64,
    /// Number of emitters.
    pub emitters: u64,
    /// Number of probes.
    pub probes: u64,
    /// Number of clusters.
    pub clusters: u64,
    /// See [`matrix_bytes_per_receiver`](crate::BakedParts::matrix_bytes_per_receiver).
    pub matrix_bytes_per_receiver: f64,
    /// Where the vertices of the grid in free space lie.
    pub grid: GridLayout,
    /// Number of its vertices that have light.
    pub grid_vertices: u64,
    /// See [`grid_bytes`](crate::BakedParts::grid_bytes).
    pub grid_bytes: u64,
    /// What the bake was asked for.
    pub settings: BakeSettings,
    /// What the bake measured.
    pub report: BakeReport,
    /// The file's sections, in order.
    pub sections: Vec<SectionInfo>,
}

/// One section of a baked file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SectionInfo {
    /// Its name in the section table.
    pub name: String,
    /// Whether readers that do not know it must refuse the file.
    pub required: bool,
    /// Where it starts, bytes from the start of the file.
    pub offset: u64,
    /// Its length without padding, bytes.
    pub bytes: u64,
}

impl BakedInfo {
    /// Reads and checks only the header, the section table and the settings of a baked file.
    ///
    /// # Errors
    /// As [`BakedScene::from_reader`](crate::BakedScene::from_reader), except that what follows the settings is not
    /// read: damage there goes unnoticed.
    pub fn from_reader(mut source: impl Read) -> Result<Self, DecodeError> {
        Self::decode(SectionReader::begin(&mut source, None)?)
    }

    pub(crate) fn decode(mut reader: SectionReader<'_>) -> Result<Self, DecodeError> {
        reader.check_sections()?;
        let (entries, minor_version) = (reader.entries().to_vec(), reader.minor_version());
        while let Some(mut body) = reader.next()? {
            if body.entry.head.name() == sections::INFO.head.name() {
                return Ok(Self::new(minor_version, &entries, body.json()?));
            }
            body.skip()?;
        }
        Err(DecodeError::section(sections::INFO.head.name(), "is missing"))
    }

    fn new(minor_version: u32, entries: &[SectionEntry], info: InfoSection) -> Self {
        let entry = |section: &Section| entries.iter().find(|e| e.head.name() == section.head.name());
        let bytes = |section: Section| entry(&section).map_or(0, |e| e.length);
        let count = |section: Section| bytes(section) / u64::from(section.head.element_bytes);
        let receivers = count(sections::RECEIVER_TEXELS);
        let matrices = [
            sections::RECEIVER_BASIS,
            sections::SIGNAL_BASIS,
            sections::ROW_SCALES,
            sections::COLUMN_EXPONENTS,
            sections::CLUSTER_SIGNALS,
            sections::CLUSTER_PROBES,
            sections::RECEIVER_TEXELS,
            sections::CLUSTERS,
            sections::GRID_BLOCKS,
            sections::GRID_VERTICES,
            sections::GRID_RECEIVERS,
            sections::GRID_CELL_BLOCKS,
            sections::GRID_CELLS,
            sections::GRID_PLANES,
        ];
        let matrix_bytes = matrices.map(bytes).iter().sum::<u64>();
        Self {
            format_version: FORMAT_VERSION,
            format_minor_version: minor_version,
            file_bytes: entries.last().map_or(0, |last| last.offset + last.length),
            scene_hash: info.scene_hash,
            triangles: count(sections::TRIANGLES),
            lightmap_width: info.lightmap_width,
            lightmap_height: info.lightmap_height,
            lightmap_pages: info.lightmap_pages,
            receivers,
            light_samples: count(sections::LIGHT_SAMPLES),
            surfels: count(sections::SURFELS),
            surfel_groups: count(sections::SURFEL_GROUPS),
            emitters: count(sections::EMITTERS),
            probes: count(sections::PROBES),
            clusters: count(sections::CLUSTERS),
            matrix_bytes_per_receiver: matrix_bytes.saturating_sub(info.grid_bytes) as f64
                / receivers.max(1) as f64,
            grid: info.grid,
            grid_vertices: count(sections::GRID_VERTICES),
            grid_bytes: info.grid_bytes,
            settings: info.settings,
            report: info.report,
            sections: entries.iter().map(SectionInfo::of).collect(),
        }
    }
}

impl SectionInfo {
    fn of(entry: &SectionEntry) -> Self {
        let SectionEntry { head, offset, length, .. } = *entry;
        Self { name: head.name().into(), required: head.is_required(), offset, bytes: length }
    }
}
