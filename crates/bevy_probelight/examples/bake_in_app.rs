//! Bakes a glTF file while the app runs, and shows it when it is done. The title says how far it is.
//!
//! `cargo run --release -p bevy_probelight --example bake_in_app -- FILE.glb`; B bakes it (again), C cancels.

use std::path::PathBuf;

use bevy::prelude::*;
use bevy_probelight::probelight_bake::{BakeOptions, Quality};
use bevy_probelight::{BakeFinished, BakeProgress, BakeScene, Probelight, ProbelightPlugin};

pub(crate) fn main() {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, ProbelightPlugin));
    add(&mut app);
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenes/cornell.glb");
    let file = std::env::args_os().nth(1).map_or(PathBuf::from(bundled), PathBuf::from);
    let options = BakeOptions { quality: Some(Quality::Preview), ..BakeOptions::default() };
    app.insert_resource(Wanted { file, options });
    app.run();
}

pub(crate) fn add(app: &mut App) {
    app.insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, (setup, start).chain())
        .add_systems(Update, (read_keys, tell));
}

/// What to bake.
#[derive(Resource)]
pub(crate) struct Wanted {
    pub(crate) file: PathBuf,
    pub(crate) options: BakeOptions,
}

/// The entity that shows it.
#[derive(Component)]
pub(crate) struct Stage;

fn setup(mut commands: Commands) {
    commands.spawn((Stage, Transform::default(), Visibility::default()));
    commands.spawn((Camera3d::default(), Transform::from_xyz(2.8, 2.7, -6.2).looking_to(Vec3::Z, Vec3::Y)));
    let lamp = SpotLight { intensity: 600_000.0, outer_angle: 0.6, shadow_maps_enabled: true, ..default() };
    let place = Transform::from_xyz(2.8, 5.0, 1.0).looking_at(Vec3::new(5.0, 1.0, 3.0), Vec3::Y);
    commands.spawn((lamp, place));
}

fn start(mut commands: Commands, stage: Single<Entity, With<Stage>>, wanted: Res<Wanted>) {
    let bake = BakeScene::gltf(wanted.file.clone(), wanted.options.clone());
    commands.entity(*stage).remove::<Probelight>().insert(bake);
}

fn read_keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    stage: Single<Entity, With<Stage>>,
    wanted: Res<Wanted>,
) {
    if keys.just_pressed(KeyCode::KeyC) {
        commands.entity(*stage).remove::<BakeScene>();
    } else if keys.just_pressed(KeyCode::KeyB) {
        start(commands, stage, wanted);
    }
}

fn tell(
    mut progress: MessageReader<BakeProgress>,
    mut finished: MessageReader<BakeFinished>,
    mut windows: Query<&mut Window>,
) {
    let mut title = None;
    for BakeProgress { stage, done, total, .. } in progress.read() {
        title = Some(format!("{stage}: {done} of {total}"));
    }
    for BakeFinished { result, .. } in finished.read() {
        title = Some(match result {
            Ok(_) => "baked".to_owned(),
            Err(failure) => failure.to_string(),
        });
    }
    if let (Some(title), Ok(mut window)) = (title, windows.single_mut()) {
        window.title = title;
    }
}
