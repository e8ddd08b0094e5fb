//! The sky that the main camera sees in Bevy, as the sky of scenes.

use bevy::asset::{AssetEvent, AssetId, Assets};
use bevy::camera::{Camera, Camera3d};
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::light::{EnvironmentMapLight, GeneratedEnvironmentMapLight, Skybox};
use bevy::log::warn;
use bevy::math::Quat;

use crate::cube_map::{ByElevation, CubeMap};
use crate::settings::ProbelightSky;

/// A cube map as a camera shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shown {
    map: AssetId<Image>,
    /// Luminance of a texel of 1, cd/m².
    intensity: f32,
    rotation: Quat,
}

/// What a camera has around it, in the order of [`Shown::by`].
type Surroundings = (
    Option<&'static GeneratedEnvironmentMapLight>,
    Option<&'static EnvironmentMapLight>,
    Option<&'static Skybox>,
);

impl Shown {
    /// What surrounds a camera. Bevy makes an environment map of a generated one, which the main world cannot read; and what
    /// lights counts before what is drawn.
    fn by(
        generated: Option<&GeneratedEnvironmentMapLight>,
        map: Option<&EnvironmentMapLight>,
        skybox: Option<&Skybox>,
    ) -> Option<Self> {
        if let Some(light) = generated {
            let GeneratedEnvironmentMapLight { intensity, rotation, .. } = *light;
            return Some(Self { map: light.environment_map.id(), intensity, rotation });
        }
        if let Some(light) = map {
            // The sharp one: the other has been blurred over a hemisphere.
            let EnvironmentMapLight { intensity, rotation, .. } = *light;
            return Some(Self { map: light.specular_map.id(), intensity, rotation });
        }
        let skybox = skybox?;
        let Skybox { brightness: intensity, rotation, .. } = *skybox;
        Some(Self { map: skybox.image.as_ref()?.id(), intensity, rotation })
    }
}

/// What is known of the main camera: the active one of lowest order.
pub(crate) fn main_camera<'a, T>(cameras: impl IntoIterator<Item = (&'a Camera, T)>) -> Option<T> {
    let active = cameras.into_iter().filter(|(camera, _)| camera.is_active);
    active.min_by_key(|(camera, _)| camera.order).map(|(_, known)| known)
}

/// The sky that was read last.
#[derive(Resource, Debug, Default)]
pub(crate) struct Environment {
    shown: Option<Shown>,
    map: Option<CubeMap>,
    /// cd/m².
    pub(crate) sky: ByElevation,
}

impl Environment {
    /// Takes what is shown now. Only a map that was not read yet, or that changed, is read.
    fn show(
        &mut self,
        shown: Option<Shown>,
        images: &Assets<Image>,
        is_changed: impl Fn(AssetId<Image>) -> bool,
    ) {
        let is_other = self.shown.map(|shown| shown.map) != shown.map(|shown| shown.map);
        let must_read = shown.is_some_and(|shown| is_other || is_changed(shown.map));
        if self.shown == shown && !must_read {
            return;
        }
        if is_other {
            self.map = None;
        }
        self.shown = shown;
        if let Some(image) = shown.filter(|_| must_read).and_then(|shown| images.get(shown.map)) {
            match CubeMap::of(image) {
                Ok(map) => self.map = Some(map),
                // An image that only the render world keeps has been read before it went there.
                Err(_) if self.map.is_some() => {}
                Err(reason) => {
                    warn!("an environment map lights no baked scene: {reason}; give a ProbelightSky");
                }
            }
        }
        let sky = |(shown, map): (Shown, &CubeMap)| map.by_elevation(shown.rotation).scaled(shown.intensity);
        self.sky = shown.zip(self.map.as_ref()).map(sky).unwrap_or_default();
    }
}

/// Reads the sky of the main camera, where no other sky was given. While no camera is active, it stays as it is.
pub(crate) fn read_environment(
    sky: Res<ProbelightSky>,
    cameras: Query<(&Camera, Surroundings), With<Camera3d>>,
    images: Res<Assets<Image>>,
    mut changes: MessageReader<AssetEvent<Image>>,
    mut environment: ResMut<Environment>,
) {
    if *sky != ProbelightSky::Environment {
        changes.clear();
        if environment.shown.is_some() {
            *environment = Environment::default();
        }
        return;
    }
    let changed: Vec<AssetId<Image>> = changes
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    let shown = match main_camera(cameras) {
        Some((generated, map, skybox)) => Shown::by(generated, map, skybox),
        None => environment.shown,
    };
    environment.show(shown, &images, |id| changed.contains(&id));
}
