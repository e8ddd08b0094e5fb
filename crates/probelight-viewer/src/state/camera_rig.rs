//! How mouse and keys move a camera. Its target is what it turns around.

use std::f32::consts::PI;

use probelight_math::glam::{Quat, Vec2, Vec3};
use probelight_scene::Camera;

/// The view stays so far from straight up and straight down, radians.
const POLE_DISTANCE: f32 = 0.02;

/// How near the camera comes to what it turns around, as a share of the scene's diagonal.
const NEAREST: f32 = 1e-3;

/// Unit vectors to the right, up and forward; up is the camera's own, along which it flies.
pub fn axes(camera: &Camera) -> [Vec3; 3] {
    let forward = (camera.target - camera.position).normalize_or(-Vec3::Z);
    let up = camera.up.normalize_or(Vec3::Y);
    [forward.cross(up).normalize_or(Vec3::X), up, forward]
}

/// Radians of the view that a pixel has.
fn angle_of_pixel(camera: &Camera) -> f32 {
    camera.vertical_fov / camera.height.max(1) as f32
}

/// Turns by angles to the right and up, but not over a pole.
fn turned(camera: &Camera, angles: Vec2) -> Vec3 {
    let [right, up, forward] = axes(camera);
    let height = forward.angle_between(up);
    let pitch = angles.y.clamp((height - PI + POLE_DISTANCE).min(0.0), (height - POLE_DISTANCE).max(0.0));
    (Quat::from_axis_angle(up, -angles.x) * Quat::from_axis_angle(right, pitch) * forward).normalize()
}

/// Turns the head by as much as the mouse moved, pixels to the right and down: what is under the mouse stays there.
pub fn look(camera: &mut Camera, pixels: Vec2) {
    let distance = camera.position.distance(camera.target);
    let angles = Vec2::new(pixels.x, -pixels.y) * angle_of_pixel(camera);
    camera.target = camera.position + turned(camera, angles) * distance;
}

/// Goes around the target by as much as the mouse moved, pixels to the right and down. Across the picture is half a turn.
pub fn orbit(camera: &mut Camera, pixels: Vec2) {
    let distance = camera.position.distance(camera.target);
    let angles = Vec2::new(pixels.x, -pixels.y) * PI / camera.height.max(1) as f32;
    camera.position = camera.target - turned(camera, angles) * distance;
}

/// Shifts the camera by as much as the mouse moved, pixels to the right and down: the target stays under the mouse.
pub fn pan(camera: &mut Camera, pixels: Vec2) {
    let [right, up, forward] = axes(camera);
    let upward = right.cross(forward).dot(up).signum() * right.cross(forward);
    let per_pixel = 2.0 * (0.5 * camera.vertical_fov).tan() / camera.height.max(1) as f32;
    let distance = camera.position.distance(camera.target);
    fly(camera, (-right * pixels.x + upward * pixels.y) * per_pixel * distance);
}

/// Comes nearer to the target by a factor on the distance. Near it, the target goes ahead.
pub fn dolly(camera: &mut Camera, factor: f32, diagonal: f32) {
    let [_, _, forward] = axes(camera);
    let distance = camera.position.distance(camera.target);
    let nearest = NEAREST * diagonal;
    let next = distance * factor;
    camera.position += forward * (distance - next);
    if next < nearest {
        camera.target = camera.position + forward * nearest.max(distance);
    }
}

/// Flies, metres.
pub fn fly(camera: &mut Camera, offset: Vec3) {
    camera.position += offset;
    camera.target += offset;
}

/// Looks at a point from a distance, metres, without turning more than it must.
pub fn focus(camera: &mut Camera, point: Vec3, distance: f32) {
    let [_, _, forward] = axes(camera);
    camera.target = point;
    camera.position = point - forward * distance;
}

/// Where a point is in the picture, pixels from the top left corner, and its distance along the view; `None` behind the
/// eye.
pub fn project(camera: &Camera, point: Vec3) -> Option<(Vec2, f32)> {
    let [right, _, forward] = axes(camera);
    let up = right.cross(forward);
    let offset = point - camera.position;
    let depth = offset.dot(forward);
    if depth <= 1e-6 * offset.length() {
        return None;
    }
    let half_height = (0.5 * camera.vertical_fov).tan();
    let scale = 0.5 * camera.height as f32 / (half_height * depth);
    let middle = 0.5 * Vec2::new(camera.width as f32, camera.height as f32);
    Some((middle + Vec2::new(offset.dot(right), -offset.dot(up)) * scale, depth))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "test".into(),
            position: Vec3::ZERO,
            target: -5.0 * Vec3::Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            width: 640,
            height: 480,
        }
    }

    #[test]
    fn looking_turns_by_the_field_of_view_and_never_over_the_pole() {
        let mut turned = camera();
        look(&mut turned, Vec2::new(480.0, 0.0));
        let forward = (turned.target - turned.position).normalize();
        assert!(forward.abs_diff_eq(Vec3::new(1f32.sin(), 0.0, -1f32.cos()), 1e-5), "{forward}");
        for sign in [1.0, -1.0] {
            for _ in 0..20 {
                look(&mut turned, Vec2::new(0.0, sign * 300.0));
            }
            let [_, up, forward] = axes(&turned);
            assert!((forward.angle_between(-sign * up) - POLE_DISTANCE).abs() < 1e-3);
        }
    }

    #[test]
    fn orbits_keep_the_target_and_the_distance() {
        let mut moved = camera();
        orbit(&mut moved, Vec2::new(240.0, 100.0));
        assert_eq!(moved.target, camera().target);
        assert!((moved.position.distance(moved.target) - 5.0).abs() < 1e-4);
        assert!(moved.position.y > 1.0, "dragging down shows it from above: {}", moved.position);
        dolly(&mut moved, 0.5, 10.0);
        assert!((moved.position.distance(moved.target) - 2.5).abs() < 1e-4);
        for _ in 0..50 {
            dolly(&mut moved, 0.5, 10.0);
        }
        assert!(moved.validate().is_ok(), "it goes on through the target");
    }

    #[test]
    fn panning_keeps_the_target_under_the_mouse() {
        let mut moved = camera();
        pan(&mut moved, Vec2::new(30.0, -20.0));
        let (pixel, depth) = project(&moved, camera().target).unwrap();
        assert!(pixel.abs_diff_eq(Vec2::new(350.0, 220.0), 1e-2), "{pixel}");
        assert!((depth - 5.0).abs() < 1e-4);
    }

    #[test]
    fn points_are_projected_where_rays_meet_them() {
        let camera = camera();
        for pixel in [Vec2::new(10.0, 400.0), Vec2::new(320.5, 240.5)] {
            let point = camera.position + 3.0 * camera.ray_direction(pixel);
            let (found, _) = project(&camera, point).unwrap();
            assert!(found.abs_diff_eq(pixel, 1e-2), "{found}");
        }
        assert_eq!(project(&camera, Vec3::Z), None);
    }
}
