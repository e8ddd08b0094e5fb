//! Reading files without holding up the window.

use std::future::Future;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::Context;
use probelight_asset::BakedScene;
use probelight_runtime::gpu::GpuDevice;
use probelight_scene::{AnimatedModel, Setup};

use super::live_scene::LiveScene;
use crate::platform::{self, File};

/// What a file turned out to be.
pub enum Loaded {
    /// A scene: its file, and what was repaired in it.
    Scene(PathBuf, Box<LiveScene>, Vec<String>),
    /// The scene of a bake, with its light.
    Baked(Box<LiveScene>),
    /// A setup.
    Setup(PathBuf, Box<Setup>),
    /// A model for objects.
    Model(PathBuf, Arc<AnimatedModel>),
    /// It cannot be used.
    Failed(String),
    /// The work was cancelled.
    Cancelled,
}

/// How a file is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// By its name: a setup (.json), a baked file (.plight), a scene.
    Open,
    /// A glTF file as an object.
    Object,
}

/// What is being read, and what has been.
#[derive(Debug)]
pub struct Loader {
    context: Context,
    sender: Sender<Loaded>,
    receiver: Receiver<Loaded>,
    /// Files that are being read.
    pub pending: usize,
}

impl Loader {
    /// Wakes up the window when something is there.
    pub fn new(context: &Context) -> Self {
        let (sender, receiver) = channel();
        Self { context: context.clone(), sender, receiver, pending: 0 }
    }

    /// Reads a file.
    pub fn read(&mut self, file: File, purpose: Purpose, gpu: &GpuDevice) {
        let gpu = gpu.clone();
        self.run(move || async move {
            let loaded = match purpose {
                Purpose::Open if is_setup(file.path()) => setup(&file).await,
                Purpose::Open => scene(&file, &gpu).await,
                Purpose::Object => object(&file).await,
            };
            loaded.unwrap_or_else(Loaded::Failed)
        });
    }

    /// Does some work in the background.
    pub fn run<F: Future<Output = Loaded> + 'static>(&mut self, work: impl FnOnce() -> F + Send + 'static) {
        self.pending += 1;
        let (sender, context) = (self.sender.clone(), self.context.clone());
        platform::spawn(move || async move {
            // Nobody listens if the window has closed.
            let _ = sender.send(work().await);
            context.request_repaint();
        });
    }

    /// What has been read since.
    pub fn take(&mut self) -> Option<Loaded> {
        let loaded = self.receiver.try_recv().ok()?;
        self.pending -= 1;
        Some(loaded)
    }
}

/// Whether a file name is that of a glTF scene.
pub fn is_scene(path: &Path) -> bool {
    has_extension(path, &["glb", "gltf"])
}

/// Whether a file name is that of a setup.
pub fn is_setup(path: &Path) -> bool {
    has_extension(path, &["json"])
}

fn has_extension(path: &Path, wanted: &[&str]) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    extension.is_some_and(|extension| wanted.contains(&extension.as_str()))
}

async fn setup(file: &File) -> Result<Loaded, String> {
    Ok(Loaded::Setup(file.path().into(), Box::new(file.setup().await?)))
}

async fn object(file: &File) -> Result<Loaded, String> {
    let named = |error| format!("the object {} cannot be used: {error}", file.path().display());
    let model = file.model().await.map_err(named)?;
    Ok(Loaded::Model(file.path().into(), Arc::new(model)))
}

async fn scene(file: &File, gpu: &GpuDevice) -> Result<Loaded, String> {
    let named = |error: &dyn std::error::Error| format!("{}: {error}", file.path().display());
    let is_baked = !is_scene(file.path());
    let baked = if is_baked {
        file.bake().await?
    } else {
        BakedScene::unbaked(Arc::new(file.scene().await?)).map_err(|error| named(&error))?
    };
    let warnings = baked.scene.warnings.iter().map(ToString::to_string).collect();
    let live = LiveScene::new(gpu, Arc::new(baked), is_baked).await.map_err(|error| named(&error))?;
    Ok(Loaded::Scene(file.path().into(), Box::new(live), warnings))
}
