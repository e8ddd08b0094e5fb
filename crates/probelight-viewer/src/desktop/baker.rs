//! Baking without holding up the window.

use std::sync::Arc;

use eframe::egui::Context;
pub use probelight_bake::Quality;
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_runtime::gpu::GpuDevice;
use probelight_scene::Scene;
use probelight_trace::Progress;

use crate::scene::live_scene::LiveScene;
use crate::scene::loader::{Loaded, Loader};
use crate::scene::progress::BackgroundProgress;
use crate::state::view_state::BakeNumbers;
use crate::viewer::Viewer;

/// How scenes are baked when they are opened.
pub const FIRST_QUALITY: Option<Quality> = Some(Quality::Preview);

/// Qualities, and what one gets.
pub const QUALITIES: &[(Quality, &str, &str)] = &[
    (Quality::Preview, "preview", "coarse and grainy, in a fraction of the time"),
    (Quality::Medium, "medium", "the default"),
    (Quality::High, "high", "finer and with less noise, about four times the work"),
    (Quality::Production, "production", "for the last bake of all, about sixteen times the work"),
];

impl Viewer {
    /// Bakes the scene, unless that is going on.
    pub(crate) fn bake(&mut self, quality: Quality) {
        let Some(live) = self.live.as_ref().filter(|_| self.bake.is_none()) else { return };
        let BakeNumbers { receivers, gather_rays, error_percent, surfel_size, grid_vertices } =
            self.state.view.bake_numbers;
        let options = BakeOptions {
            quality: Some(quality),
            receivers,
            gather_rays,
            max_cluster_error: error_percent.map(|percent| 0.01 * percent),
            surfel_size,
            grid_vertices,
            ..BakeOptions::default()
        };
        self.bake = Some(start(live.scene(), options, &self.gpu, &mut self.loader, &self.context));
    }
}

/// Bakes a scene in a thread; the loader gets the result.
fn start(
    scene: &Arc<Scene>,
    options: BakeOptions,
    gpu: &GpuDevice,
    loader: &mut Loader,
    context: &Context,
) -> Arc<BackgroundProgress> {
    let progress = BackgroundProgress::new(context);
    let (watcher, scene, gpu) = (Arc::clone(&progress), Arc::clone(scene), gpu.clone());
    loader.run(move || async move {
        match bake(scene, &options, None, &*watcher) {
            Ok(baked) => {
                watcher.begin("uploading", 1);
                match LiveScene::new(&gpu, Arc::new(baked), true).await {
                    Ok(live) => Loaded::Baked(Box::new(live)),
                    Err(error) => Loaded::Failed(format!("the bake is done, but cannot be shown: {error}")),
                }
            }
            Err(BakeError::Cancelled) => Loaded::Cancelled,
            Err(error) => Loaded::Failed(format!("the scene cannot be baked: {error}")),
        }
    });
    progress
}
