//! The sections of a baked file: the one place where each is declared.
//!
//! Writing, reading, the summary and the tests of damaged files all go through [`ALL`]. A new array takes a field in
//! [`BakedParts`] and a line here; a rule in `validate/`; a row in `docs/file-format.md`, which a test compares. If
//! older programs may do without it, make it optional and count up the minor version.

use std::borrow::Cow;
use std::io;
use std::sync::Arc;

use bytemuck::cast_slice;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::SourceTriangle;

use crate::description::{DescriptionSection, InfoSection};
use crate::error::DecodeError;
use crate::layout::SectionHead;
use crate::read::{Draft, SectionBody};
use crate::textures::encode_textures;
use crate::{
    BakedParts, Cluster, Emitter, GridBlock, GridCell, GridVertex, LightSample, LightmapFace, Probe, Surfel,
    SurfelGroup,
};

/// A section that this crate knows.
#[derive(Clone, Copy)]
pub(crate) struct Section {
    /// Name, whether it is required, bytes of an element.
    pub(crate) head: SectionHead,
    /// Its bytes; arrays are borrowed. An optional section without bytes is not written.
    pub(crate) encode: fn(&BakedParts) -> io::Result<Cow<'_, [u8]>>,
    /// Puts its content in its place.
    pub(crate) decode: fn(&mut Draft, &mut SectionBody<'_>) -> Result<(), DecodeError>,
}

/// The section of a name.
pub(crate) fn find(name: &str) -> Option<&'static Section> {
    ALL.iter().find(|section| section.head.name() == name)
}

/// A section that is an array, as it lies in a field of the scene or of the other parts.
macro_rules! array {
    ($name:literal, $is_required:expr, [$element:ty], scene.$($field:ident).+) => {
        Section {
            head: SectionHead::new($name, $is_required, size_of::<$element>()),
            encode: |parts| Ok(cast_slice::<$element, u8>(&parts.scene.$($field).+).into()),
            decode: |draft, body| {
                Arc::make_mut(&mut draft.parts.scene).$($field).+ = body.array::<$element>()?;
                Ok(())
            },
        }
    };
    ($name:literal, $is_required:expr, [$element:ty], $($field:ident).+) => {
        Section {
            head: SectionHead::new($name, $is_required, size_of::<$element>()),
            encode: |parts| Ok(cast_slice::<$element, u8>(&parts.$($field).+).into()),
            decode: |draft, body| {
                draft.parts.$($field).+ = body.array::<$element>()?;
                Ok(())
            },
        }
    };
}

macro_rules! sections {
    ($($(#[$doc:meta])* $constant:ident = $section:expr;)*) => {
        $($(#[$doc])* pub(crate) const $constant: Section = $section;)*
        /// All sections, in the order in which they are written: the order of use. A summary needs the first, a
        /// renderer without indirect light the first ten.
        pub(crate) static ALL: &[Section] = &[$($constant),*];
    };
}

const REQUIRED: bool = true;
const OPTIONAL: bool = false;

sections! {
    /// JSON: what [`crate::BakedInfo`] shows.
    INFO = Section {
        head: SectionHead::new("info", REQUIRED, 1),
        encode: |parts| Ok(serde_json::to_vec(&InfoSection::of(parts))?.into()),
        decode: |draft, body| {
            body.json::<InfoSection>()?.put_into(&mut draft.parts);
            Ok(())
        },
    };
    /// JSON: materials, lights, cameras, warnings, names of the textures.
    DESCRIPTION = Section {
        head: SectionHead::new("description", REQUIRED, 1),
        encode: |parts| Ok(serde_json::to_vec(&DescriptionSection::of(&parts.scene))?.into()),
        decode: |draft, body| {
            let scene = Arc::make_mut(&mut draft.parts.scene);
            draft.texture_names = body.json::<DescriptionSection>()?.put_into(scene);
            Ok(())
        },
    };
    /// The textures' PNG files, each behind its length.
    TEXTURES = Section {
        head: SectionHead::new("textures", REQUIRED, 1),
        encode: |parts| Ok(encode_textures(&parts.scene.textures).map_err(io::Error::other)?.into()),
        decode: |draft, body| {
            draft.pngs = body.array()?;
            Ok(())
        },
    };
    /// Of vertices.
    POSITIONS = array!("positions", REQUIRED, [Vec3], scene.positions);
    /// Of vertices.
    NORMALS = array!("normals", REQUIRED, [Vec3], scene.normals);
    /// Of vertices.
    TANGENTS = array!("tangents", REQUIRED, [Vec4], scene.tangents);
    /// Of vertices.
    UV0 = array!("uv0", REQUIRED, [Vec2], scene.uv0);
    /// Of vertices, or empty.
    UV1 = array!("uv1", REQUIRED, [Vec2], scene.uv1);
    /// Three vertices a triangle.
    TRIANGLES = array!("triangles", REQUIRED, [[u32; 3]], scene.triangles);
    /// Of triangles.
    MATERIALS = array!("materials", REQUIRED, [u32], scene.triangle_material);
    /// Lightmap faces.
    FACES = array!("faces", REQUIRED, [LightmapFace], lightmap.faces);
    /// Of triangles.
    BACK_FACES = array!("back-faces", REQUIRED, [u32], lightmap.back_faces);
    /// Texels and where their light is copied from.
    DILATION = array!("dilation", REQUIRED, [[u32; 2]], lightmap.dilation);
    /// Points whose light is evaluated.
    LIGHT_SAMPLES = array!("light-samples", REQUIRED, [LightSample], light_samples);
    /// Patches of samples.
    SURFELS = array!("surfels", REQUIRED, [Surfel], surfels);
    /// Patches of patches.
    SURFEL_GROUPS = array!("surfel-groups", REQUIRED, [SurfelGroup], surfel_groups);
    /// Emissive surfaces.
    EMITTERS = array!("emitters", REQUIRED, [Emitter], emitters);
    /// Places where radiance is measured.
    PROBES = array!("probes", REQUIRED, [Probe], probes);
    /// Directions of the relight rays.
    RELIGHT_DIRECTIONS = array!("ray-directions", REQUIRED, [Vec3], relight_directions);
    /// Of relight rays, probe by probe.
    RELIGHT_SURFELS = array!("ray-surfels", REQUIRED, [u32], relight_surfels);
    /// Of relight rays, probe by probe.
    RELIGHT_GAINS = array!("ray-gains", REQUIRED, [u8], relight_gains);
    /// 4³ vertices of the grid each.
    GRID_BLOCKS = array!("grid-blocks", REQUIRED, [GridBlock], grid_blocks);
    /// Vertices of the grid that have light.
    GRID_VERTICES = array!("grid-vertices", REQUIRED, [GridVertex], grid_vertices);
    /// Of vertices of the grid, row by row.
    GRID_RECEIVERS = array!("grid-receivers", REQUIRED, [u32], grid_receivers);
    /// 4³ cells of the grid each.
    GRID_CELL_BLOCKS = array!("grid-cell-blocks", OPTIONAL, [GridBlock], grid_cell_blocks);
    /// Cells of the grid that have walls.
    GRID_CELLS = array!("grid-cells", OPTIONAL, [GridCell], grid_cells);
    /// Walls between corners of cells.
    GRID_PLANES = array!("grid-planes", OPTIONAL, [Vec4], grid_planes);
    /// Groups of receivers.
    CLUSTERS = array!("clusters", REQUIRED, [Cluster], clusters);
    /// Cluster by cluster.
    CLUSTER_SIGNALS = array!("cluster-signals", REQUIRED, [u32], cluster_signals);
    /// Cluster by cluster.
    CLUSTER_PROBES = array!("cluster-probes", REQUIRED, [u32], cluster_probes);
    /// Of receivers.
    RECEIVER_TEXELS = array!("receiver-texels", REQUIRED, [u32], receiver_texels);
    /// Of receivers.
    RECEIVER_ERRORS = array!("receiver-errors", REQUIRED, [u8], receiver_errors);
    /// Words of U.
    RECEIVER_BASIS = array!("receiver-basis", REQUIRED, [u32], receiver_basis);
    /// Words of ΣVᵀ.
    SIGNAL_BASIS = array!("signal-basis", REQUIRED, [u32], signal_basis);
    /// Of rows of ΣVᵀ.
    ROW_SCALES = array!("row-scales", REQUIRED, [f32], row_scales);
    /// Of columns of ΣVᵀ.
    COLUMN_EXPONENTS = array!("column-exponents", REQUIRED, [u8], column_exponents);
    /// JSON: the objects of the input file; absent if the scene does not come from one.
    SOURCE_INSTANCES = Section {
        head: SectionHead::new("source-instances", OPTIONAL, 1),
        encode: |parts| match &parts.scene.sources.instances[..] {
            [] => Ok(Cow::default()),
            instances => Ok(serde_json::to_vec(instances)?.into()),
        },
        decode: |draft, body| {
            Arc::make_mut(&mut draft.parts.scene).sources.instances = body.json()?;
            Ok(())
        },
    };
    /// Of triangles: which triangle of which object each was, or is a piece of.
    SOURCE_TRIANGLES = array!("source-triangles", OPTIONAL, [SourceTriangle], scene.sources.triangles);
}
