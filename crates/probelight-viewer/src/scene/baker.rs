//! Baking without holding up the window.

use std::sync::Arc;

use eframe::egui::Context;
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_runtime::gpu::GpuDevice;
use probelight_scene::Scene;
use probelight_trace::Progress;

use super::live_scene::LiveScene;
use super::loader::{Loaded, Loader};
use super::progress::BackgroundProgress;

/// A bake that is going on.
#[derive(Debug)]
pub struct RunningBake {
    /// Where it stands.
    pub progress: Arc<BackgroundProgress>,
}

impl RunningBake {
    /// Bakes a scene in a thread; the loader gets the result.
    pub fn start(
        scene: &Arc<Scene>,
        options: BakeOptions,
        gpu: &GpuDevice,
        loader: &mut Loader,
        context: &Context,
    ) -> Self {
        let progress = BackgroundProgress::new(context);
        let (watcher, scene, gpu) = (Arc::clone(&progress), Arc::clone(scene), gpu.clone());
        loader.run(move || match bake(scene, &options, None, &*watcher) {
            Ok(baked) => {
                watcher.begin("uploading", 1);
                match LiveScene::new(&gpu, Arc::new(baked), true) {
                    Ok(live) => Loaded::Baked(Box::new(live)),
                    Err(error) => Loaded::Failed(format!("the bake is done, but cannot be shown: {error}")),
                }
            }
            Err(BakeError::Cancelled) => Loaded::Cancelled,
            Err(error) => Loaded::Failed(format!("the scene cannot be baked: {error}")),
        });
        Self { progress }
    }
}
