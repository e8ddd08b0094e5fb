//! Scenes that Bevy's own glTF loader spawned, lit by the baked file.

mod support;

use bevy::gltf::GltfAssetLabel;
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy_probelight::probelight_asset::BakedScene;
use bevy_probelight::{Probelight, ProbelightAttach, ProbelightInstance, ProbelightSky};
use support::truth::relative_error;
use support::{
    cornell, has_gpu, headless_app, headless_app_in, read_image, settle, spawn_camera, spawn_scene,
};

const LAMP: Vec3 = Vec3::new(1.0, 3.4, 1.6);

fn spawn_lamp(app: &mut App, position: Vec3) -> Entity {
    let light = PointLight { intensity: 1000.0, ..default() };
    app.world_mut().spawn((light, Transform::from_translation(position))).id()
}

fn camera() -> Transform {
    Transform::from_xyz(2.78, 2.73, -6.2).looking_at(Vec3::new(2.78, 2.73, 0.0), Vec3::Y)
}

/// An app with a lamp, a sky and a camera; its picture.
fn app() -> (App, Handle<Image>, Entity) {
    let mut app = headless_app();
    let (image, lamp) = furnish(&mut app, camera(), LAMP);
    (app, image, lamp)
}

fn furnish(app: &mut App, camera: Transform, lamp: Vec3) -> (Handle<Image>, Entity) {
    app.insert_resource(ProbelightSky::Uniform(Vec3::new(0.2, 0.4, 0.8)));
    (spawn_camera(app, camera), spawn_lamp(app, lamp))
}

/// Lets Bevy spawn the glTF file under an entity; returns it.
fn spawn_gltf(app: &mut App, transform: Transform) -> Entity {
    spawn_file(app, "cornell.glb", transform)
}

fn spawn_file(app: &mut App, file: &str, transform: Transform) -> Entity {
    let label = GltfAssetLabel::Scene(0).from_asset(file.to_owned());
    let scene = app.world().resource::<AssetServer>().load(label);
    let root = app.world_mut().spawn((WorldAssetRoot(scene), transform)).id();
    for _ in 0..20_000 {
        app.update();
        if !meshes_below(app, root).is_empty() {
            return root;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    panic!("Bevy never spawns the file");
}

/// The entities with meshes below one.
fn meshes_below(app: &mut App, root: Entity) -> Vec<Entity> {
    let mut children = app.world_mut().query::<&Children>();
    let world = app.world();
    let below = children.query(world).iter_descendants(root).collect::<Vec<_>>();
    below.into_iter().filter(|entity| world.get::<Mesh3d>(*entity).is_some()).collect()
}

/// The mesh of a node of the file.
fn mesh_of(app: &mut App, root: Entity, node: &str) -> Entity {
    let meshes = meshes_below(app, root);
    let is_it = |entity: &Entity| {
        let parent = app.world().get::<ChildOf>(*entity).unwrap().parent();
        app.world().get::<Name>(parent).is_some_and(|name| name.as_str() == node)
    };
    meshes.into_iter().find(is_it).unwrap()
}

/// Lights what is below an entity, until light stands still.
fn attach(app: &mut App, root: Entity) {
    attach_file(app, root, "cornell.plight");
}

fn attach_file(app: &mut App, root: Entity, file: &str) {
    let scene = app.world().resource::<AssetServer>().load(file.to_owned());
    app.world_mut().entity_mut(root).insert((Probelight(scene), ProbelightAttach));
    for _ in 0..2000 {
        app.update();
        if app.world().get::<ProbelightInstance>(root).is_some() {
            return settle(app, root);
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    panic!("the baked file is never there");
}

fn instance(app: &App, root: Entity) -> &ProbelightInstance {
    app.world().get(root).expect("it is shown")
}

/// Takes gloss from what is below an entity, and lets emission count as in baked scenes.
fn make_like_baked(app: &mut App, root: Entity) {
    for entity in meshes_below(app, root) {
        let material = app.world().get::<MeshMaterial3d<StandardMaterial>>(entity).unwrap().0.clone();
        let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
        let mut material = materials.get_mut(&material).unwrap();
        (material.reflectance, material.perceptual_roughness) = (0.0, 1.0);
        material.emissive_exposure_weight = 1.0;
    }
}

/// Draws what is there now.
fn draw(app: &mut App, image: &Handle<Image>) -> Vec<Vec3> {
    app.update();
    app.update();
    read_image(app, image)
}

fn difference(found: &[Vec3], wanted: &[Vec3]) -> f32 {
    relative_error(&found.iter().copied().zip(wanted.iter().copied()).collect::<Vec<_>>())
}

#[test]
fn a_file_loaded_by_bevy_looks_as_the_baked_one() {
    if !has_gpu() {
        return;
    }
    let place = Transform::from_xyz(0.3, -0.2, 0.5).with_rotation(Quat::from_rotation_y(0.1));
    let (mut app_of_baked, image, _) = app();
    let shown = spawn_scene(&mut app_of_baked, cornell(), place);
    support::make_diffuse(&mut app_of_baked, shown);
    settle(&mut app_of_baked, shown);
    let wanted = draw(&mut app_of_baked, &image);

    let (mut app, image, lamp) = app();
    let root = spawn_gltf(&mut app, place);
    make_like_baked(&mut app, root);
    let own = meshes_below(&mut app, root).map_meshes(&app);
    let unlit = draw(&mut app, &image);
    attach(&mut app, root);
    let found = draw(&mut app, &image);
    let [same, without] = [&found, &unlit].map(|picture| difference(picture, &wanted));
    assert!(same < 0.01, "loaded by Bevy it differs by {same}");
    assert!(without > 0.05, "the light of the bake is not seen: {without}");
    assert_eq!(instance(&app, root).parts().len(), 4);
    assert!(instance(&app, root).unmatched().is_empty());

    // Under another lamp the comparison must fail.
    app.world_mut().get_mut::<Transform>(lamp).unwrap().translation.x += 2.0;
    settle(&mut app, root);
    let moved = difference(&draw(&mut app, &image), &wanted);
    assert!(moved > 0.05, "another lamp is not seen: {moved}");
    app.world_mut().get_mut::<Transform>(lamp).unwrap().translation = LAMP;

    // Without the scene everything is as it was, and with it as it was with it.
    app.world_mut().entity_mut(root).remove::<(Probelight, ProbelightAttach)>();
    let back = draw(&mut app, &image);
    assert!(difference(&back, &unlit) < 1e-3, "something stays");
    assert_eq!(meshes_below(&mut app, root).map_meshes(&app), own);
    assert!(own.iter().all(|(entity, _)| app.world().get::<Lightmap>(*entity).is_none()));
    attach(&mut app, root);
    let again = difference(&draw(&mut app, &image), &wanted);
    assert!(again < 0.01, "the second time it differs by {again}");

    // Both go together, and so do both again.
    app.world_mut().despawn(root);
    assert!(draw(&mut app, &image).iter().all(|texel| *texel == Vec3::ZERO), "it is still drawn");
    assert_eq!(support::frames_of(&app, root), None, "its runtime stays");
    let root = spawn_gltf(&mut app, place);
    make_like_baked(&mut app, root);
    attach(&mut app, root);
    let reloaded = difference(&draw(&mut app, &image), &wanted);
    assert!(reloaded < 0.01, "loaded again it differs by {reloaded}");
}

/// The handles of entities' meshes.
trait Meshes {
    fn map_meshes(self, app: &App) -> Vec<(Entity, Handle<Mesh>)>;
}

impl Meshes for Vec<Entity> {
    fn map_meshes(self, app: &App) -> Vec<(Entity, Handle<Mesh>)> {
        self.into_iter()
            .map(|entity| (entity, app.world().get::<Mesh3d>(entity).unwrap().0.clone()))
            .collect()
    }
}

#[test]
fn what_does_not_match_is_left_as_it_was() {
    if !has_gpu() {
        return;
    }
    let (mut app, _, _) = app();
    let root = spawn_gltf(&mut app, Transform::IDENTITY);
    let [white, green, red, light] =
        ["white", "green", "red", "light"].map(|node| mesh_of(&mut app, root, node));
    // One is moved, one has another mesh, one has one triangle less.
    let node = app.world().get::<ChildOf>(green).unwrap().parent();
    app.world_mut().get_mut::<Transform>(node).unwrap().translation.x += 0.1;
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let ball = meshes.add(Sphere::new(0.5));
    app.world_mut().get_mut::<Mesh3d>(red).unwrap().0 = ball.clone();
    let own = app.world().get::<Mesh3d>(light).unwrap().0.clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut less = meshes.get(&own).unwrap().clone();
    let indices: Vec<u32> = less.indices().unwrap().iter().map(|index| index as u32).collect();
    less.insert_indices(bevy::mesh::Indices::U32(indices[3..].to_vec()));
    let less = meshes.add(less);
    app.world_mut().get_mut::<Mesh3d>(light).unwrap().0 = less.clone();
    attach(&mut app, root);
    let mut unmatched = instance(&app, root).unmatched().to_vec();
    unmatched.sort();
    let mut wanted = [green, red, light];
    wanted.sort();
    assert_eq!(unmatched, wanted);
    assert_eq!(instance(&app, root).parts(), [white]);
    for (entity, is_lit) in [(white, true), (green, false), (red, false), (light, false)] {
        assert_eq!(app.world().get::<Lightmap>(entity).is_some(), is_lit);
    }
    assert_eq!(app.world().get::<Mesh3d>(red).unwrap().0, ball);

    // What becomes right is lit, and what becomes wrong no more.
    app.world_mut().get_mut::<Mesh3d>(light).unwrap().0 = own;
    app.world_mut().get_mut::<Mesh3d>(white).unwrap().0 = ball;
    app.update();
    assert_eq!(instance(&app, root).parts(), [light]);
    assert!(instance(&app, root).unmatched().contains(&white));
    assert!(app.world().get::<Lightmap>(light).is_some() && app.world().get::<Lightmap>(white).is_none());
}

#[test]
fn light_follows_the_materials_of_the_file() {
    if !has_gpu() {
        return;
    }
    let (mut app, image, _) = app();
    let root = spawn_gltf(&mut app, Transform::IDENTITY);
    attach(&mut app, root);
    let lightmap = instance(&app, root).lightmap().clone();
    let redness = |app: &App| {
        let mean = read_image(app, &lightmap).iter().sum::<Vec3>();
        mean.x / mean.y
    };
    let before = redness(&app);
    let white = mesh_of(&mut app, root, "white");
    let own = app.world().get::<MeshMaterial3d<StandardMaterial>>(white).unwrap().0.clone();
    let red = Color::linear_rgb(0.7, 0.2, 0.2);
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    materials.get_mut(&own).unwrap().base_color = red;
    settle(&mut app, root);
    let painted = redness(&app);
    assert!(painted > 1.2 * before, "{painted} is no redder than {before}");

    // Another material in its place.
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    let grey = materials.add(StandardMaterial { base_color: Color::linear_rgb(0.7, 0.7, 0.7), ..default() });
    app.world_mut().entity_mut(white).insert(MeshMaterial3d(grey));
    settle(&mut app, root);
    let other = redness(&app);
    assert!((other / before - 1.0).abs() < 0.1, "{other} is not as red as {before}");
    assert!(draw(&mut app, &image).iter().any(|texel| *texel != Vec3::ZERO));
}

/// Bevy makes no smaller levels of textures, so that they flicker and would be all that is compared.
fn remove_textures(app: &mut App) {
    let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
    for (_, material) in materials.iter_mut() {
        let bare = StandardMaterial {
            base_color: material.base_color,
            emissive: material.emissive,
            emissive_exposure_weight: material.emissive_exposure_weight,
            double_sided: material.double_sided,
            cull_mode: material.cull_mode,
            reflectance: 0.0,
            perceptual_roughness: 1.0,
            ..default()
        };
        *material = bare;
    }
}

/// `PROBELIGHT_GLTF=atrium.glb PROBELIGHT_SCENE=atrium.plight cargo test --release -p bevy_probelight --test attach -- --ignored`
#[test]
#[ignore = "needs a glTF file and what was baked of it"]
fn another_file_looks_as_the_baked_one() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (variable, name) in [("PROBELIGHT_GLTF", "own.glb"), ("PROBELIGHT_SCENE", "own.plight")] {
        std::fs::copy(std::env::var_os(variable).unwrap(), folder.path().join(name)).unwrap();
    }
    let eye = Transform::from_xyz(-12.0, 2.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    let lamp = Vec3::new(-6.0, 3.0, 1.0);
    let mut pictures = Vec::new();
    for is_attached in [false, true] {
        let mut app = headless_app_in(folder.path().to_str().unwrap());
        let (image, _) = furnish(&mut app, eye, lamp);
        let root = if is_attached {
            let root = spawn_file(&mut app, "own.glb", Transform::IDENTITY);
            make_like_baked(&mut app, root);
            attach_file(&mut app, root, "own.plight");
            assert!(instance(&app, root).unmatched().is_empty());
            assert!(!instance(&app, root).parts().is_empty());
            root
        } else {
            let baked = BakedScene::read(&folder.path().join("own.plight")).unwrap();
            let root = spawn_scene(&mut app, baked, Transform::IDENTITY);
            support::make_diffuse(&mut app, root);
            root
        };
        remove_textures(&mut app);
        settle(&mut app, root);
        pictures.push(draw(&mut app, &image));
    }
    let apart = difference(&pictures[1], &pictures[0]);
    assert!(apart < 0.02, "loaded by Bevy it differs by {apart}");
}
