//! The glTF file that was baked, loaded by Bevy's own loader and lit by what the bake made of it. Its objects stay those of the
//! file: C paints the one that is called "white".

use bevy::prelude::*;
use bevy_probelight::{Probelight, ProbelightAttach, ProbelightPlugin};

pub(crate) fn main() {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, ProbelightPlugin));
    add(&mut app);
    app.run();
}

pub(crate) fn add(app: &mut App) {
    app.insert_resource(ClearColor(Color::BLACK))
        .init_resource::<Paint>()
        .add_systems(Startup, setup)
        .add_systems(Update, (read_keys, paint).chain());
}

/// Whether the object is painted.
#[derive(Resource, Default)]
pub(crate) struct Paint(pub(crate) bool);

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        WorldAssetRoot(assets.load("cornell.glb#Scene0")),
        Probelight(assets.load("cornell.plight")),
        ProbelightAttach,
    ));
    commands.spawn((Camera3d::default(), Transform::from_xyz(2.8, 2.7, -6.2).looking_to(Vec3::Z, Vec3::Y)));
    let lamp = PointLight { intensity: 200_000.0, shadow_maps_enabled: true, ..default() };
    commands.spawn((lamp, Transform::from_xyz(1.0, 3.4, 1.6)));
}

fn read_keys(keys: Res<ButtonInput<KeyCode>>, mut paint: ResMut<Paint>) {
    if keys.just_pressed(KeyCode::KeyC) {
        paint.0 ^= true;
    }
}

/// Names are those of the file; each primitive of an object is a child of it.
fn paint(
    paint: Res<Paint>,
    objects: Query<(&Name, &Children)>,
    looks: Query<&MeshMaterial3d<StandardMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let wanted = Color::linear_rgb(0.725, 0.71, 0.68)
        .mix(&Color::linear_rgb(0.1, 0.25, 0.7), f32::from(u8::from(paint.0)));
    let primitives =
        objects.iter().filter(|(name, _)| name.as_str() == "white").flat_map(|(_, children)| children);
    for MeshMaterial3d(look) in primitives.filter_map(|primitive| looks.get(*primitive).ok()) {
        if materials.get(look).is_some_and(|look| look.base_color != wanted)
            && let Some(mut look) = materials.get_mut(look)
        {
            look.base_color = wanted;
        }
    }
}
