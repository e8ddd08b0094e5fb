//! What each light sees the scene through: the records that shaders read, computed without a GPU.
//!
//! ```text
//!  directional   2 × 2 parallel views side by side that together cover the scene's box
//!  spot          1 perspective view around its cone; 6 if the cone is wider than 60°
//!  point         6 perspective views, the faces of a cube
//! ```
//!
//! What pictures need besides, views that are fitted to what an eye sees, is in `eye_views`.
//!
//! Each view is a little wider than its share, so that a filter's taps never leave it: no seams.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{Mat4, Vec2, Vec3, Vec4};
use probelight_scene::{Bounds, Light};

/// Most shadow maps at a time, and so most lights: every GPU can hold a texture of 256 layers.
pub const MAX_SHADOW_VIEWS: usize = 256;

/// A directional light has this many views along each side of its map.
pub(super) const DIRECTIONAL_VIEWS_PER_SIDE: u32 = 2;

/// Stands for no view.
pub const NO_VIEW: u32 = u32::MAX;

/// Texels along each border of a view that belong to its neighbours: two that the bias can move a lookup, one and a
/// half that the filter reaches.
pub(super) const GUARD_TEXELS: u32 = 4;

/// Beyond this half angle a spot's single view would waste most of its texels on the middle.
const WIDEST_SINGLE_VIEW: f32 = std::f32::consts::FRAC_PI_3;

/// Distance from a lamp within which nothing casts shadows, as a share of the scene's diagonal: lamps are often
/// modelled right on a surface. Shadow rays end ten times nearer; nearer than this, depth would lose precision.
const NEAR_PER_DIAGONAL: f32 = 1e-4;

/// A light as shaders read it: `Light` in `lights.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightRecord {
    /// World position, metres; zero for directional lights.
    pub position: [f32; 3], //    0
    /// [`DIRECTIONAL_LIGHT`], [`POINT_LIGHT`] or [`SPOT_LIGHT`].
    pub kind: u32, //            12
    /// Unit vector along which the light travels; the axis of a spot.
    pub direction: [f32; 3], //  16
    /// The light's first shadow map.
    pub first_view: u32, //      28
    /// Radiant intensity, W/sr, or irradiance, W/m².
    pub intensity: [f32; 3], //  32
    /// 1 / (cosine of the inner angle − cosine of the outer angle).
    pub cone_scale: f32, //      44
    /// Cosine of the outer angle.
    pub cos_outer: f32, //       48
    /// How many shadow maps the light has.
    pub view_count: u32, //      52
    /// 1 / range², 1/m²; 0 for light without end.
    pub inverse_squared_range: f32, // 56
    /// The first of its views among those for the eye, or [`NO_VIEW`].
    pub eye_view: u32, //        60
}

/// All lights as shaders read them: `Lights` in `lights.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LightsRecord {
    /// The first `count` are lights.
    pub list: [LightRecord; MAX_SHADOW_VIEWS], //   0
    /// Number of lights.
    pub count: u32, //                          16384
    /// Fills the record.
    pub unused: [u32; 3], //                    16388
}

/// A view as shaders read it: `ShadowView` in `shadow_maps.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowViewRecord {
    /// Columns of the projection. Depth is 1 at the light and falls with distance.
    pub clip_from_world: [[f32; 4]; 4], //  0
    /// Unit vector along which the view looks.
    pub axis: [f32; 3], //                 64
    /// Width of a texel, metres: of a directional light anywhere, of others at one metre along the axis.
    pub texel_width: f32, //               76
}

/// [`LightRecord::kind`] of light from infinitely far away.
pub const DIRECTIONAL_LIGHT: u32 = 0;
/// [`LightRecord::kind`] of light that shines in all directions.
pub const POINT_LIGHT: u32 = 1;
/// [`LightRecord::kind`] of light within a cone.
pub const SPOT_LIGHT: u32 = 2;

/// Number of views that lights need.
pub(super) fn view_count(lights: &[Light]) -> usize {
    lights.iter().map(views_of).sum()
}

fn views_of(light: &Light) -> usize {
    match light {
        Light::Directional { .. } => (DIRECTIONAL_VIEWS_PER_SIDE * DIRECTIONAL_VIEWS_PER_SIDE) as usize,
        Light::Spot { outer_angle, .. } if *outer_angle <= WIDEST_SINGLE_VIEW => 1,
        Light::Point { .. } | Light::Spot { .. } => 6,
    }
}

/// Depth along a direction: 1 before the scene, 0 behind it.
pub(super) fn depth_row(direction: Vec3, bounds: &Bounds) -> Vec4 {
    let depth = direction.dot(0.5 * (bounds.min + bounds.max));
    let half_depth = (0.5 * direction.abs().dot(bounds.size())).max(f32::MIN_POSITIVE);
    // A little room in front and behind, for rounding and for points moved off surfaces.
    let scale = 0.5 / (1.01 * half_depth);
    (-direction * scale).extend(0.5 + depth * scale)
}

/// The records of lights that shine on a scene within `bounds`, their views `resolution` texels wide. They have none for an
/// eye.
pub(super) fn light_records(
    lights: &[Light],
    bounds: &Bounds,
    resolution: u32,
) -> (Vec<LightRecord>, Vec<ShadowViewRecord>) {
    let (mut records, mut views) = (Vec::new(), Vec::new());
    for light in lights {
        let first_view = views.len() as u32;
        let view_count = views_of(light) as u32;
        match light {
            Light::Directional { direction, .. } => {
                views.extend(directional_views(*direction, bounds, resolution));
            }
            Light::Spot { position, direction, outer_angle, .. } if view_count == 1 => {
                let cone = Window::around(*direction, outer_angle.tan());
                views.push(perspective_view(*position, &cone, bounds, resolution));
            }
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                let faces = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
                let face = |axis| perspective_view(*position, &Window::around(axis, 1.0), bounds, resolution);
                views.extend(faces.map(face));
            }
        }
        let of_light = record_without_views(light);
        records.push(LightRecord { first_view, view_count, eye_view: NO_VIEW, ..of_light });
    }
    (records, views)
}

fn record_without_views(light: &Light) -> LightRecord {
    match light {
        Light::Directional { direction, irradiance } => LightRecord {
            kind: DIRECTIONAL_LIGHT,
            direction: direction.to_array(),
            intensity: irradiance.to_array(),
            ..LightRecord::default()
        },
        Light::Point { position, intensity, range } => LightRecord {
            kind: POINT_LIGHT,
            position: position.to_array(),
            intensity: intensity.to_array(),
            inverse_squared_range: inverse_square(*range),
            ..LightRecord::default()
        },
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, range } => LightRecord {
            kind: SPOT_LIGHT,
            position: position.to_array(),
            direction: direction.to_array(),
            intensity: intensity.to_array(),
            cone_scale: 1.0 / (inner_angle.cos() - outer_angle.cos()).max(0.001),
            cos_outer: outer_angle.cos(),
            inverse_squared_range: inverse_square(*range),
            ..LightRecord::default()
        },
    }
}

fn inverse_square(range: Option<f32>) -> f32 {
    range.map_or(0.0, |range| 1.0 / (range * range))
}

/// Parallel views along `direction` (unit), row by row, whose shares tile a square around the scene's box.
fn directional_views(direction: Vec3, bounds: &Bounds, resolution: u32) -> Vec<ShadowViewRecord> {
    let (right, up) = direction.any_orthonormal_pair();
    let extent = |axis: Vec3| {
        let center = axis.dot(0.5 * (bounds.min + bounds.max));
        let half = 0.5 * axis.abs().dot(bounds.size());
        (center, half.max(f32::MIN_POSITIVE))
    };
    let ((x, half_width), (y, half_height)) = (extent(right), extent(up));
    let share = resolution - 2 * GUARD_TEXELS;
    let texel_width = 2.0 * half_width.max(half_height) / (share * DIRECTIONAL_VIEWS_PER_SIDE) as f32;
    let middle = 0.5 * (DIRECTIONAL_VIEWS_PER_SIDE - 1) as f32;
    let view = |row: u32, column: u32| {
        let center = |origin: f32, cell: u32| origin + (cell as f32 - middle) * share as f32 * texel_width;
        let scale = 2.0 / (resolution as f32 * texel_width);
        let rows = [
            (right * scale).extend(-center(x, column) * scale),
            (up * scale).extend(-center(y, row) * scale),
            depth_row(direction, bounds),
            Vec4::W,
        ];
        record(rows, direction, texel_width)
    };
    let cells = 0..DIRECTIONAL_VIEWS_PER_SIDE;
    cells
        .clone()
        .flat_map(|row| cells.clone().map(move |column| (row, column)))
        .map(|(r, c)| view(r, c))
        .collect()
}

/// A square through which a lamp looks, in the plane at distance one across `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Unit vector.
    pub(super) axis: Vec3,
    /// Its middle along the two vectors that `axis.any_orthonormal_pair()` has.
    pub(super) middle: Vec2,
    /// Half its width: the tangent of an angle where the middle is on the axis.
    pub(super) half_width: f32,
}

impl Window {
    fn around(axis: Vec3, half_width: f32) -> Self {
        Self { axis, middle: Vec2::ZERO, half_width }
    }
}

/// The view from `position` through a window. Depth is near / distance, without a farthest one.
pub(super) fn perspective_view(
    position: Vec3,
    window: &Window,
    bounds: &Bounds,
    resolution: u32,
) -> ShadowViewRecord {
    let Window { axis, middle, half_width } = *window;
    let (right, up) = axis.any_orthonormal_pair();
    let resolution = resolution as f32;
    let with_guard = half_width * resolution / (resolution - 2.0 * GUARD_TEXELS as f32);
    let near = NEAR_PER_DIAGONAL * bounds.diagonal();
    let row = |v: Vec3| v.extend(-v.dot(position));
    let across = |v: Vec3, middle: f32| row((v - axis * middle) / with_guard);
    let rows = [across(right, middle.x), across(up, middle.y), Vec4::W * near, row(axis)];
    record(rows, axis, 2.0 * with_guard / resolution)
}

pub(super) fn record(rows: [Vec4; 4], axis: Vec3, texel_width: f32) -> ShadowViewRecord {
    let [x, y, z, w] = rows;
    let clip_from_world = Mat4::from_cols(x, y, z, w).transpose().to_cols_array_2d();
    ShadowViewRecord { clip_from_world, axis: axis.to_array(), texel_width }
}

#[cfg(test)]
mod tests {
    use probelight_math::sampling::Rng;

    use super::*;

    const RESOLUTION: u32 = 512;

    fn bounds() -> Bounds {
        Bounds { min: Vec3::new(-3.0, 0.0, 2.0), max: Vec3::new(9.0, 4.0, 5.0) }
    }

    fn project(view: &ShadowViewRecord, point: Vec3) -> Vec3 {
        Mat4::from_cols_array_2d(&view.clip_from_world).project_point3(point)
    }

    /// Clip-space distance from the middle within which a view's own share lies.
    fn core() -> f32 {
        1.0 - (2 * GUARD_TEXELS) as f32 / RESOLUTION as f32
    }

    fn random_point(rng: &mut Rng) -> Vec3 {
        let b = bounds();
        b.min + b.size() * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32())
    }

    #[test]
    fn shares_of_a_light_cover_the_scene_once() {
        let lights = [
            Light::Directional { direction: Vec3::new(0.3, -0.8, 0.1).normalize(), irradiance: Vec3::ONE },
            Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity: Vec3::ONE, range: None },
        ];
        let mut rng = Rng::new(1, 0);
        for light in lights {
            let (_, views) = light_records(std::slice::from_ref(&light), &bounds(), RESOLUTION);
            for _ in 0..1000 {
                let point = random_point(&mut rng);
                let is_inside = |view: &&ShadowViewRecord| {
                    let ndc = project(view, point);
                    let in_front =
                        Mat4::from_cols_array_2d(&view.clip_from_world).mul_vec4(point.extend(1.0)).w > 0.0;
                    in_front && ndc.truncate().abs().max_element() <= core() * 1.00001
                };
                assert_eq!(views.iter().filter(is_inside).count(), 1, "{light:?} at {point}");
            }
        }
    }

    #[test]
    fn depth_is_between_zero_and_one_and_falls_with_distance() {
        let direction = Vec3::new(0.3, -0.8, 0.1).normalize();
        let sun = Light::Directional { direction, irradiance: Vec3::ONE };
        let (_, views) = light_records(&[sun], &bounds(), RESOLUTION);
        let mut rng = Rng::new(2, 0);
        for _ in 0..1000 {
            let point = random_point(&mut rng);
            let [here, behind] = [point, point + 0.1 * direction].map(|p| project(&views[0], p));
            assert!((0.0..=1.0).contains(&here.z) && behind.z < here.z);
            assert!(here.truncate().abs_diff_eq(behind.truncate(), 1e-5), "light travels along the depth");
        }
    }

    #[test]
    fn a_texel_is_as_wide_as_the_record_says() {
        let spot = Light::Spot {
            position: Vec3::Y,
            direction: Vec3::Z,
            intensity: Vec3::ONE,
            inner_angle: 0.3,
            outer_angle: 0.7,
            range: None,
        };
        let (records, views) = light_records(&[spot], &bounds(), RESOLUTION);
        assert_eq!((records[0].view_count, views.len()), (1, 1));
        let axis = Vec3::Z * 5.0 + Vec3::Y;
        let (right, _) = Vec3::Z.any_orthonormal_pair();
        let moved = project(&views[0], axis + right * 5.0 * views[0].texel_width);
        let ndc_per_texel = 2.0 / RESOLUTION as f32;
        assert!((moved.x - ndc_per_texel).abs() < 1e-6, "{moved}");
        let border = project(&views[0], axis + right * 5.0 * 0.7f32.tan());
        assert!((border.x - core()).abs() < 1e-5, "the cone ends where the guard begins");
    }

    #[test]
    fn wide_spots_get_a_cube() {
        let spot = |outer_angle| Light::Spot {
            position: Vec3::ZERO,
            direction: Vec3::X,
            intensity: Vec3::ONE,
            inner_angle: 0.0,
            outer_angle,
            range: None,
        };
        assert_eq!([view_count(&[spot(1.0)]), view_count(&[spot(1.5)])], [1, 6]);
    }
}
