//! Where a scene is in Bevy's world.

use bevy::math::{Quat, Vec3 as BevyVec3};
use bevy::transform::components::GlobalTransform;
use probelight_math::glam::Vec3;
use probelight_scene::{Bounds, Placement};

use crate::convert::vec3;

/// How far axes may differ in length, as a share.
const EVEN: f32 = 1e-3;

/// Where a scene is: scaled evenly, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScenePose {
    translation: BevyVec3,
    rotation: Quat,
    scale: f32,
}

impl ScenePose {
    /// The pose of a transform; `None` if it mirrors, shears, or scales unevenly.
    pub(crate) fn of(transform: &GlobalTransform) -> Option<Self> {
        let affine = transform.affine();
        if affine.matrix3.determinant() <= 0.0 {
            return None;
        }
        let (scale, rotation, translation) = affine.to_scale_rotation_translation();
        let mean = scale.element_sum() / 3.0;
        let [x, y, z] = [affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis];
        let skew = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
        let is_even = (scale - BevyVec3::splat(mean)).abs().max_element() <= EVEN * mean;
        let is_sane = mean.is_finite() && mean > 0.0 && translation.is_finite();
        (is_even && is_sane && skew <= EVEN * mean * mean).then(|| Self {
            translation,
            rotation: rotation.normalize(),
            scale: mean,
        })
    }

    /// Lengths in the world for one in the scene.
    pub(crate) fn scale(&self) -> f32 {
        self.scale
    }

    /// The scene's point at a world position.
    pub(crate) fn point(&self, world: BevyVec3) -> Vec3 {
        vec3(self.rotation.inverse() * (world - self.translation) / self.scale)
    }

    /// The scene's direction for one of the world, with the same length.
    pub(crate) fn direction(&self, world: BevyVec3) -> Vec3 {
        vec3(self.rotation.inverse() * world)
    }

    /// The scene's box around a box that stands in the world by its own transform.
    pub(crate) fn bounds(&self, at: &GlobalTransform, center: BevyVec3, half: BevyVec3) -> Bounds {
        let sign = |bit: u32, i: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |i| center + half * BevyVec3::new(sign(0, i), sign(1, i), sign(2, i));
        Bounds::of((0..8).map(|i| self.point(at.transform_point(corner(i)))))
    }

    /// Where something is in the scene that has the pose `world` in the world.
    pub(crate) fn placement(&self, world: &Self) -> Placement {
        let rotation = (self.rotation.inverse() * world.rotation).normalize();
        Placement {
            translation: self.point(world.translation),
            rotation: probelight_math::glam::Quat::from_array(rotation.to_array()),
            scale: world.scale / self.scale,
        }
    }

    /// Columns of the matrix that takes world positions to the scene's.
    pub(crate) fn scene_from_world(&self) -> [[f32; 4]; 4] {
        let inverse = bevy::math::Affine3A::from_scale_rotation_translation(
            BevyVec3::splat(self.scale),
            self.rotation,
            self.translation,
        )
        .inverse();
        bevy::math::Mat4::from(inverse).to_cols_array_2d()
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;
    use bevy::transform::components::Transform;

    use super::*;

    #[test]
    fn points_return_to_the_scene() {
        let transform = Transform::from_xyz(1.0, 2.0, 3.0)
            .with_rotation(Quat::from_rotation_y(0.7))
            .with_scale(BevyVec3::splat(2.0));
        let global = GlobalTransform::from(transform);
        let pose = ScenePose::of(&global).unwrap();
        let local = BevyVec3::new(0.3, -0.2, 0.9);
        let world = global.transform_point(local);
        assert!(pose.point(world).abs_diff_eq(vec3(local), 1e-5));
        let inner = Transform::from_xyz(0.4, 0.0, 1.0).with_rotation(Quat::from_rotation_x(0.3));
        let placement = pose.placement(&ScenePose::of(&GlobalTransform::from(transform * inner)).unwrap());
        let wanted = inner.transform_point(BevyVec3::ONE);
        assert!(placement.point(Vec3::ONE).abs_diff_eq(vec3(wanted), 1e-4));
        let matrix = bevy::math::Mat4::from_cols_array_2d(&pose.scene_from_world());
        assert!(matrix.transform_point3(world).abs_diff_eq(local, 1e-5));
        let bounds = pose.bounds(&global, local, BevyVec3::splat(0.1));
        assert!(bounds.contains(vec3(local)) && (bounds.diagonal() - 0.2 * 3f32.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn uneven_transforms_are_refused() {
        let of = |affine| ScenePose::of(&GlobalTransform::from(affine));
        assert!(of(Affine3A::from_scale(BevyVec3::new(1.0, 1.0, 1.1))).is_none());
        assert!(of(Affine3A::from_scale(BevyVec3::new(-1.0, 1.0, 1.0))).is_none());
        assert!(of(Affine3A::from_scale(BevyVec3::ZERO)).is_none());
        let sheared = bevy::math::Mat3::from_cols_array(&[1.0, 0.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(of(Affine3A::from_mat3(sheared)).is_none());
        assert!(of(Affine3A::from_scale(BevyVec3::splat(3.0))).is_some());
    }
}
