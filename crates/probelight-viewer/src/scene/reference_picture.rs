//! The path tracer's picture, which grows in the background while nothing changes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use probelight_math::glam::Vec3;
use probelight_runtime::SurfaceColors;
use probelight_scene::{Camera, Lighting, Object, Scene};
use probelight_trace::{PathTracer, Progress, Tracer};

use crate::platform;

/// The reference has this share of the picture's width and height, so that it grows faster; less where the window waits for
/// each pass.
const SCALE: f32 = if cfg!(target_arch = "wasm32") { 0.2 } else { 0.5 };

/// Paths per pixel after which it is good enough for eyes.
const MOST_PASSES: u32 = 4096;

/// What a picture shows: another one of these needs another picture.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Who looks.
    pub camera: Camera,
    /// All light.
    pub lighting: Lighting,
    /// Colours of all materials.
    pub materials: Vec<SurfaceColors>,
    /// What moves, where it is.
    pub objects: Vec<Object>,
}

impl Subject {
    /// Whether it looks the same.
    fn equals(&self, other: &Self) -> bool {
        let is_same =
            |(a, b): (&Object, &Object)| Arc::ptr_eq(a.model(), b.model()) && a.placement() == b.placement();
        self.camera == other.camera
            && self.lighting == other.lighting
            && self.materials == other.materials
            && self.objects.len() == other.objects.len()
            && self.objects.iter().zip(&other.objects).all(is_same)
    }
}

/// Paths so far.
#[derive(Clone, Debug, Default)]
pub struct Paths {
    /// Sum over the passes, W·m⁻²·sr⁻¹, rows from the top.
    pub sum: Vec<Vec3>,
    /// Paths per pixel.
    pub passes: u32,
    /// Pixels in a row.
    pub width: u32,
}

/// A picture that grows.
#[derive(Debug)]
pub struct ReferencePicture {
    subject: Subject,
    scene: Arc<Scene>,
    paths: Arc<Mutex<Paths>>,
    stop: Arc<AtomicBool>,
}

/// Stops within a pass.
struct Stop(Arc<AtomicBool>);

impl Progress for Stop {
    fn begin(&self, _stage: &str, _total: u64) {}

    fn advance(&self, _steps: u64) {}

    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl ReferencePicture {
    /// Begins a picture of a scene.
    pub fn start(scene: &Arc<Scene>, subject: Subject, context: &Context) -> Self {
        let paths = Arc::new(Mutex::new(Paths::default()));
        let stop = Arc::new(AtomicBool::new(false));
        let picture = Self {
            subject: subject.clone(),
            scene: Arc::clone(scene),
            paths: Arc::clone(&paths),
            stop: Arc::clone(&stop),
        };
        let (scene, context) = (Arc::clone(scene), context.clone());
        platform::spawn(move || grow(scene, subject, paths, Stop(stop), context));
        picture
    }

    /// Whether it is a picture of this.
    pub fn shows(&self, scene: &Arc<Scene>, subject: &Subject) -> bool {
        Arc::ptr_eq(&self.scene, scene) && self.subject.equals(subject)
    }

    /// Paths per pixel so far.
    pub fn passes(&self) -> u32 {
        self.paths.lock().unwrap_or_else(PoisonError::into_inner).passes
    }

    /// Width, and the mean of the paths so far, rows from the top; `None` as long as there is nothing.
    pub fn mean(&self) -> Option<(u32, Vec<Vec3>)> {
        let paths = self.paths.lock().unwrap_or_else(PoisonError::into_inner);
        let scale = 1.0 / paths.passes as f32;
        (paths.passes > 0).then(|| (paths.width, paths.sum.iter().map(|sum| *sum * scale).collect()))
    }
}

impl Drop for ReferencePicture {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

async fn grow(scene: Arc<Scene>, subject: Subject, paths: Arc<Mutex<Paths>>, stop: Stop, context: Context) {
    platform::breathe().await;
    let tracer = Tracer::new(Arc::new(colored(&scene, &subject.materials).with_objects(&subject.objects)));
    let path_tracer = PathTracer::new(Arc::new(tracer), subject.lighting.clone());
    let side = |pixels: u32| ((pixels as f32 * SCALE) as u32).max(1);
    let camera = Camera {
        width: side(subject.camera.width),
        height: side(subject.camera.height),
        ..subject.camera.clone()
    };
    for pass in 0..MOST_PASSES {
        let Ok(picture) = path_tracer.render(&camera, 1, u64::from(pass), &stop) else { return };
        add(&mut paths.lock().unwrap_or_else(PoisonError::into_inner), camera.width, picture);
        context.request_repaint();
        platform::breathe().await;
    }
}

/// Adds a pass.
fn add(paths: &mut Paths, width: u32, picture: Vec<Vec3>) {
    paths.width = width;
    paths.sum.resize(picture.len(), Vec3::ZERO);
    paths.sum.iter_mut().zip(picture).for_each(|(sum, radiance)| *sum += radiance);
    paths.passes += 1;
}

/// A scene with other colours.
pub fn colored(scene: &Scene, colors: &[SurfaceColors]) -> Scene {
    let mut colored = scene.clone();
    for (material, colors) in colored.materials.iter_mut().zip(colors) {
        material.base_color = colors.base_color.extend(material.base_color.w);
        material.emission = colors.emission;
    }
    colored
}
