//! A camera that goes from place to place.

use probelight_math::glam::Vec3;

use crate::Camera;

/// A smooth way past cameras, in their order: through each eye's place, looking at each target as it goes by.
///
/// Between two cameras a Catmull–Rom spline takes equally long wherever they are, so cameras that lie close together slow it
/// down.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// At least one.
    cameras: Vec<Camera>,
}

impl CameraPath {
    /// The way past cameras; `None` without any. A single camera stands still.
    pub fn new(cameras: &[Camera]) -> Option<Self> {
        (!cameras.is_empty()).then(|| Self { cameras: cameras.to_vec() })
    }

    /// The camera when a share of the way lies behind it: 0 at the first camera and before, 1 at the last and after. Its
    /// name and image are those of the first.
    pub fn at(&self, share: f32) -> Camera {
        let last = self.cameras.len() - 1;
        let way = share.clamp(0.0, 1.0) * last as f32;
        let before = (way as usize).min(last.saturating_sub(1));
        let t = way - before as f32;
        let around: [&Camera; 4] =
            std::array::from_fn(|i| &self.cameras[(before + i).saturating_sub(1).min(last)]);
        let position = spline(around.map(|camera| camera.position), t);
        let ahead = spline(around.map(|camera| camera.target - camera.position), t);
        let [near, far] = [around[1], around[2]];
        let camera = Camera {
            position,
            target: position + ahead,
            up: near.up.normalize_or_zero().lerp(far.up.normalize_or_zero(), t),
            vertical_fov: near.vertical_fov + t * (far.vertical_fov - near.vertical_fov),
            ..self.cameras[0].clone()
        };
        if camera.validate().is_ok() {
            return camera;
        }
        // Half way between two that look in opposite directions there is none: a cut instead.
        let Camera { position, target, up, vertical_fov, .. } = *if t < 0.5 { near } else { far };
        Camera { position, target, up, vertical_fov, ..camera }
    }
}

/// Catmull and Rom 1974: through the second point at 0 and the third at 1.
fn spline([a, b, c, d]: [Vec3; 4], t: f32) -> Vec3 {
    let [slope_b, slope_c] = [(c - a) / 2.0, (d - b) / 2.0];
    let s = 1.0 - t;
    (b * (1.0 + 2.0 * t) + slope_b * t) * s * s + (c * (1.0 + 2.0 * s) - slope_c * s) * t * t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(position: Vec3, ahead: Vec3) -> Camera {
        Camera {
            name: format!("{position}"),
            position,
            target: position + ahead,
            up: Vec3::Y,
            vertical_fov: 1.0,
            width: 8,
            height: 6,
        }
    }

    #[test]
    fn it_passes_each_camera_and_never_jumps() {
        let places = [Vec3::ZERO, Vec3::X, Vec3::new(2.0, 1.0, 0.0), Vec3::new(2.0, 1.0, 5.0)];
        let looks = [Vec3::X, Vec3::X, Vec3::Z, -Vec3::X];
        let cameras: Vec<Camera> =
            places.iter().zip(looks).map(|(place, look)| camera(*place, look)).collect();
        let path = CameraPath::new(&cameras).unwrap();
        for (i, camera) in cameras.iter().enumerate() {
            let found = path.at(i as f32 / 3.0);
            assert!(found.position.abs_diff_eq(camera.position, 1e-5), "{i}: {found:?}");
            assert!(found.target.abs_diff_eq(camera.target, 1e-5), "{i}: {found:?}");
            assert_eq!((found.name, found.width), (cameras[0].name.clone(), 8));
        }
        let step = |i: u32| {
            (path.at(i as f32 / 3000.0).position - path.at((i + 1) as f32 / 3000.0).position).length()
        };
        assert!(
            (0..3000).all(|i| step(i) < 0.01),
            "no step of 3,000 on a way of 7 m is longer than a centimetre"
        );
        assert_eq!(path.at(-1.0), path.at(0.0));
        assert_eq!(path.at(2.0), path.at(1.0));
    }

    #[test]
    fn a_straight_way_past_equal_steps_is_even() {
        let cameras: Vec<Camera> = (0..3).map(|x| camera(Vec3::X * x as f32, -Vec3::Z)).collect();
        let path = CameraPath::new(&cameras).unwrap();
        assert!(path.at(0.5).position.abs_diff_eq(Vec3::X, 1e-6));
        assert!(
            path.at(0.75).target.abs_diff_eq(Vec3::new(1.5625, 0.0, -1.0), 1e-6),
            "slower towards the end"
        );
    }

    #[test]
    fn one_camera_stands_still_and_opposite_ones_are_cut() {
        assert_eq!(CameraPath::new(&[]), None);
        let still = camera(Vec3::ONE, Vec3::X);
        assert_eq!(CameraPath::new(std::slice::from_ref(&still)).unwrap().at(0.7), still);
        let there_and_back = [camera(Vec3::ZERO, Vec3::X), camera(Vec3::ZERO, -Vec3::X)];
        let path = CameraPath::new(&there_and_back).unwrap();
        for share in [0.0, 0.4, 0.5, 0.6, 1.0] {
            assert_eq!(path.at(share).validate(), Ok(()), "{share}");
        }
    }
}
