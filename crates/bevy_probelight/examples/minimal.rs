//! A baked scene under a lamp of Bevy's, in fifteen lines.

use bevy::prelude::*;
use bevy_probelight::{Probelight, ProbelightPlugin};

pub(crate) fn main() {
    App::new().add_plugins((DefaultPlugins, ProbelightPlugin)).add_systems(Startup, setup).run();
}

pub(crate) fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn(Probelight(assets.load("cornell.plight")));
    commands.spawn((Camera3d::default(), Transform::from_xyz(2.8, 2.7, -6.2).looking_to(Vec3::Z, Vec3::Y)));
    let lamp = PointLight { intensity: 200_000.0, shadow_maps_enabled: true, ..default() };
    commands.spawn((lamp, Transform::from_xyz(1.0, 3.4, 1.6)));
}
