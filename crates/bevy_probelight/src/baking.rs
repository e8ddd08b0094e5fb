//! Baking a scene while the app runs.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use bevy::app::{App, Update};
use bevy::asset::{Assets, Handle};
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::mesh::Mesh;
use bevy::pbr::StandardMaterial;
use probelight_asset::BakedScene;
use probelight_bake::{BakeError, BakeOptions, bake};
use probelight_scene::{Scene, SceneError, load_gltf};
use probelight_trace::Progress;

use crate::instance::Probelight;
use crate::plugin::ProbelightSystems;
use crate::scene::ProbelightScene;

/// Bakes a scene in the background. When it is done, the entity gets a [`Probelight`] that shows it, in place of this.
///
/// Remove the component, or despawn the entity, to cancel the bake. [`BakeProgress`] and [`BakeFinished`] tell how it goes. The bake
/// uses all cores.
#[derive(Component, Clone, Debug)]
pub struct BakeScene {
    source: Source,
    options: BakeOptions,
}

#[derive(Clone, Debug)]
enum Source {
    Gltf(PathBuf),
    Scene(Arc<Scene>),
}

impl BakeScene {
    /// A glTF 2.0 file (`.glb`, `.gltf`), by its path in the file system.
    pub fn gltf(path: impl Into<PathBuf>, options: BakeOptions) -> Self {
        Self { source: Source::Gltf(path.into()), options }
    }

    /// A scene that is already there.
    pub fn scene(scene: Arc<Scene>, options: BakeOptions) -> Self {
        Self { source: Source::Scene(scene), options }
    }

    fn run(&self, watch: &Watch) -> Result<BakedScene, BakeFailure> {
        let scene = match &self.source {
            Source::Gltf(path) => Arc::new(load_gltf(path)?),
            Source::Scene(scene) => Arc::clone(scene),
        };
        scene.validate()?;
        Ok(bake(scene, &self.options, None, watch)?)
    }
}

/// How far a bake is; sent in frames in which it got further.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct BakeProgress {
    /// The entity with the [`BakeScene`].
    pub entity: Entity,
    /// What is being done.
    pub stage: String,
    /// Steps of the stage that are done.
    pub done: u64,
    /// Steps of the stage.
    pub total: u64,
}

/// A bake ended by itself; cancelled ones send nothing.
#[derive(Message, Clone, Debug)]
pub struct BakeFinished {
    /// The entity that had the [`BakeScene`].
    pub entity: Entity,
    /// The scene, which the entity shows now, or why there is none.
    pub result: Result<Handle<ProbelightScene>, Arc<BakeFailure>>,
}

/// Why a scene was not baked.
#[derive(Debug, thiserror::Error)]
pub enum BakeFailure {
    /// The file cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The bake failed.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The system has no thread for it.
    #[error("a bake needs a thread of its own: {0}")]
    Thread(#[from] std::io::Error),
    /// The bake ended by a bug.
    #[error("the bake broke off")]
    BrokeOff,
}

/// What a bake's threads and the app tell each other.
#[derive(Debug, Default)]
struct Watch {
    stage: Mutex<(String, u64)>,
    done: AtomicU64,
    is_cancelled: AtomicBool,
}

impl Progress for Watch {
    fn begin(&self, stage: &str, total: u64) {
        let mut current = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        *current = (stage.to_owned(), total);
        self.done.store(0, Ordering::Relaxed);
    }

    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

impl Watch {
    fn progress(&self, entity: Entity) -> BakeProgress {
        let (stage, total) = self.stage.lock().unwrap_or_else(PoisonError::into_inner).clone();
        BakeProgress { entity, stage, done: self.done.load(Ordering::Relaxed), total }
    }
}

/// A bake at work; dropping it ends it.
#[derive(Component)]
struct RunningBake {
    watch: Arc<Watch>,
    /// Until it was joined. Bevy's own pools are not used: they would have no thread left to compile pipelines with.
    thread: Result<Option<JoinHandle<Result<BakedScene, BakeFailure>>>, std::io::Error>,
    told: Option<BakeProgress>,
}

impl RunningBake {
    /// What came of it, as soon as it is done.
    fn take_result(&mut self) -> Option<Result<BakedScene, BakeFailure>> {
        let thread = match std::mem::replace(&mut self.thread, Ok(None)) {
            Ok(thread) => thread?,
            Err(error) => return Some(Err(error.into())),
        };
        if thread.is_finished() {
            return Some(thread.join().unwrap_or(Err(BakeFailure::BrokeOff)));
        }
        self.thread = Ok(Some(thread));
        None
    }
}

impl Drop for RunningBake {
    fn drop(&mut self) {
        self.watch.is_cancelled.store(true, Ordering::Relaxed);
    }
}

pub(crate) fn add(app: &mut App) {
    app.add_message::<BakeProgress>()
        .add_message::<BakeFinished>()
        .add_systems(Update, (start_bakes, stop_bakes, watch_bakes).chain().before(ProbelightSystems::Spawn));
}

fn start_bakes(mut commands: Commands, wanted: Query<(Entity, &BakeScene), Without<RunningBake>>) {
    for (entity, wanted) in &wanted {
        let (wanted, watch) = (wanted.clone(), Arc::new(Watch::default()));
        let on_the_way = Arc::clone(&watch);
        let thread = thread::Builder::new().name("bake".into()).spawn(move || wanted.run(&on_the_way));
        commands.entity(entity).insert(RunningBake { watch, thread: thread.map(Some), told: None });
    }
}

fn stop_bakes(mut commands: Commands, left: Query<Entity, (With<RunningBake>, Without<BakeScene>)>) {
    for entity in &left {
        commands.entity(entity).remove::<RunningBake>();
    }
}

/// Where a finished scene goes.
#[derive(bevy::ecs::system::SystemParam)]
struct Shelf<'w> {
    scenes: ResMut<'w, Assets<ProbelightScene>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    images: ResMut<'w, Assets<Image>>,
}

impl Shelf<'_> {
    fn add(&mut self, baked: BakedScene) -> Handle<ProbelightScene> {
        let Self { scenes, meshes, materials, images } = self;
        scenes.add(ProbelightScene::new(Arc::new(baked), meshes, materials, images))
    }
}

fn watch_bakes(
    mut commands: Commands,
    mut running: Query<(Entity, &mut RunningBake), With<BakeScene>>,
    mut shelf: Shelf,
    mut progress: MessageWriter<BakeProgress>,
    mut finished: MessageWriter<BakeFinished>,
) {
    for (entity, mut running) in &mut running {
        let now = running.watch.progress(entity);
        if running.told.as_ref() != Some(&now) && !now.stage.is_empty() {
            progress.write(now.clone());
            running.told = Some(now);
        }
        let Some(result) = running.take_result() else { continue };
        let result = result.map(|baked| shelf.add(baked)).map_err(Arc::new);
        let mut entity_commands = commands.entity(entity);
        entity_commands.remove::<(BakeScene, RunningBake)>();
        if let Ok(scene) = &result {
            entity_commands.insert(Probelight(scene.clone()));
        }
        finished.write(BakeFinished { entity, result });
    }
}
