//! A setup for a scene that came without one.

use std::f32::consts::{FRAC_PI_3, FRAC_PI_4, TAU};
use std::f64::consts::PI;

use probelight_math::glam::{DVec3, Vec3};

use super::Setup;
use crate::{Camera, Lighting, Scene, Sky};

/// Radiance of the sky over a scene that has no light of its own, W·m⁻²·sr⁻¹.
const DEFAULT_SKY_RADIANCE: f32 = 1.0;

/// Directions tried around the vertical axis, beginning with the front, a little to the right.
const AZIMUTHS: u32 = 16;

/// Elevations tried, radians: from above, and from about the height of the scene's middle.
const ELEVATIONS: [f32; 2] = [0.44, 0.14];

/// How much better a later view must be; closed solids look equally good from everywhere.
const SMALLEST_GAIN: f64 = 0.02;

/// A view from outside whose excess of front faces is lower gives way to one from inside, if there is one.
const WANTED_FRONT_EXCESS: f64 = 0.25;

/// Share of the sphere that front faces must fill, less back faces, for a place to be inside a room.
const ENCLOSED_SHARE: f64 = 0.5;

/// Distance of an eye inside the scene from the middle, as a share of the scene's size.
const INSIDE_DISTANCE: f32 = 0.35;

impl Setup {
    /// The scene's own lights, emission and cameras. A scene without any light gets a soft uniform sky, one
    /// without camera a view of the whole scene, from a side where front faces are seen: the open side of a
    /// box, or the inside of a closed one.
    pub fn from_scene(scene: &Scene) -> Self {
        let is_dark = scene.lights.is_empty() && scene.emissive_triangles().is_empty();
        let sky = if is_dark { Sky::Uniform(Vec3::splat(DEFAULT_SKY_RADIANCE)) } else { Sky::default() };
        let cameras =
            if scene.cameras.is_empty() { vec![framing_camera(scene)] } else { scene.cameras.clone() };
        Self {
            name: "from the scene".into(),
            scene: String::new(),
            lighting: Lighting { lights: scene.lights.clone(), sky, ..Lighting::default() },
            cameras,
            light_tracks: Vec::new(),
            eval_bounds: None,
            objects: Vec::new(),
            materials: Vec::new(),
        }
    }
}

/// The camera that sees most front faces for the back faces it sees: from outside, with the sphere around
/// the scene in view, or from inside if the scene is a closed room.
fn framing_camera(scene: &Scene) -> Camera {
    let bounds = scene.bounds();
    let target = bounds.min.midpoint(bounds.max);
    let vertical_fov = FRAC_PI_4;
    let distance = (0.5 * bounds.diagonal()).max(1e-3) / (0.5 * vertical_fov).sin();
    let camera = |position, vertical_fov| Camera {
        name: "overview".into(),
        position,
        target,
        up: Vec3::Y,
        vertical_fov,
        width: 640,
        height: 480,
    };

    let outside = ELEVATIONS.into_iter().flat_map(view_directions).map(|to_eye| target + to_eye * distance);
    let (outside, excess) = best_eye(outside, |eye| FacesSeen::from(scene, eye).front_excess());
    if excess < WANTED_FRONT_EXCESS {
        let inside = view_directions(0.0).map(|to_eye| target + to_eye * (INSIDE_DISTANCE * bounds.size()));
        let (inside, share) = best_eye(inside, |eye| FacesSeen::from(scene, eye).share_of_sphere());
        if share > ENCLOSED_SHARE {
            return camera(inside, FRAC_PI_3);
        }
    }
    camera(outside, vertical_fov)
}

/// Unit vectors towards the eye, all around at one elevation (radians).
fn view_directions(elevation: f32) -> impl Iterator<Item = Vec3> {
    (1..=AZIMUTHS).map(move |step| {
        let azimuth = step as f32 * TAU / AZIMUTHS as f32;
        let (sin, cos) = azimuth.sin_cos();
        Vec3::new(sin * elevation.cos(), elevation.sin(), cos * elevation.cos())
    })
}

/// The eye with the highest score and that score; the first of those about equally good.
fn best_eye(eyes: impl Iterator<Item = Vec3>, score: impl Fn(Vec3) -> f64) -> (Vec3, f64) {
    eyes.map(|eye| (eye, score(eye)))
        .reduce(|best, other| if other.1 > best.1 + SMALLEST_GAIN { other } else { best })
        .unwrap_or((Vec3::ZERO, f64::NEG_INFINITY))
}

/// Solid angles of the faces around an eye, as if none hid another, sr. Double-sided materials look the same
/// from both sides and do not count.
///
/// A closed solid adds as much to one side as to the other. So the difference tells of open boxes and sheets
/// which way they face, and of a closed room whether the eye is inside (it is the winding number times 4π).
#[derive(Clone, Copy, Debug, Default)]
struct FacesSeen {
    front: f64,
    back: f64,
}

impl FacesSeen {
    fn from(scene: &Scene, eye: Vec3) -> Self {
        let mut seen = Self::default();
        for triangle in 0..scene.triangles.len() {
            if scene.material(triangle).double_sided {
                continue;
            }
            let corners = scene.corners(triangle).map(|corner| (corner - eye).as_dvec3());
            let solid_angle = front_solid_angle(corners);
            seen.front += solid_angle.max(0.0);
            seen.back += (-solid_angle).max(0.0);
        }
        seen
    }

    /// What front faces have more than back faces, from −1 (only backs) to 1 (only fronts).
    fn front_excess(self) -> f64 {
        (self.front - self.back) / (self.front + self.back).max(f64::MIN_POSITIVE)
    }

    /// The same as a share of the whole sphere: 1 inside a closed room, 0 outside.
    fn share_of_sphere(self) -> f64 {
        (self.front - self.back) / (4.0 * PI)
    }
}

/// Solid angle of a triangle around the origin, sr; negative if its back faces the origin (Van Oosterom and
/// Strackee 1983).
fn front_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    -2.0 * volume.atan2(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octant_fills_an_eighth_of_the_sphere() {
        let octant = [DVec3::X, DVec3::Y, DVec3::Z];
        assert!((front_solid_angle(octant) + 0.5 * PI).abs() < 1e-12);
        let [a, b, c] = octant;
        assert!((front_solid_angle([a, c, b]) - 0.5 * PI).abs() < 1e-12);
    }

    #[test]
    fn the_first_of_equal_views_is_kept() {
        let eyes = [Vec3::X, Vec3::Y, Vec3::Z];
        let (eye, score) = best_eye(eyes.into_iter(), |eye| f64::from(eye.y) * 0.5 * SMALLEST_GAIN);
        assert_eq!((eye, score), (Vec3::X, 0.0));
        let (eye, _) = best_eye(eyes.into_iter(), |eye| f64::from(eye.y) * 2.0 * SMALLEST_GAIN);
        assert_eq!(eye, Vec3::Y);
    }
}
