//! The sun goes round, and at night a lamp is on: the panel in the ceiling is an emissive surface of the scene.
//!
//! Space holds the sun, L switches the lamp by hand.

use std::f32::consts::TAU;

use bevy::prelude::*;
use bevy_probelight::{Probelight, ProbelightPlugin, ProbelightScene, ProbelightSky};

pub(crate) fn main() {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, ProbelightPlugin));
    add(&mut app);
    app.run();
}

pub(crate) fn add(app: &mut App) {
    app.init_resource::<Clock>()
        .init_resource::<Switch>()
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, setup)
        .add_systems(Update, (read_keys, pass_time, move_sun, switch_lamp).chain());
}

/// Hours since midnight.
#[derive(Resource)]
pub(crate) struct Clock {
    pub(crate) hour: f32,
    pub(crate) is_held: bool,
}

impl Default for Clock {
    fn default() -> Self {
        Self { hour: 9.0, is_held: false }
    }
}

/// Whether somebody turned the lamp's automatic switch round.
#[derive(Resource, Default)]
struct Switch(bool);

/// At noon, lux.
const SUN: f32 = 3_500.0;

/// Of the lamp, cd/m².
const LAMP: LinearRgba = LinearRgba::rgb(24_000.0, 16_500.0, 9_000.0);

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn(Probelight(assets.load("cornell.plight")));
    commands.spawn((Camera3d::default(), Transform::from_xyz(2.8, 2.7, -6.2).looking_to(Vec3::Z, Vec3::Y)));
    commands.spawn(DirectionalLight { shadow_maps_enabled: true, ..default() });
}

fn read_keys(keys: Res<ButtonInput<KeyCode>>, mut clock: ResMut<Clock>, mut switch: ResMut<Switch>) {
    if keys.just_pressed(KeyCode::Space) {
        clock.is_held ^= true;
    }
    if keys.just_pressed(KeyCode::KeyL) {
        switch.0 ^= true;
    }
}

/// A day takes half a minute.
fn pass_time(time: Res<Time>, mut clock: ResMut<Clock>) {
    if !clock.is_held {
        clock.hour = (clock.hour + 0.8 * time.delta_secs()) % 24.0;
    }
}

/// How high the sun is: the sine of its elevation.
fn height(hour: f32) -> f32 {
    -(hour / 24.0 * TAU).cos()
}

fn move_sun(
    clock: Res<Clock>,
    mut sun: Single<(&mut DirectionalLight, &mut Transform)>,
    mut sky: ResMut<ProbelightSky>,
) {
    let (light, transform) = &mut *sun;
    let height = height(clock.hour);
    // It rises at the left and sets at the right, in front of the open side of the box.
    let side = (clock.hour / 24.0 * TAU).sin();
    let from = Vec3::new(1.2 * side, 0.9 * height, -1.0);
    transform.look_to(-from, Vec3::Y);
    let day = smoothstep(-0.05, 0.4, height);
    light.illuminance = SUN * day;
    light.color = Color::linear_rgb(1.0, 0.45 + 0.5 * day, 0.2 + 0.65 * day);
    let blue = Vec3::new(0.35, 0.55, 1.0);
    let dusk = Vec3::new(1.0, 0.5, 0.25);
    *sky = ProbelightSky::Gradient {
        zenith: 3.0 * blue + 700.0 * day * blue,
        horizon: 3.0 * blue + 900.0 * day * dusk.lerp(blue, day),
        ground: 150.0 * day * Vec3::ONE,
    };
}

fn smoothstep(from: f32, to: f32, at: f32) -> f32 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn switch_lamp(
    clock: Res<Clock>,
    switch: Res<Switch>,
    scene: Single<&Probelight>,
    scenes: Res<Assets<ProbelightScene>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Some(scene) = scenes.get(&scene.0) else { return };
    let is_lamp = |index: &usize| scene.baked.scene.materials[*index].name == "light";
    let Some(lamp) = (0..scene.materials.len()).find(is_lamp) else { return };
    let is_on = (height(clock.hour) < 0.1) != switch.0;
    let emissive = if is_on { LAMP } else { LinearRgba::BLACK };
    // Only what differs is written: a material that was touched is uploaded again.
    if materials.get(&scene.materials[lamp]).is_some_and(|material| material.emissive != emissive)
        && let Some(mut material) = materials.get_mut(&scene.materials[lamp])
    {
        material.emissive = emissive;
    }
}
