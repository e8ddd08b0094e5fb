//! Skies that Bevy's cameras have, as the light of scenes.

mod support;

use std::time::Duration;

use bevy::asset::RenderAssetUsages;
use bevy::light::{EnvironmentMapLight, GeneratedEnvironmentMapLight, Skybox};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
};
use bevy_probelight::{Probelight, ProbelightInstance, ProbelightScene, ProbelightSky};
use half::f16;
use support::truth::relative_error;
use support::{cornell, has_gpu, headless_app, make_diffuse, read_image, settle, spawn_camera, spawn_scene};

/// Luminance of the maps' bright texels, cd/m², and what they are multiplied by.
const COLOR: Vec3 = Vec3::new(0.25, 0.5, 1.0);
const INTENSITY: f32 = 40.0;

/// A map of half floats with a colour by (face, row).
fn cube_map(app: &mut App, color: impl Fn(u32, u32) -> Vec3) -> Handle<Image> {
    const EDGE: u32 = 32;
    let size = Extent3d { width: EDGE, height: EDGE, depth_or_array_layers: 6 };
    let texels = (0..6 * EDGE * EDGE).map(|i| color(i / (EDGE * EDGE), i / EDGE % EDGE));
    let halves = texels.flat_map(|texel| texel.extend(1.0).to_array().map(f16::from_f32));
    let bytes = halves.flat_map(f16::to_le_bytes).collect();
    let (dimension, format) = (TextureDimension::D2, TextureFormat::Rgba16Float);
    let mut image = Image::new(size, dimension, bytes, format, RenderAssetUsages::default());
    image.texture_view_descriptor =
        Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

fn even(app: &mut App) -> Handle<Image> {
    cube_map(app, |_, _| COLOR)
}

/// Bright above the horizon.
fn upper_half(app: &mut App) -> Handle<Image> {
    cube_map(app, |face, row| if face == 2 || (face != 3 && row < 16) { COLOR } else { Vec3::ZERO })
}

fn environment(map: Handle<Image>, rotation: Quat) -> EnvironmentMapLight {
    EnvironmentMapLight {
        diffuse_map: map.clone(),
        specular_map: map,
        intensity: INTENSITY,
        rotation,
        ..default()
    }
}

/// The scene, its camera and the picture.
struct Stage {
    app: App,
    scene: Entity,
    camera: Entity,
    picture: Handle<Image>,
}

fn stage() -> Stage {
    let mut app = headless_app();
    let eye = Transform::from_xyz(2.78, 2.73, -6.2).looking_at(Vec3::new(2.78, 2.73, 0.0), Vec3::Y);
    let picture = spawn_camera(&mut app, eye);
    let camera = app.world_mut().query_filtered::<Entity, With<Camera3d>>().single(app.world()).unwrap();
    let scene = spawn_scene(&mut app, cornell(), Transform::IDENTITY);
    make_diffuse(&mut app, scene);
    app.update();
    Stage { app, scene, camera, picture }
}

impl Stage {
    /// The lightmap once light stands still.
    fn light(&mut self) -> Vec<Vec3> {
        // A frame with the camera on, which the sky is read from.
        self.app.update();
        settle(&mut self.app, self.scene);
        let lightmap = self.app.world().get::<ProbelightInstance>(self.scene).unwrap().lightmap().clone();
        read_image(&self.app, &lightmap)
    }

    fn light_under(&mut self, sky: ProbelightSky) -> Vec<Vec3> {
        self.app.insert_resource(sky);
        self.light()
    }
}

fn difference(found: &[Vec3], wanted: &[Vec3]) -> f32 {
    relative_error(&found.iter().copied().zip(wanted.iter().copied()).collect::<Vec<_>>())
}

#[test]
fn an_even_map_lights_as_an_even_sky() {
    if !has_gpu() {
        return;
    }
    let mut stage = stage();
    let dark = stage.light();
    let wanted = stage.light_under(ProbelightSky::Uniform(COLOR * INTENSITY));
    assert!(difference(&dark, &wanted) > 0.5, "the sky is not seen");
    let map = even(&mut stage.app);
    stage.app.world_mut().entity_mut(stage.camera).insert(environment(map.clone(), Quat::IDENTITY));
    // Not while another sky is given.
    let other = stage.light_under(ProbelightSky::Uniform(0.9 * COLOR * INTENSITY));
    assert!((difference(&other, &wanted) - 0.1).abs() < 0.01);
    let found = stage.light_under(ProbelightSky::Environment);
    let apart = difference(&found, &wanted);
    assert!(apart < 0.005, "the map lights otherwise: {apart}");

    // Half as strong, and as what else a camera may have.
    stage.app.world_mut().get_mut::<EnvironmentMapLight>(stage.camera).unwrap().intensity *= 0.5;
    let half = difference(&stage.light(), &wanted);
    assert!((half - 0.5).abs() < 0.01, "half the intensity is {half} darker");
    stage.app.world_mut().entity_mut(stage.camera).remove::<EnvironmentMapLight>();
    assert!(difference(&stage.light(), &dark) < 1e-3, "the light stays without the map");
    let skybox = Skybox { image: Some(map.clone()), brightness: INTENSITY, ..default() };
    stage.app.world_mut().entity_mut(stage.camera).insert(skybox);
    let drawn = difference(&stage.light(), &wanted);
    assert!(drawn < 0.005, "the sky that is drawn lights otherwise: {drawn}");
    let filtered =
        GeneratedEnvironmentMapLight { environment_map: map, intensity: 2.0 * INTENSITY, ..default() };
    stage.app.world_mut().entity_mut(stage.camera).insert(filtered);
    let twice = difference(&stage.light(), &wanted);
    assert!((twice - 1.0).abs() < 0.01, "the source of a filtered map lights otherwise: {twice}");
}

#[test]
fn half_a_map_lights_by_elevation() {
    if !has_gpu() {
        return;
    }
    let mut stage = stage();
    // The closest without anything negative; see the test of the fit.
    let [bright, middle] = [9.0 / 7.0, 3.0 / 7.0].map(|share| share * COLOR * INTENSITY);
    let sky = |zenith, ground| ProbelightSky::Gradient { zenith, horizon: middle, ground };
    let wanted = stage.light_under(sky(bright, Vec3::ZERO));
    let turned_over = stage.light_under(sky(Vec3::ZERO, bright));
    let map = upper_half(&mut stage.app);
    stage.app.world_mut().entity_mut(stage.camera).insert(environment(map.clone(), Quat::IDENTITY));
    let found = stage.light_under(ProbelightSky::Environment);
    let apart = difference(&found, &wanted);
    assert!(apart < 0.005, "the map lights otherwise: {apart}");
    assert!(difference(&found, &turned_over) > 0.1, "up and down make no difference");
    let over = Quat::from_rotation_x(std::f32::consts::PI);
    stage.app.world_mut().entity_mut(stage.camera).insert(environment(map.clone(), over));
    let apart = difference(&stage.light(), &turned_over);
    assert!(apart < 0.005, "turned over it lights otherwise: {apart}");

    // A map that changes is read anew.
    let mut images = stage.app.world_mut().resource_mut::<Assets<Image>>();
    images.get_mut(&map).unwrap().data.as_mut().unwrap().fill(0);
    stage.app.update();
    assert_eq!(
        stage.light().iter().sum::<Vec3>(),
        stage.light_under(ProbelightSky::Uniform(Vec3::ZERO)).iter().sum()
    );
}

/// Where texture arrays cannot be bound, as with the driver in software, Bevy 0.19.1's shader for lightmaps under environment maps
/// takes a number for a truth, and does not compile.
fn correct_bevys_shader(app: &mut App) {
    let flag = "light_probes.view_environment_map_affects_lightmapped_mesh_diffuse";
    let reading = |shaders: &Assets<Shader>| {
        shaders.iter().find(|(_, shader)| shader.source.as_str().contains(flag)).map(|(id, _)| id)
    };
    // Shaders are loaded in the background.
    let id = (0..2000).find_map(|_| {
        app.update();
        std::thread::sleep(Duration::from_millis(5));
        reading(app.world().resource())
    });
    let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
    let mut shader = shaders.get_mut(id.expect("a shader reads the flag")).unwrap();
    let (wrong, right) = (format!("{flag};"), format!("{flag} != 0u;"));
    *shader = Shader::from_wgsl(shader.source.as_str().replace(&wrong, &right), shader.path.clone());
    drop(shader);
    app.update();
}

#[test]
fn light_of_a_map_is_not_counted_twice() {
    if !has_gpu() {
        return;
    }
    let mut stage = stage();
    correct_bevys_shader(&mut stage.app);
    let draw = |stage: &mut Stage| {
        stage.light();
        stage.app.update();
        stage.app.update();
        read_image(&stage.app, &stage.picture)
    };
    stage.app.insert_resource(ProbelightSky::Uniform(COLOR * INTENSITY));
    let wanted = draw(&mut stage);
    let map = even(&mut stage.app);
    stage.app.world_mut().entity_mut(stage.camera).insert(environment(map, Quat::IDENTITY));
    stage.app.insert_resource(ProbelightSky::Environment);
    let found = draw(&mut stage);
    let apart = difference(&found, &wanted);
    assert!(apart < 0.005, "with Bevy's own light of the map the picture is another: {apart}");
    // Without lightmaps Bevy's own light is there, so that the comparison could fail.
    let handle = stage.app.world().get::<Probelight>(stage.scene).unwrap().0.clone();
    stage.app.world_mut().entity_mut(stage.scene).remove::<Probelight>();
    let scene = stage.app.world().resource::<Assets<ProbelightScene>>().get(&handle).unwrap().clone();
    for part in &scene.parts {
        let material = MeshMaterial3d(scene.materials[part.material].clone());
        stage.app.world_mut().spawn((Mesh3d(part.mesh.clone()), material));
    }
    stage.app.update();
    stage.app.update();
    let own = read_image(&stage.app, &stage.picture);
    assert!(difference(&own, &wanted) > 0.1, "Bevy's own light of the map is not seen");
}
