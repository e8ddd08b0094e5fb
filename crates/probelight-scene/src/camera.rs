//! Pinhole cameras.

use probelight_math::glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::Unusable;
use crate::unusable::check_position;

/// Largest image side, pixels.
const MAX_IMAGE_SIDE: u32 = 16_384;

/// Smallest and largest field of view, degrees: beyond, the rays of neighbouring pixels are equal, or nothing but
/// the rim of the picture is left.
const FIELD_OF_VIEW_DEGREES: [f32; 2] = [0.01, 179.0];

/// Smallest sine of the angle between the view direction and up.
const MIN_UP_SINE: f32 = 1e-4;

/// A pinhole camera with square pixels, in world space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// What the camera is called in its file.
    pub name: String,
    /// Eye position, metres.
    pub position: Vec3,
    /// A point the camera looks at.
    pub target: Vec3,
    /// Any vector that is not parallel to the view direction; its projection points up in the image.
    pub up: Vec3,
    /// Vertical field of view, radians.
    pub vertical_fov: f32,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
}

impl Camera {
    /// Checks that the camera can take a picture. The one rule for cameras of glTF files, setups and baked files.
    ///
    /// # Errors
    /// [`Unusable`] if a number is not finite, the image has no pixels or more than 16,384 along a side, the
    /// vertical field of view is not from 0.01° to 179°, `target` is `position`, or `up` is parallel to the view.
    pub fn validate(&self) -> Result<(), Unusable> {
        for (name, value) in [("position", self.position), ("target", self.target), ("up", self.up)] {
            check_position(name, value)?;
        }
        let [smallest, largest] = FIELD_OF_VIEW_DEGREES;
        let degrees = self.vertical_fov.to_degrees();
        let has_view = (smallest.to_radians()..=largest.to_radians()).contains(&self.vertical_fov);
        Unusable::unless(has_view, || {
            format!("its vertical field of view is {degrees}°; {smallest}° to {largest}° are allowed")
        })?;
        let has_pixels = [self.width, self.height].iter().all(|side| (1..=MAX_IMAGE_SIDE).contains(side));
        Unusable::unless(has_pixels, || {
            format!(
                "its image is {} × {} pixels; 1 to {MAX_IMAGE_SIDE} a side are allowed",
                self.width, self.height
            )
        })?;
        let forward = (self.target - self.position).try_normalize();
        Unusable::unless(forward.is_some(), || "its position and target are the same point".into())?;
        let up = self.up.try_normalize().unwrap_or_default();
        let is_upright = forward.is_some_and(|forward| forward.cross(up).length() >= MIN_UP_SINE);
        Unusable::unless(is_upright, || "its up is parallel to the view direction, or zero".into())
    }

    /// Unit direction of the ray through `pixel` (pixels from the top left corner of the image; the centre
    /// of the first pixel is (0.5, 0.5)).
    pub fn ray_direction(&self, pixel: Vec2) -> Vec3 {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let half_height = (self.vertical_fov * 0.5).tan();
        let size = Vec2::new(self.width as f32, self.height as f32);
        let offset = (2.0 * pixel - size) / size.y * half_height;
        (forward + right * offset.x - up * offset.y).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "test".into(),
            position: Vec3::ZERO,
            target: -Vec3::Z,
            up: Vec3::Y,
            vertical_fov: std::f32::consts::FRAC_PI_2,
            width: 200,
            height: 100,
        }
    }

    #[test]
    fn cameras_that_cannot_take_a_picture_are_refused() {
        assert_eq!(camera().validate(), Ok(()));
        let refused = |change: fn(&mut Camera), message: &str| {
            let mut changed = camera();
            change(&mut changed);
            let reason = changed.validate().unwrap_err().reason;
            assert!(reason.contains(message), "{reason}");
        };
        refused(|c| c.width = 0, "0 × 100 pixels");
        refused(|c| c.height = u32::MAX, "200 × 4294967295 pixels");
        refused(|c| c.position.x = f32::NAN, "position");
        refused(|c| c.target.y = f32::INFINITY, "target");
        refused(|c| c.up = Vec3::NAN, "its up is [NaN, NaN, NaN]; it must be finite");
        refused(|c| c.up = Vec3::ZERO, "parallel");
        refused(|c| c.up = Vec3::Z * 3.0, "parallel");
        refused(|c| c.target = c.position, "same point");
        for vertical_fov in [0.0, -1.0, std::f32::consts::PI, f32::NAN] {
            let reason = Camera { vertical_fov, ..camera() }.validate().unwrap_err().reason;
            assert!(reason.contains("field of view"), "{reason}");
        }
    }

    #[test]
    fn rays_span_the_field_of_view_and_keep_up_up() {
        let camera = camera();
        assert!(camera.ray_direction(Vec2::new(100.0, 50.0)).abs_diff_eq(-Vec3::Z, 1e-6));
        let top = camera.ray_direction(Vec2::new(100.0, 0.0));
        assert!(top.abs_diff_eq(Vec3::new(0.0, 1.0, -1.0).normalize(), 1e-6));
        let right = camera.ray_direction(Vec2::new(200.0, 50.0));
        assert!(right.abs_diff_eq(Vec3::new(2.0, 0.0, -1.0).normalize(), 1e-6));
    }
}
