//! The stages of a frame by name.

use std::ops::{Index, IndexMut};
use std::time::Duration;

/// The one list of the stages: what each does, what it is called.
macro_rules! stages {
    ($($(#[$documentation:meta])* $stage:ident = $name:literal,)*) => {
        /// A stage of a frame, in the order in which they run.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Stage { $($(#[$documentation])* $stage,)* }

        impl Stage {
            /// All of them, in order.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$stage),*];

            /// Its name, that of its file on both sides.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$stage => $name,)* }
            }
        }
    };
}

stages! {
    /// Scalar signals: radiance of surfels and groups. Direct light and shading only if something changed.
    LightSurfels = "light_surfels",
    /// The probes' coefficients.
    RelightProbes = "relight_probes",
    /// The clusters' coefficients.
    ProjectClusters = "project_clusters",
    /// Irradiance of the receivers.
    GatherReceivers = "gather_receivers",
    /// Texels around the charts.
    DilateLightmap = "dilate_lightmap",
    /// Coarser levels of the lightmap; on the GPU only: the CPU's renderer takes several samples per pixel instead.
    ReduceLightmap = "reduce_lightmap",
}

impl Stage {
    /// Whether the CPU has it.
    pub fn is_on_cpu(self) -> bool {
        self != Self::ReduceLightmap
    }
}

/// A value for each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerStage<T>([T; Stage::ALL.len()]);

impl<T> PerStage<T> {
    /// What `value` says of each.
    pub fn from_fn(value: impl FnMut(Stage) -> T) -> Self {
        Self(Stage::ALL.map(value))
    }

    /// In the order in which they run.
    pub fn values(&self) -> &[T; Stage::ALL.len()] {
        &self.0
    }
}

impl<T> Index<Stage> for PerStage<T> {
    type Output = T;

    fn index(&self, stage: Stage) -> &T {
        &self.0[stage as usize]
    }
}

impl<T> IndexMut<Stage> for PerStage<T> {
    fn index_mut(&mut self, stage: Stage) -> &mut T {
        &mut self.0[stage as usize]
    }
}

/// How long the stages of a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimings {
    /// Each of them; zero for those that did not run.
    pub stages: PerStage<Duration>,
    /// All of them, from the beginning of the first to the end of the last. On a GPU without drawing shadow maps.
    pub frame: Duration,
}
