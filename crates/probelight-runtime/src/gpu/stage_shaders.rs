//! The stages' shaders and what they are joined from.

use super::shaders::{LIGHTS, SHADOW_MAPS};

/// A compute shader: files joined by concatenation, and the function to run.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Name of the function.
    pub entry_point: &'static str,
    parts: &'static [&'static str],
}

impl Shader {
    /// The files one after the other.
    pub fn source(&self) -> String {
        self.parts.concat()
    }
}

const BOUNCE: &str = include_str!("../shaders/bounce.wgsl");
const CLUSTER: &str = include_str!("../shaders/cluster.wgsl");
const CLUSTER_EXTENT: &str = include_str!("../shaders/cluster_extent.wgsl");
const DISPATCH: &str = include_str!("../shaders/dispatch.wgsl");
const GROUPS: &str = include_str!("../shaders/group_surfels.wgsl");
const LIGHTMAP_TEXEL: &str = include_str!("../shaders/lightmap_texel.wgsl");
const SIGNAL_SHAPE: &str = include_str!("../shaders/signal_shape.wgsl");
const UNPACK: &str = include_str!("../shaders/unpack.wgsl");

/// What blends the borders between clusters.
const BORDERS: &[&str] =
    &[DISPATCH, CLUSTER_EXTENT, LIGHTMAP_TEXEL, include_str!("../shaders/blend_borders.wgsl")];

pub(super) const LIGHT_SAMPLES: Shader = Shader {
    entry_point: "light_samples",
    parts: &[LIGHTS, SHADOW_MAPS, DISPATCH, include_str!("../shaders/light_samples.wgsl")],
};
pub(super) const SHADE_SURFELS: Shader = Shader {
    entry_point: "shade_surfels",
    parts: &[DISPATCH, BOUNCE, include_str!("../shaders/shade_surfels.wgsl")],
};
pub(super) const LIGHT_SURFELS: Shader = Shader {
    entry_point: "light_surfels",
    parts: &[DISPATCH, BOUNCE, include_str!("../shaders/light_surfels.wgsl")],
};
pub(super) const GROUP_LEVEL: Shader = Shader { entry_point: "group_level", parts: &[DISPATCH, GROUPS] };
pub(super) const GROUP_LEVELS: Shader = Shader { entry_point: "group_levels", parts: &[DISPATCH, GROUPS] };
pub(super) const RELIGHT_PROBES: Shader = Shader {
    entry_point: "relight_probes",
    parts: &[DISPATCH, SIGNAL_SHAPE, include_str!("../shaders/relight_probes.wgsl")],
};
pub(super) const PROJECT_CLUSTERS: Shader = Shader {
    entry_point: "project_clusters",
    parts: &[DISPATCH, CLUSTER_EXTENT, CLUSTER, UNPACK, include_str!("../shaders/project_clusters.wgsl")],
};
pub(super) const GATHER_RECEIVERS: Shader = Shader {
    entry_point: "gather_receivers",
    parts: &[
        DISPATCH,
        CLUSTER_EXTENT,
        CLUSTER,
        UNPACK,
        LIGHTMAP_TEXEL,
        include_str!("../shaders/gather_receivers.wgsl"),
    ],
};
pub(super) const BLEND_BORDERS: Shader = Shader { entry_point: "blend_borders", parts: BORDERS };
pub(super) const STORE_BLENDED: Shader = Shader { entry_point: "store_blended", parts: BORDERS };
pub(super) const DILATE_LIGHTMAP: Shader = Shader {
    entry_point: "dilate_lightmap",
    parts: &[DISPATCH, LIGHTMAP_TEXEL, include_str!("../shaders/dilate_lightmap.wgsl")],
};
pub(super) const REDUCE_LIGHTMAP: Shader =
    Shader { entry_point: "reduce_lightmap", parts: &[include_str!("../shaders/reduce_lightmap.wgsl")] };

/// Not a stage: what stages are compared with.
pub(super) const COPY_WORDS: Shader =
    Shader { entry_point: "copy_words", parts: &[DISPATCH, include_str!("../shaders/copy_words.wgsl")] };

/// All shaders of the stages, in the order in which they run, and [the yardstick](super::benchmark).
pub const STAGE_SHADERS: &[Shader] = &[
    LIGHT_SAMPLES,
    SHADE_SURFELS,
    LIGHT_SURFELS,
    GROUP_LEVEL,
    GROUP_LEVELS,
    RELIGHT_PROBES,
    PROJECT_CLUSTERS,
    GATHER_RECEIVERS,
    BLEND_BORDERS,
    STORE_BLENDED,
    DILATE_LIGHTMAP,
    REDUCE_LIGHTMAP,
    COPY_WORDS,
];
