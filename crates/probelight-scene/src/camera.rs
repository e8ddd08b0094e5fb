//! Pinhole cameras.

use probelight_math::glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

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

    #[test]
    fn rays_span_the_field_of_view_and_keep_up_up() {
        let camera = Camera {
            name: "test".into(),
            position: Vec3::ZERO,
            target: -Vec3::Z,
            up: Vec3::Y,
            vertical_fov: std::f32::consts::FRAC_PI_2,
            width: 200,
            height: 100,
        };
        assert!(camera.ray_direction(Vec2::new(100.0, 50.0)).abs_diff_eq(-Vec3::Z, 1e-6));
        let top = camera.ray_direction(Vec2::new(100.0, 0.0));
        assert!(top.abs_diff_eq(Vec3::new(0.0, 1.0, -1.0).normalize(), 1e-6));
        let right = camera.ray_direction(Vec2::new(200.0, 50.0));
        assert!(right.abs_diff_eq(Vec3::new(2.0, 0.0, -1.0).normalize(), 1e-6));
    }
}
