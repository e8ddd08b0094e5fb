//! A character walks round between a red and a green wall. It is no part of the bake: its light comes from free space. The two balls
//! in front show the same light by themselves, one of them as metal.

use bevy::prelude::*;
use bevy_probelight::{Probelight, ProbelightMover, ProbelightPlugin, ProbelightShadowCaster};

pub(crate) fn main() {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, ProbelightPlugin));
    add(&mut app);
    app.run();
}

pub(crate) fn add(app: &mut App) {
    app.insert_resource(ClearColor(Color::BLACK))
        .init_resource::<Steps>()
        .add_systems(Startup, (setup, spawn_character))
        .add_systems(Update, walk);
}

/// How far the character has walked, turns.
#[derive(Resource, Default)]
pub(crate) struct Steps(pub(crate) f32);

#[derive(Component)]
struct Character;

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn(Probelight(assets.load("cornell.plight")));
    commands.spawn((Camera3d::default(), Transform::from_xyz(2.8, 2.4, -5.8).looking_to(Vec3::Z, Vec3::Y)));
    let lamp = PointLight { intensity: 150_000.0, shadow_maps_enabled: true, ..default() };
    commands.spawn((lamp, Transform::from_xyz(2.8, 4.9, 1.4)));
    let ball = meshes.add(Sphere::new(0.35));
    let surfaces = [(2.2, 0.0, 0.8), (3.4, 1.0, 0.35)];
    for (x, metallic, perceptual_roughness) in surfaces {
        let base_color = Color::linear_rgb(0.8, 0.8, 0.8);
        let material = StandardMaterial { base_color, metallic, perceptual_roughness, ..default() };
        let place = Transform::from_xyz(x, 0.35, -0.3);
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(materials.add(material)),
            place,
            ProbelightMover::default(),
        ));
    }
}

/// A capsule with a head and two feet.
fn spawn_character(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let cloth = materials.add(StandardMaterial {
        base_color: Color::linear_rgb(0.75, 0.72, 0.68),
        perceptual_roughness: 0.9,
        ..default()
    });
    let parts = [
        (meshes.add(Capsule3d::new(0.28, 0.6)), Vec3::new(0.0, 0.85, 0.0)),
        (meshes.add(Sphere::new(0.22)), Vec3::new(0.0, 1.6, 0.0)),
        (meshes.add(Capsule3d::new(0.1, 0.35)), Vec3::new(-0.15, 0.25, 0.0)),
        (meshes.add(Capsule3d::new(0.1, 0.35)), Vec3::new(0.15, 0.25, 0.0)),
    ];
    commands.spawn((Character, Transform::default(), Visibility::default())).with_children(|character| {
        for (mesh, place) in parts {
            let look = (Mesh3d(mesh), MeshMaterial3d(cloth.clone()), Transform::from_translation(place));
            character.spawn((look, ProbelightMover::default(), ProbelightShadowCaster));
        }
    });
}

/// Round the middle of the box, from wall to wall, twelve seconds a turn.
fn walk(time: Res<Time>, mut steps: ResMut<Steps>, mut character: Single<&mut Transform, With<Character>>) {
    steps.0 += time.delta_secs() / 12.0;
    let turn = steps.0 * std::f32::consts::TAU;
    let place = |turn: f32| Vec3::new(2.8 + 2.1 * turn.sin(), 0.0, 0.75 - 0.45 * turn.cos());
    let bob = 0.04 * (12.0 * turn).sin().abs();
    character.translation = place(turn) + Vec3::Y * bob;
    let ahead = (place(turn + 0.1) - place(turn)).normalize_or(Vec3::X);
    character.look_to(ahead, Vec3::Y);
}
