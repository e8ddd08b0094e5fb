//! Baked scene to file.

use std::borrow::Cow;
use std::io::{self, Read, Write};
use std::path::Path;

use bytemuck::cast_slice;

use crate::cluster_record::ClusterRecord;
use crate::description::{DescriptionSection, InfoSection};
use crate::layout::{Tag, encode_front, tag};
use crate::textures::encode_textures;
use crate::{AssetError, BakedScene, write_atomically};

impl BakedScene {
    /// Writes the file atomically: `path` is replaced when everything is on the disk, or not at all. The
    /// same scene always gives the same bytes.
    ///
    /// # Errors
    /// [`AssetError::Io`] if the disk refuses.
    pub fn write(&self, path: &Path) -> Result<(), AssetError> {
        write_atomically(path, |file| self.encode(file)).map_err(|source| AssetError::Io {
            action: "write",
            path: path.into(),
            source,
        })
    }

    /// Writes header, table and sections.
    pub(crate) fn encode(&self, out: &mut impl Write) -> io::Result<()> {
        let sections = self.sections()?;
        let borrowed: Vec<(Tag, &[u8])> = sections.iter().map(|(tag, bytes)| (*tag, &bytes[..])).collect();
        let (front, entries) = encode_front(&borrowed);
        out.write_all(&front)?;
        let mut end = front.len() as u64;
        for ((_, bytes), entry) in borrowed.iter().zip(&entries) {
            io::copy(&mut io::repeat(0).take(entry.offset - end), out)?;
            out.write_all(bytes)?;
            end = entry.offset + entry.length;
        }
        Ok(())
    }

    /// All sections in file order; arrays are borrowed.
    fn sections(&self) -> io::Result<Vec<(Tag, Cow<'_, [u8]>)>> {
        let scene = &self.scene;
        let (entries, pngs) = encode_textures(&scene.textures).map_err(io::Error::other)?;
        let clusters: Vec<ClusterRecord> = self.clusters.iter().map(ClusterRecord::from).collect();
        Ok(vec![
            (tag::INFO, serde_json::to_vec(&InfoSection::of(self))?.into()),
            (tag::DESCRIPTION, serde_json::to_vec(&DescriptionSection::of(scene, entries))?.into()),
            (tag::TEXTURES, pngs.into()),
            (tag::POSITIONS, cast_slice(&scene.positions).into()),
            (tag::NORMALS, cast_slice(&scene.normals).into()),
            (tag::TANGENTS, cast_slice(&scene.tangents).into()),
            (tag::UV0, cast_slice(&scene.uv0).into()),
            (tag::UV1, cast_slice(&scene.uv1).into()),
            (tag::TRIANGLES, cast_slice(&scene.triangles).into()),
            (tag::TRIANGLE_MATERIAL, cast_slice(&scene.triangle_material).into()),
            (tag::FACES, cast_slice(&self.lightmap.faces).into()),
            (tag::BACK_FACES, cast_slice(&self.lightmap.back_faces).into()),
            (tag::DILATION, cast_slice(&self.lightmap.dilation).into()),
            (tag::LIGHT_SAMPLES, cast_slice(&self.light_samples).into()),
            (tag::SURFELS, cast_slice(&self.surfels).into()),
            (tag::SURFEL_GROUPS, cast_slice(&self.surfel_groups).into()),
            (tag::EMITTERS, cast_slice(&self.emitters).into()),
            (tag::PROBES, cast_slice(&self.probes).into()),
            (tag::RELIGHT_DIRECTIONS, cast_slice(&self.relight_directions).into()),
            (tag::RELIGHT_SURFELS, cast_slice(&self.relight_surfels).into()),
            (tag::RELIGHT_GAINS, self.relight_gains[..].into()),
            (tag::CLUSTERS, cast_slice::<_, u8>(&clusters).to_vec().into()),
            (tag::CLUSTER_SIGNALS, cast_slice(&self.cluster_signals).into()),
            (tag::CLUSTER_PROBES, cast_slice(&self.cluster_probes).into()),
            (tag::RECEIVER_TEXELS, cast_slice(&self.receiver_texels).into()),
            (tag::RECEIVER_ERRORS, self.receiver_errors[..].into()),
            (tag::RECEIVER_BASIS, cast_slice(&self.receiver_basis).into()),
            (tag::SIGNAL_BASIS, cast_slice(&self.signal_basis).into()),
            (tag::ROW_SCALES, cast_slice(&self.row_scales).into()),
            (tag::COLUMN_EXPONENTS, self.column_exponents[..].into()),
        ])
    }
}
