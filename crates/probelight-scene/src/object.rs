//! Objects that move through a scene.

use std::sync::Arc;

use probelight_math::glam::{Quat, Vec2, Vec3, Vec4};

use crate::unusable::check_position;
use crate::{Bounds, Scene, Sources, Unusable};

/// Where an object is: scaled about its own origin, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// World position of the object's origin, metres.
    pub translation: Vec3,
    /// Rotation, unit.
    pub rotation: Quat,
    /// Size, the same along all axes; positive.
    pub scale: f32,
}

impl Default for Placement {
    fn default() -> Self {
        Self::at(Vec3::ZERO)
    }
}

impl Placement {
    /// As large as its model and turned like it, with its origin at a world position.
    pub fn at(translation: Vec3) -> Self {
        Self { translation, rotation: Quat::IDENTITY, scale: 1.0 }
    }

    /// Upright at a world position, turned about +Y by `yaw` radians.
    pub fn upright(translation: Vec3, yaw: f32, scale: f32) -> Self {
        Self { translation, rotation: Quat::from_rotation_y(yaw), scale }
    }

    /// The world position of a point of the model.
    #[inline]
    pub fn point(&self, local: Vec3) -> Vec3 {
        self.translation + self.direction(local * self.scale)
    }

    /// The world direction of a direction of the model, with the same length.
    #[inline]
    pub fn direction(&self, local: Vec3) -> Vec3 {
        self.rotation * local
    }

    /// The point of the model that is at a world position.
    #[inline]
    pub fn local_point(&self, world: Vec3) -> Vec3 {
        self.local_direction(world - self.translation) / self.scale
    }

    /// The direction of the model that a world direction is, with the same length.
    #[inline]
    pub fn local_direction(&self, world: Vec3) -> Vec3 {
        self.rotation.conjugate() * world
    }

    /// The smallest world box around a box of the model.
    pub fn bounds(&self, local: &Bounds) -> Bounds {
        let corner = |i: u32| {
            Vec3::new(
                if i & 1 == 0 { local.min.x } else { local.max.x },
                if i & 2 == 0 { local.min.y } else { local.max.y },
                if i & 4 == 0 { local.min.z } else { local.max.z },
            )
        };
        Bounds::of((0..8).map(|i| self.point(corner(i))))
    }

    /// Between this placement and `other`: at 0 this, at 1 the other. Turns the shorter way.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f32) -> Self {
        Self {
            translation: self.translation.lerp(other.translation, share),
            rotation: self.rotation.slerp(other.rotation, share),
            scale: self.scale + (other.scale - self.scale) * share,
        }
    }

    /// Checks that a model can be placed so.
    ///
    /// # Errors
    /// If a number is not finite, the rotation is none, or the scale is not positive.
    pub fn validate(&self) -> Result<(), Unusable> {
        check_position("position", self.translation)?;
        let Self { rotation, scale, .. } = *self;
        Unusable::unless(scale.is_finite() && scale > 0.0, || {
            format!("its scale is {scale}; it must be positive and finite")
        })?;
        Unusable::unless(rotation.is_finite() && rotation.is_normalized(), || {
            format!("its rotation is {rotation}; it must be a quaternion of length 1")
        })
    }
}

/// Where the light of a door is read, as a share of its diagonal: about as far off as vertices are apart in a room.
const DOOR_LIGHT_OFFSET: f32 = 0.25;

/// An object that moves through a scene: triangles and materials of its own, but no light of the bake.
#[derive(Clone, Debug)]
pub struct Object {
    model: Arc<Scene>,
    model_bounds: Bounds,
    placement: Placement,
    is_door: bool,
}

impl Object {
    /// A model at a place. Many objects may share a model; its lights and cameras count for nothing.
    ///
    /// # Errors
    /// See [`Placement::validate`]; and if the model has no triangles.
    pub fn new(model: Arc<Scene>, placement: Placement) -> Result<Self, Unusable> {
        placement.validate()?;
        Unusable::unless(!model.triangles.is_empty(), || "its model has no triangles".into())?;
        Ok(Self { model_bounds: model.bounds(), model, placement, is_door: false })
    }

    /// The same as a door: what opens and shuts ways for light, as a box around its model would. Other objects are taken for
    /// small things in light that goes on without them.
    #[must_use]
    pub fn as_door(self) -> Self {
        Self { is_door: true, ..self }
    }

    /// Whether it opens and shuts ways for light.
    pub fn is_door(&self) -> bool {
        self.is_door
    }

    /// How far off its surface light in free space is read for it, metres: beside a door's own surface that is a mean of both
    /// of its sides, which the bake takes for one.
    pub fn light_offset(&self) -> f32 {
        if self.is_door {
            DOOR_LIGHT_OFFSET * self.model_bounds.diagonal() * self.placement.scale
        } else {
            0.0
        }
    }

    /// The smallest box around its model, in the model's space.
    pub fn model_bounds(&self) -> &Bounds {
        &self.model_bounds
    }

    /// What it looks like, in its own space.
    pub fn model(&self) -> &Arc<Scene> {
        &self.model
    }

    /// Where it is.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The same model at another place.
    ///
    /// # Errors
    /// See [`Placement::validate`]; then it stays where it is.
    pub fn place(&mut self, placement: Placement) -> Result<(), Unusable> {
        placement.validate()?;
        self.placement = placement;
        Ok(())
    }

    /// Another model in its place: what it is and where it is stay.
    ///
    /// # Errors
    /// If the model has no triangles; then it keeps the one that it has.
    pub fn reshape(&mut self, model: Arc<Scene>) -> Result<(), Unusable> {
        *self = Self { is_door: self.is_door, ..Self::new(model, self.placement)? };
        Ok(())
    }

    /// The smallest box around the box of its model, metres, world space.
    pub fn bounds(&self) -> Bounds {
        self.placement.bounds(&self.model_bounds)
    }
}

impl Scene {
    /// The scene with objects as if they stood still in it: for path tracers, and for baking one of them along. What the
    /// scene has keeps its indices; the table of sources is left out, as the objects come from other files.
    #[must_use]
    pub fn with_objects(&self, objects: &[Object]) -> Self {
        let mut scene = Self { sources: Sources::default(), ..self.clone() };
        for object in objects {
            scene.append(object);
        }
        scene
    }

    fn append(&mut self, object: &Object) {
        let Object { model, placement, .. } = object;
        let [vertices, materials, textures] =
            [self.positions.len(), self.materials.len(), self.textures.len()].map(|count| count as u32);
        if !model.uv1.is_empty() {
            self.uv1.resize(self.positions.len(), Vec2::ZERO);
        }
        let has_second_set = !(self.uv1.is_empty() && model.uv1.is_empty());
        self.positions.extend(model.positions.iter().map(|position| placement.point(*position)));
        self.normals.extend(model.normals.iter().map(|normal| placement.direction(*normal)));
        let tangent = |tangent: &Vec4| placement.direction(tangent.truncate()).extend(tangent.w);
        self.tangents.extend(model.tangents.iter().map(tangent));
        self.uv0.extend(&model.uv0);
        if has_second_set {
            self.uv1.extend(&model.uv1);
            self.uv1.resize(self.positions.len(), Vec2::ZERO);
        }
        self.triangles.extend(model.triangles.iter().map(|corners| corners.map(|vertex| vertex + vertices)));
        self.triangle_material.extend(model.triangle_material.iter().map(|material| material + materials));
        self.materials.extend(model.materials.iter().map(|material| {
            let mut material = material.clone();
            for slot in material.texture_slots_mut().into_iter().flatten() {
                slot.texture += textures;
            }
            material
        }));
        self.textures.extend(model.textures.iter().cloned());
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    fn placement() -> Placement {
        Placement {
            translation: Vec3::new(1.0, 2.0, 3.0),
            rotation: Quat::from_rotation_y(FRAC_PI_2),
            scale: 2.0,
        }
    }

    #[test]
    fn objects_are_scaled_then_turned_then_moved() {
        let placement = placement();
        assert!(placement.point(Vec3::X).abs_diff_eq(Vec3::new(1.0, 2.0, 1.0), 1e-6));
        assert!(placement.direction(Vec3::X).abs_diff_eq(Vec3::NEG_Z, 1e-6));
        let unit = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let bounds = placement.bounds(&unit);
        assert!(bounds.min.abs_diff_eq(Vec3::new(1.0, 2.0, 1.0), 1e-6), "{bounds:?}");
        assert!(bounds.max.abs_diff_eq(Vec3::new(3.0, 4.0, 3.0), 1e-6), "{bounds:?}");
    }

    #[test]
    fn the_way_back_is_the_inverse() {
        let (placement, point) = (placement(), Vec3::new(-0.3, 0.7, 4.0));
        assert!(placement.local_point(placement.point(point)).abs_diff_eq(point, 1e-5));
        assert!(placement.local_direction(placement.direction(point)).abs_diff_eq(point, 1e-5));
    }

    #[test]
    fn between_two_placements_everything_goes_along() {
        let half = Placement::default().towards(&placement(), 0.5);
        assert!(half.translation.abs_diff_eq(Vec3::new(0.5, 1.0, 1.5), 1e-6));
        assert!(half.rotation.abs_diff_eq(Quat::from_rotation_y(0.5 * FRAC_PI_2), 1e-6));
        assert_eq!(half.scale, 1.5);
    }

    #[test]
    fn models_without_triangles_are_refused() {
        let refused = Object::new(Arc::new(Scene::default()), Placement::default()).unwrap_err();
        assert_eq!(refused.to_string(), "its model has no triangles");
    }

    #[test]
    fn placements_without_meaning_are_refused() {
        assert!(placement().validate().is_ok());
        for wrong in [
            Placement { translation: Vec3::NAN, ..placement() },
            Placement { scale: 0.0, ..placement() },
            Placement { scale: f32::INFINITY, ..placement() },
            Placement { rotation: Quat::from_xyzw(1.0, 1.0, 0.0, 0.0), ..placement() },
        ] {
            assert!(wrong.validate().is_err(), "{wrong:?}");
        }
    }
}
