//! What lights each scene: gathered from Bevy's world after transforms are known, passed on only where it changed.

use bevy::asset::Assets;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::InheritedVisibility;
use bevy::camera::{Camera, Camera3d, Exposure};
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use bevy::log::{warn, warn_once};
use bevy::pbr::StandardMaterial;
use bevy::transform::components::GlobalTransform;
use probelight_math::glam::Vec3;
use probelight_runtime::{SurfaceColors, View};
use probelight_scene::{Bounds, Light, Lighting};

use crate::casters::{Caster, Casters};
use crate::convert::linear;
use crate::environment::{Environment, main_camera};
use crate::instance::ProbelightInstance;
use crate::lights::{self, PER_LUX, ProbelightIgnore};
use crate::movers::ProbelightMover;
use crate::pose::ScenePose;
use crate::scene::ProbelightScene;
use crate::settings::ProbelightSky;

/// What a scene's light comes from, in the scene's own space and times 1/π.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub(crate) struct SceneLight {
    pub(crate) lighting: Lighting,
    /// One for each material.
    pub(crate) colors: Vec<SurfaceColors>,
}

impl SceneLight {
    /// No light at all.
    fn dark() -> Self {
        Self { lighting: Lighting { emissive_scale: 0.0, ..Lighting::default() }, colors: Vec::new() }
    }
}

/// What else a frame of a scene is asked for, in the scene's own space.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub(crate) struct SceneFrame {
    pub(crate) view: Option<View>,
    /// Around movers, sorted.
    pub(crate) boxes: Vec<Bounds>,
    /// What stands in the light, by entity.
    pub(crate) casters: Vec<Caster>,
}

/// A kind of light, where it is, and whether it is shown.
type Lights<'w, 's, L> = Query<
    'w,
    's,
    (Entity, &'static L, &'static GlobalTransform, &'static InheritedVisibility),
    Without<ProbelightIgnore>,
>;

/// Everything in the world that shines or looks.
#[derive(SystemParam)]
pub(crate) struct Surroundings<'w, 's> {
    points: Lights<'w, 's, PointLight>,
    spots: Lights<'w, 's, SpotLight>,
    suns: Lights<'w, 's, DirectionalLight>,
    rectangles: Query<'w, 's, (), (With<RectLight>, Without<ProbelightIgnore>)>,
    sky: Res<'w, ProbelightSky>,
    environment: Res<'w, Environment>,
    cameras:
        Query<'w, 's, (&'static Camera, &'static GlobalTransform, Option<&'static Exposure>), With<Camera3d>>,
    movers: Query<'w, 's, (&'static GlobalTransform, &'static Aabb, &'static ProbelightMover)>,
}

impl Surroundings<'_, '_> {
    /// Where the main camera is, and its exposure.
    fn main_camera(&self) -> Option<(&GlobalTransform, Exposure)> {
        let cameras = self.cameras.iter().map(|(camera, at, exposure)| (camera, (at, exposure)));
        let (at, exposure) = main_camera(cameras)?;
        Some((at, exposure.copied().unwrap_or_default()))
    }

    fn lights(&self, pose: &ScenePose) -> Vec<Light> {
        let mut found: Vec<(Entity, Light)> = Vec::new();
        let shown = |visibility: &InheritedVisibility| visibility.get();
        for (entity, light, at, _) in self.points.iter().filter(|(.., v)| shown(v)) {
            found.push((entity, lights::point(light, at, pose)));
        }
        for (entity, light, at, _) in self.spots.iter().filter(|(.., v)| shown(v)) {
            found.push((entity, lights::spot(light, at, pose)));
        }
        for (entity, light, at, _) in self.suns.iter().filter(|(.., v)| shown(v)) {
            found.push((entity, lights::directional(light, at, pose)));
        }
        // The order of queries changes when entities get other components.
        found.sort_by_key(|(entity, _)| *entity);
        found.into_iter().map(|(_, light)| light).filter(lights::is_lit).collect()
    }

    fn frame(&self, scene: Entity, pose: &ScenePose) -> SceneFrame {
        let view = self.main_camera().map(|(at, _)| View {
            position: pose.point(at.translation()),
            direction: pose.direction(at.forward().as_vec3()),
        });
        let movers = self.movers.iter().filter(|(.., mover)| mover.scene.is_none_or(|of| of == scene));
        let mut boxes: Vec<Bounds> = movers
            .map(|(at, aabb, _)| pose.bounds(at, aabb.center.into(), aabb.half_extents.into()))
            .collect();
        boxes.retain(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        boxes.sort_by(|a, b| {
            a.min.to_array().partial_cmp(&b.min.to_array()).unwrap_or(std::cmp::Ordering::Equal)
        });
        SceneFrame { view, boxes, casters: Vec::new() }
    }
}

/// What a material contributes through a camera of that exposure.
fn surface_colors(material: &StandardMaterial, exposure: f32) -> SurfaceColors {
    let e = &material.emissive;
    let emissive = Vec3::new(e.red, e.green, e.blue).max(Vec3::ZERO);
    let weight = material.emissive_exposure_weight;
    let luminance = emissive * (weight + (1.0 - weight) / exposure);
    SurfaceColors { base_color: linear(material.base_color), emission: luminance * PER_LUX }
}

/// Gathers what lights each scene.
pub(crate) fn collect(
    surroundings: Surroundings,
    mut casters: Casters,
    scenes: Res<Assets<ProbelightScene>>,
    materials: Res<Assets<StandardMaterial>>,
    mut instances: Query<(Entity, &GlobalTransform, &ProbelightInstance, &mut SceneLight, &mut SceneFrame)>,
    mut refused: Local<EntityHashSet>,
) {
    if !surroundings.rectangles.is_empty() && !instances.is_empty() {
        warn_once!("the light of a RectLight does not bounce; ProbelightIgnore on it silences this");
    }
    let exposure =
        surroundings.main_camera().map_or(Exposure::default(), |(_, exposure)| exposure).exposure();
    for (entity, at, instance, mut light, mut frame) in &mut instances {
        let Some(pose) = ScenePose::of(at) else {
            if refused.insert(entity) {
                warn!("{entity}: a baked scene can be moved, turned and scaled evenly only; it stays dark");
            }
            light.set_if_neq(SceneLight::dark());
            frame.set_if_neq(SceneFrame::default());
            continue;
        };
        refused.remove(&entity);
        let Some(scene) = scenes.get(&instance.scene) else { continue };
        let color = |(handle, before): (_, SurfaceColors)| {
            materials.get(handle).map_or(before, |material| surface_colors(material, exposure))
        };
        let baked = SurfaceColors::of(&scene.baked.scene);
        let colors = instance.materials.iter().zip(baked).map(color).collect();
        let sky = surroundings.sky.scaled(&surroundings.environment.sky, PER_LUX);
        let lighting = Lighting { lights: surroundings.lights(&pose), sky, ..Lighting::default() };
        light.set_if_neq(SceneLight { lighting, colors });
        frame
            .set_if_neq(SceneFrame { casters: casters.in_scene(&pose), ..surroundings.frame(entity, &pose) });
    }
}

#[cfg(test)]
mod tests {
    use bevy::color::LinearRgba;

    use super::*;

    #[test]
    fn emission_is_what_bevy_shows() {
        let exposure = 0.25;
        let of = |emissive_exposure_weight| {
            let emissive = LinearRgba::rgb(2.0, 0.0, 0.0);
            let material =
                StandardMaterial { emissive, emissive_exposure_weight, ..StandardMaterial::default() };
            surface_colors(&material, exposure).emission.x / PER_LUX
        };
        // Shown is emissive · mix(1, exposure, weight), which is luminance · exposure.
        for weight in [0.0f32, 0.3, 1.0] {
            let shown = 2.0 * (1.0 - weight + weight * exposure);
            assert!((of(weight) * exposure - shown).abs() < 1e-5);
        }
    }
}
