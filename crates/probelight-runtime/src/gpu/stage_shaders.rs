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
const CHANGE_SOURCES: &str = include_str!("../shaders/change_sources.wgsl");
const CLUSTER: &str = include_str!("../shaders/cluster.wgsl");
const CLUSTER_RECORD: &str = include_str!("../shaders/cluster_record.wgsl");
const CLUSTER_EXTENT: &str = include_str!("../shaders/cluster_extent.wgsl");
const CLUSTER_WISH: &str = include_str!("../shaders/cluster_wish.wgsl");
const DISPATCH: &str = include_str!("../shaders/dispatch.wgsl");
const FRAME_FLAGS: &str = include_str!("../shaders/frame_flags.wgsl");
const GATHER_TASK: &str = include_str!("../shaders/gather_task.wgsl");
const GROUPS: &str = include_str!("../shaders/group_surfels.wgsl");
const LIGHTMAP_TEXEL: &str = include_str!("../shaders/lightmap_texel.wgsl");
const PROBE_RECORD: &str = include_str!("../shaders/probe_record.wgsl");
const SIGNAL_SHAPE: &str = include_str!("../shaders/signal_shape.wgsl");
const UNPACK: &str = include_str!("../shaders/unpack.wgsl");
const WAITING: &str = include_str!("../shaders/waiting.wgsl");

/// What blends the borders between clusters.
const BORDERS: &[&str] =
    &[DISPATCH, CLUSTER_EXTENT, LIGHTMAP_TEXEL, include_str!("../shaders/blend_borders.wgsl")];

pub(super) const LIGHT_DIRECTLY: Shader = Shader {
    entry_point: "light_directly",
    parts: &[LIGHTS, SHADOW_MAPS, DISPATCH, include_str!("../shaders/light_directly.wgsl")],
};
pub(super) const SHADE_SURFELS: Shader = Shader {
    entry_point: "shade_surfels",
    parts: &[DISPATCH, BOUNCE, include_str!("../shaders/shade_surfels.wgsl")],
};
pub(super) const LIGHT_SURFELS: Shader = Shader {
    entry_point: "light_surfels",
    parts: &[DISPATCH, BOUNCE, CHANGE_SOURCES, include_str!("../shaders/light_surfels.wgsl")],
};
pub(super) const GROUP_LEVEL: Shader =
    Shader { entry_point: "group_level", parts: &[DISPATCH, FRAME_FLAGS, GROUPS] };
pub(super) const GROUP_LEVELS: Shader =
    Shader { entry_point: "group_levels", parts: &[DISPATCH, FRAME_FLAGS, GROUPS] };
pub(super) const RELIGHT_PROBES: Shader = Shader {
    entry_point: "relight_probes",
    parts: &[DISPATCH, SIGNAL_SHAPE, PROBE_RECORD, include_str!("../shaders/relight_probes.wgsl")],
};
pub(super) const PROJECT_CLUSTERS: Shader = Shader {
    entry_point: "project_clusters",
    parts: &[
        DISPATCH,
        CLUSTER_EXTENT,
        CLUSTER_RECORD,
        CLUSTER,
        UNPACK,
        include_str!("../shaders/project_clusters.wgsl"),
    ],
};
pub(super) const GATHER_RECEIVERS: Shader = Shader {
    entry_point: "gather_receivers",
    parts: &[
        DISPATCH,
        CLUSTER_EXTENT,
        CLUSTER_RECORD,
        CLUSTER,
        UNPACK,
        LIGHTMAP_TEXEL,
        GATHER_TASK,
        include_str!("../shaders/gather_receivers.wgsl"),
    ],
};
pub(super) const FILL_RECEIVERS: Shader = Shader {
    entry_point: "fill_receivers",
    parts: &[
        DISPATCH,
        CLUSTER_EXTENT,
        CLUSTER_RECORD,
        LIGHTMAP_TEXEL,
        GATHER_TASK,
        include_str!("../shaders/fill_receivers.wgsl"),
    ],
};
pub(super) const KEEP_UNBLENDED: Shader = Shader { entry_point: "keep_unblended", parts: BORDERS };
pub(super) const BLEND_BORDERS: Shader = Shader { entry_point: "blend_borders", parts: BORDERS };
pub(super) const DILATE_LIGHTMAP: Shader = Shader {
    entry_point: "dilate_lightmap",
    parts: &[DISPATCH, LIGHTMAP_TEXEL, include_str!("../shaders/dilate_lightmap.wgsl")],
};
pub(super) const REDUCE_LIGHTMAP: Shader = Shader {
    entry_point: "reduce_lightmap",
    parts: &[FRAME_FLAGS, include_str!("../shaders/reduce_lightmap.wgsl")],
};

// What lets things wait, in the order in which it runs: around stage 1, around stage 2, before and in stage 3.
pub(super) const FIND_DIRTY_BLOCKS: Shader = Shader {
    entry_point: "find_dirty_blocks",
    parts: &[
        DISPATCH,
        WAITING,
        FRAME_FLAGS,
        CHANGE_SOURCES,
        include_str!("../shaders/find_dirty_blocks.wgsl"),
    ],
};
pub(super) const MEASURE_SIGNALS: Shader = Shader {
    entry_point: "measure_signals",
    parts: &[DISPATCH, WAITING, FRAME_FLAGS, CHANGE_SOURCES, include_str!("../shaders/measure_signals.wgsl")],
};
pub(super) const CHOOSE_PROBES: Shader = Shader {
    entry_point: "choose_probes",
    parts: &[DISPATCH, WAITING, PROBE_RECORD, include_str!("../shaders/choose_probes.wgsl")],
};
pub(super) const MEASURE_BANDS: Shader = Shader {
    entry_point: "measure_bands",
    parts: &[DISPATCH, WAITING, PROBE_RECORD, include_str!("../shaders/measure_bands.wgsl")],
};
pub(super) const CHOOSE_CLUSTERS: Shader = Shader {
    entry_point: "choose_clusters",
    parts: &[
        DISPATCH,
        WAITING,
        CLUSTER_EXTENT,
        CLUSTER_WISH,
        include_str!("../shaders/choose_clusters.wgsl"),
    ],
};
pub(super) const ADMIT_CLUSTERS: Shader = Shader {
    entry_point: "admit_clusters",
    parts: &[DISPATCH, WAITING, CLUSTER_EXTENT, CLUSTER_WISH, include_str!("../shaders/admit_clusters.wgsl")],
};
pub(super) const TOUCH_CLUSTERS: Shader = Shader {
    entry_point: "touch_clusters",
    parts: &[FRAME_FLAGS, CLUSTER_EXTENT, include_str!("../shaders/touch_clusters.wgsl")],
};
pub(super) const NOTE_LIGHT: Shader = Shader {
    entry_point: "note_light",
    parts: &[DISPATCH, WAITING, CLUSTER_EXTENT, CLUSTER_RECORD, include_str!("../shaders/note_light.wgsl")],
};

/// Not a stage: what stages are compared with.
pub(super) const COPY_WORDS: Shader =
    Shader { entry_point: "copy_words", parts: &[DISPATCH, include_str!("../shaders/copy_words.wgsl")] };

/// All shaders of the stages, in the order in which they run, and [the yardstick](super::benchmark).
pub const STAGE_SHADERS: &[Shader] = &[
    LIGHT_DIRECTLY,
    SHADE_SURFELS,
    LIGHT_SURFELS,
    GROUP_LEVEL,
    GROUP_LEVELS,
    RELIGHT_PROBES,
    PROJECT_CLUSTERS,
    GATHER_RECEIVERS,
    FILL_RECEIVERS,
    KEEP_UNBLENDED,
    BLEND_BORDERS,
    DILATE_LIGHTMAP,
    REDUCE_LIGHTMAP,
    FIND_DIRTY_BLOCKS,
    MEASURE_SIGNALS,
    CHOOSE_PROBES,
    MEASURE_BANDS,
    CHOOSE_CLUSTERS,
    ADMIT_CLUSTERS,
    TOUCH_CLUSTERS,
    NOTE_LIGHT,
    COPY_WORDS,
];
