//! What frames compute of what there is, asked without stopping the GPU.

use probelight_runtime::gpu::GpuError;
use probelight_runtime::{FramePlan, Workload};

use super::live_scene::LiveScene;
use super::pending::{Pending, take_ready};

/// Of a scene's frames.
#[derive(Default)]
pub struct FrameWork {
    /// What the last frame did of which this is known.
    pub done: Workload,
    /// All there is to do.
    pub all: Workload,
    /// How many clusters there are.
    pub clusters: usize,
    answer: Option<Pending<Result<Workload, GpuError>>>,
}

impl FrameWork {
    /// Of a scene that was not lit yet.
    pub fn new(live: &LiveScene) -> Self {
        let full = FramePlan::full(&live.baked);
        let all = Workload {
            receivers: full.receivers(),
            matrix_bytes: full.matrix_bytes(&live.baked),
            pending_clusters: 0,
        };
        Self { all, clusters: live.baked.clusters.len(), ..Self::default() }
    }

    /// Asks what the present frame does, unless an answer is on its way.
    pub fn ask(&mut self, live: &LiveScene) {
        if self.answer.is_none() {
            self.answer = Some(Pending::new(live.runtime.read_workload_async()));
        }
    }

    /// Takes an answer that has come.
    pub fn update(&mut self) {
        if let Some(Ok(done)) = take_ready(&mut self.answer) {
            self.done = done;
        }
    }

    /// Whether an answer is on its way.
    pub fn is_asking(&self) -> bool {
        self.answer.is_some()
    }
}
