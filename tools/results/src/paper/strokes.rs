//! Arrows and dots in pictures, smooth at their edges.

use probelight_math::glam::{Mat3, Vec2, Vec3};
use probelight_render::DisplayImage;

use super::setups::Camera;

/// Length of an arrow's head, pixels.
const HEAD: f32 = 7.0;

/// Draws a line from `from` to `to` (pixels), `width` pixels wide; a dot where both are the same.
pub(crate) fn line(picture: &mut DisplayImage, [from, to]: [Vec2; 2], width: f32, color: [u8; 3]) {
    let (low, high) = (from.min(to) - width, from.max(to) + width);
    let last = Vec2::new(picture.width as f32 - 1.0, picture.height as f32 - 1.0);
    if high.cmplt(Vec2::ZERO).any() || low.cmpgt(last).any() || !(low.is_finite() && high.is_finite()) {
        return;
    }
    let (low, high) = (low.max(Vec2::ZERO).floor().as_uvec2(), high.min(last).ceil().as_uvec2());
    for y in low.y..=high.y {
        for x in low.x..=high.x {
            let distance = distance(Vec2::new(x as f32, y as f32) + 0.5, [from, to]);
            let cover = (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
            let pixel = &mut picture.pixels[y as usize * picture.width as usize + x as usize];
            for (channel, wanted) in pixel.iter_mut().zip(color) {
                *channel = (f32::from(*channel) * (1.0 - cover) + f32::from(wanted) * cover + 0.5) as u8;
            }
        }
    }
}

/// Draws an arrow; a short one is all head.
pub(crate) fn arrow(picture: &mut DisplayImage, ends: [Vec2; 2], width: f32, color: [u8; 3]) {
    line(picture, ends, width, color);
    let back = ends[0] - ends[1];
    let back = back.clamp_length_max(HEAD) * 0.8;
    for side in [0.6_f32, -0.6] {
        line(picture, [ends[1], ends[1] + Vec2::from_angle(side).rotate(back)], width, color);
    }
}

/// Distance of a point from a line between two others.
fn distance(point: Vec2, [from, to]: [Vec2; 2]) -> f32 {
    let along = to - from;
    let share = ((point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(from + share * along)
}

/// Where a camera sees a point, pixels from the top left corner; `None` behind it.
pub(crate) fn seen(camera: &Camera, point: Vec3) -> Option<Vec2> {
    let forward = (Vec3::from(camera.target) - Vec3::from(camera.position)).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let view_from_world = Mat3::from_cols(right, right.cross(forward), forward).transpose();
    let place = view_from_world * (point - Vec3::from(camera.position));
    let [width, height] = camera.size.map(|side| side as f32);
    let scale = 0.5 * height / (0.5 * camera.vfov_deg.to_radians()).tan();
    let middle = 0.5 * Vec2::new(width, height);
    (place.z > 0.0).then(|| middle + scale / place.z * Vec2::new(place.x, -place.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cover_what_lies_on_them() {
        let mut picture = DisplayImage::filled(20, 10, [0; 3]);
        arrow(&mut picture, [Vec2::new(2.5, 5.5), Vec2::new(15.5, 5.5)], 1.0, [255; 3]);
        assert_eq!((picture.pixel(8, 5), picture.pixel(8, 1)), ([255; 3], [0; 3]));
        assert!(picture.pixel(12, 3)[0] > 50, "the head has width");
        line(&mut picture, [Vec2::new(-50.0, -50.0), Vec2::new(500.0, -40.0)], 3.0, [9; 3]);
        line(&mut picture, [Vec2::NAN, Vec2::ZERO], 3.0, [9; 3]);
        assert!(picture.pixels.iter().all(|pixel| *pixel != [9; 3]));
    }

    #[test]
    fn cameras_see_what_is_ahead_in_the_middle() {
        let camera =
            Camera { position: [1.0, 2.0, -3.0], target: [1.0, 2.0, 5.0], vfov_deg: 90.0, size: [200, 100] };
        let seen = |x, y, z| seen(&camera, Vec3::new(x, y, z));
        assert!(seen(1.0, 2.0, 0.0).unwrap().distance(Vec2::new(100.0, 50.0)) < 1e-3);
        // Up is up; +X is on the left when one looks along +Z.
        assert!(seen(1.0, 5.0, 0.0).unwrap().distance(Vec2::new(100.0, 0.0)) < 1e-3);
        assert!(seen(2.0, 2.0, 0.0).unwrap().x < 100.0);
        assert_eq!(seen(1.0, 2.0, -4.0), None);
    }
}
