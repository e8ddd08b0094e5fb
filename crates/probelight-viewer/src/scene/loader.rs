//! Reading files without holding up the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::Context;
use probelight_asset::BakedScene;
use probelight_runtime::gpu::GpuDevice;
use probelight_scene::{AnimatedModel, Scene, Setup, load_animated_gltf, load_gltf};

use super::live_scene::LiveScene;

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

/// Threads that read, and what they read.
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
    pub fn read(&mut self, path: PathBuf, purpose: Purpose, gpu: &GpuDevice) {
        let gpu = gpu.clone();
        self.run(move || match purpose {
            Purpose::Open => open(&path, &gpu),
            Purpose::Object => match load_animated_gltf(&path) {
                Ok(model) => Loaded::Model(path, Arc::new(model)),
                Err(error) => {
                    Loaded::Failed(format!("the object {} cannot be used: {error}", path.display()))
                }
            },
        });
    }

    /// Does some work in a thread of its own.
    pub fn run(&mut self, work: impl FnOnce() -> Loaded + Send + 'static) {
        self.pending += 1;
        let (sender, context) = (self.sender.clone(), self.context.clone());
        std::thread::spawn(move || {
            // Nobody listens if the window has closed.
            let _ = sender.send(work());
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

fn open(path: &Path, gpu: &GpuDevice) -> Loaded {
    if is_setup(path) {
        return match Setup::load(path) {
            Ok(setup) => Loaded::Setup(path.into(), Box::new(setup)),
            Err(error) => Loaded::Failed(error.to_string()),
        };
    }
    match read_scene(path) {
        Ok((baked, is_baked)) => {
            let warnings = baked.scene.warnings.iter().map(ToString::to_string).collect();
            match LiveScene::new(gpu, Arc::new(baked), is_baked) {
                Ok(live) => Loaded::Scene(path.into(), Box::new(live), warnings),
                Err(error) => Loaded::Failed(format!("{}: {error}", path.display())),
            }
        }
        Err(reason) => Loaded::Failed(reason),
    }
}

fn read_scene(path: &Path) -> Result<(BakedScene, bool), String> {
    if !is_scene(path) {
        return BakedScene::read(path).map(|baked| (baked, true)).map_err(|error| error.to_string());
    }
    let scene: Scene = load_gltf(path).map_err(|error| error.to_string())?;
    let unbaked = BakedScene::unbaked(Arc::new(scene));
    unbaked.map(|baked| (baked, false)).map_err(|error| format!("{}: {error}", path.display()))
}
