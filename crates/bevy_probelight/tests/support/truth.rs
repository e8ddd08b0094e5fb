//! What a picture should show, by Probelight's own runtime on the CPU.

use std::sync::Arc;

use bevy::math::{Quat, Vec3};
use bevy::transform::components::Transform;
use bevy_probelight::probelight_asset::BakedScene;
use bevy_probelight::probelight_math::glam::{Vec2, Vec3 as SceneVec3};
use bevy_probelight::probelight_runtime::Runtime;
use bevy_probelight::probelight_scene::Lighting;
use bevy_probelight::probelight_trace::{Hit, Ray};

use super::SIZE;

/// The light of a scene that stands still.
pub(crate) struct Truth {
    pub(crate) runtime: Runtime,
}

impl Truth {
    /// The scene in such a light, lux and candela.
    pub(crate) fn new(baked: BakedScene, lighting: Lighting) -> Self {
        let mut runtime = Runtime::new(Arc::new(baked));
        runtime.set_lighting(lighting).unwrap();
        runtime.converge(1e-5, 300);
        Self { runtime }
    }

    /// What a ray from a camera meets, in the scene's space.
    pub(crate) fn hit(&self, camera: &Transform, scene: &Transform, pixel: u32) -> Option<Hit> {
        let (x, y) = (pixel % SIZE, pixel / SIZE);
        let share = |at: u32| 2.0 * (at as f32 + 0.5) / SIZE as f32 - 1.0;
        // Bevy's default camera: 45° high.
        let height = (std::f32::consts::PI / 8.0).tan();
        let local = Vec3::new(share(x) * height, -share(y) * height, -1.0);
        let (origin, direction) = (camera.translation, camera.rotation * local);
        let back: Quat = scene.rotation.inverse();
        let origin = back * (origin - scene.translation) / scene.scale.x;
        let direction = (back * direction).normalize();
        let of = |v: Vec3| SceneVec3::from_array(v.to_array());
        self.runtime.tracer().closest_hit(&Ray::new(of(origin), of(direction)))
    }

    /// Irradiance there, lux, looked up so many texels beside.
    pub(crate) fn irradiance(&self, hit: &Hit, shift: Vec2) -> Option<Vec3> {
        let layout = &self.runtime.baked().lightmap;
        let place = layout.position(hit.triangle, hit.is_back_face, hit.barycentric)?;
        Some(Vec3::from_array(self.runtime.irradiance().sample(place + shift).to_array()))
    }

    /// The base colour of what was hit, black for what shines.
    pub(crate) fn color(&self, hit: &Hit) -> Vec3 {
        let material = self.runtime.baked().scene.material(hit.triangle as usize);
        if material.emission != SceneVec3::ZERO {
            return Vec3::ZERO;
        }
        Vec3::from_array(material.base_color.truncate().to_array())
    }
}

/// Root-mean-square difference, relative to that of the truth.
pub(crate) fn relative_error(pairs: &[(Vec3, Vec3)]) -> f32 {
    let sum = |f: &dyn Fn(&(Vec3, Vec3)) -> f32| pairs.iter().map(f).sum::<f32>();
    (sum(&|(found, wanted)| (*found - *wanted).length_squared())
        / sum(&|(_, wanted)| wanted.length_squared()))
    .sqrt()
}
