//! What a baked file is about, without reading its arrays.

use std::path::Path;

use serde::Serialize;

use crate::cluster_record::ClusterRecord;
use crate::description::InfoSection;
use crate::layout::{FORMAT_VERSION, SectionEntry, Tag, tag, tag_name};
use crate::read::{SectionReader, open};
use crate::{
    AssetError, BakeReport, BakeSettings, BakedScene, Emitter, LightSample, Probe, Surfel, SurfelGroup,
};

/// Summary of a baked file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BakedInfo {
    /// Version of the file format.
    pub format_version: u32,
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
    /// See [`BakedParts::matrix_bytes_per_receiver`].
    pub matrix_bytes_per_receiver: f64,
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
    /// Where it starts, bytes from the start of the file.
    pub offset: u64,
    /// Its length without padding, bytes.
    pub bytes: u64,
}

impl BakedScene {
    /// Reads and checks only the header, the section table and the settings of a file.
    ///
    /// # Errors
    /// As [`read`](Self::read), except that damage in the arrays goes unnoticed.
    pub fn read_info(path: &Path) -> Result<BakedInfo, AssetError> {
        let (file, file_bytes) = open(path)?;
        SectionReader::begin(file, file_bytes)
            .and_then(|mut sections| {
                let entries = sections.entries().to_vec();
                Ok(BakedInfo::new(file_bytes, &entries, sections.json(tag::INFO)?))
            })
            .map_err(|error| error.at(path))
    }
}

impl BakedInfo {
    fn new(file_bytes: u64, entries: &[SectionEntry], info: InfoSection) -> Self {
        let bytes = |tag: Tag| entries.iter().filter(|e| e.tag == tag).map(|e| e.length).sum::<u64>();
        let count = |tag, size: usize| bytes(tag) / size as u64;
        let receivers = count(tag::RECEIVER_TEXELS, size_of::<u32>());
        let matrices = [
            tag::RECEIVER_BASIS,
            tag::SIGNAL_BASIS,
            tag::ROW_SCALES,
            tag::COLUMN_EXPONENTS,
            tag::CLUSTER_SIGNALS,
            tag::CLUSTER_PROBES,
            tag::RECEIVER_TEXELS,
            tag::CLUSTERS,
        ];
        Self {
            format_version: FORMAT_VERSION,
            file_bytes,
            scene_hash: info.scene_hash,
            triangles: count(tag::TRIANGLES, size_of::<[u32; 3]>()),
            lightmap_width: info.lightmap_width,
            lightmap_height: info.lightmap_height,
            lightmap_pages: info.lightmap_pages,
            receivers,
            light_samples: count(tag::LIGHT_SAMPLES, size_of::<LightSample>()),
            surfels: count(tag::SURFELS, size_of::<Surfel>()),
            surfel_groups: count(tag::SURFEL_GROUPS, size_of::<SurfelGroup>()),
            emitters: count(tag::EMITTERS, size_of::<Emitter>()),
            probes: count(tag::PROBES, size_of::<Probe>()),
            clusters: count(tag::CLUSTERS, size_of::<ClusterRecord>()),
            matrix_bytes_per_receiver: matrices.map(bytes).iter().sum::<u64>() as f64
                / receivers.max(1) as f64,
            settings: info.settings,
            report: info.report,
            sections: entries
                .iter()
                .map(|e| SectionInfo { name: tag_name(&e.tag), offset: e.offset, bytes: e.length })
                .collect(),
        }
    }
}
