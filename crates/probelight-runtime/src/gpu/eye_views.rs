//! Views of lights that are fitted to what an eye sees, for pictures: computed without a GPU.
//!
//! Some lights get [`EYE_VIEWS`] each: suns first, then the lamps and spots that shine brightest on what lies before the eye.
//! A view holds a ball around what the eye sees up to some distance, as far as that makes it finer than the light's own.
//! It moves by whole texels, so that the edges of shadows stand still.

use probelight_math::color::luminance;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{Bounds, Camera, Light};

use super::shadow_views::{
    GUARD_TEXELS, NO_VIEW, ShadowViewRecord, Window, depth_row, perspective_view, record,
};

/// A light has so many views that are fitted to the view of the eye, from fine to coarse.
pub(super) const EYE_VIEWS: usize = 2;

/// So many lights have such views at a time.
const MAX_EYE_LIGHTS: usize = 6;

/// Most views for the eye.
pub(super) const MAX_EYE_VIEWS: usize = MAX_EYE_LIGHTS * EYE_VIEWS;

/// How far from the eye its views reach, as shares of the scene's diagonal.
const EYE_REACHES: [f32; EYE_VIEWS] = [1.0 / 32.0, 1.0 / 8.0];

/// A lamp's windows move by this share of their width: when the eye moves a little, none need be drawn again.
const STEPS_PER_WINDOW: f32 = 8.0;

/// A lamp's window must be narrower than its own view by this factor.
const WIDEST_WINDOW: f32 = 0.75;

/// The views for an eye: as many as there are layers to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct EyeViews {
    /// One light's after the other's.
    pub(super) records: Vec<ShadowViewRecord>,
    /// For each light the first of its views, or [`NO_VIEW`].
    pub(super) first: Vec<u32>,
}

/// The most views that lights can have for any eye.
pub(super) fn eye_view_count(lights: &[Light]) -> usize {
    EYE_VIEWS * lights.len().min(MAX_EYE_LIGHTS)
}

impl EyeViews {
    /// No light has one.
    pub(super) fn none(lights: &[Light]) -> Self {
        Self { records: Vec::new(), first: vec![NO_VIEW; lights.len()] }
    }

    /// The views of lights for an eye, `resolution` texels wide.
    pub(super) fn new(lights: &[Light], bounds: &Bounds, resolution: u32, eye: &Camera) -> Self {
        let balls = EYE_REACHES.map(|reach| Ball::in_view(eye, reach * bounds.diagonal()));
        let mut brightest: Vec<(usize, f32)> = lights
            .iter()
            .map(|light| balls[EYE_VIEWS - 1].most_light_from(light))
            .enumerate()
            .filter(|(_, brightness)| *brightness > 0.0)
            .collect();
        brightest.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let mut views = Self::none(lights);
        for (light, _) in brightest {
            if views.records.len() < MAX_EYE_VIEWS {
                views.add(light, balls.map(|ball| ball.view_of(&lights[light], bounds, resolution)));
            }
        }
        views
    }

    fn add(&mut self, light: usize, views: [Option<ShadowViewRecord>; EYE_VIEWS]) {
        if views.iter().any(Option::is_some) {
            self.first[light] = self.records.len() as u32;
            self.records.extend(views.map(|view| view.unwrap_or_else(nowhere)));
        }
    }
}

/// A view in which nothing lies.
fn nowhere() -> ShadowViewRecord {
    record([Vec4::W * 9.0, Vec4::W * 9.0, Vec4::W, Vec4::W], Vec3::NEG_Y, 1.0)
}

/// What an eye sees up to some distance lies in it; it keeps its size when the eye turns.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vec3,
    radius: f32,
}

impl Ball {
    /// The smallest one around the eye and the corners of what it sees up to a distance.
    fn in_view(eye: &Camera, reach: f32) -> Self {
        let forward = (eye.target - eye.position).normalize_or(-Vec3::Z);
        let half_height = (0.5 * eye.vertical_fov).tan();
        let half_width = half_height * eye.width as f32 / eye.height.max(1) as f32;
        let squared_slant = half_height * half_height + half_width * half_width;
        // Corners and eye are equally far from the middle; of a wide view the middle is that of its far end.
        let share = (0.5 * (1.0 + squared_slant)).min(1.0);
        let radius = if share < 1.0 { share } else { squared_slant.sqrt() };
        Self { center: eye.position + forward * share * reach, radius: radius * reach }
    }

    /// How bright a light is within the ball at most, W/m²; infinite for suns, which come first.
    fn most_light_from(&self, light: &Light) -> f32 {
        let (Light::Point { position, intensity, range } | Light::Spot { position, intensity, range, .. }) =
            light
        else {
            return f32::INFINITY;
        };
        let offset = self.center - *position;
        let distance = (offset.length() - self.radius).max(0.0);
        let misses = match light {
            Light::Spot { direction, outer_angle, .. } => {
                offset.angle_between(*direction) > outer_angle + self.half_angle(*position)
            }
            _ => false,
        };
        if misses || range.is_some_and(|range| distance >= range) {
            return 0.0;
        }
        luminance(*intensity) / distance.max(0.1 * self.radius).powi(2)
    }

    /// Half the angle under which it is seen; a straight one from inside.
    fn half_angle(&self, from: Vec3) -> f32 {
        let distance = from.distance(self.center);
        if distance > self.radius { (self.radius / distance).asin() } else { std::f32::consts::PI }
    }

    /// A light's view that holds the ball, if that is finer than the light's own.
    fn view_of(&self, light: &Light, bounds: &Bounds, resolution: u32) -> Option<ShadowViewRecord> {
        let (position, axis, own_half_width) = match light {
            Light::Directional { direction, .. } => {
                return Some(self.parallel_view(*direction, bounds, resolution));
            }
            Light::Point { position, .. } => (*position, nearest_axis(self.center - *position), 1.0),
            Light::Spot { position, direction, outer_angle, .. } => {
                // Where the ball is wider than the cone, the cone is enough; and a cube's faces are not wider than one.
                let own = outer_angle.tan();
                (*position, *direction, if (0.0..1.0).contains(&own) { own } else { 1.0 })
            }
        };
        let window = self.window(position, axis, resolution)?;
        (window.half_width < WIDEST_WINDOW * own_half_width)
            .then(|| perspective_view(position, &window, bounds, resolution))
    }

    fn parallel_view(&self, direction: Vec3, bounds: &Bounds, resolution: u32) -> ShadowViewRecord {
        let (right, up) = direction.any_orthonormal_pair();
        let texel_width = 2.0 * self.radius / (resolution - 2 * GUARD_TEXELS) as f32;
        let scale = 2.0 / (resolution as f32 * texel_width);
        let row = |axis: Vec3| {
            let snapped = (axis.dot(self.center) / texel_width).round() * texel_width;
            (axis * scale).extend(-snapped * scale)
        };
        let rows = [row(right), row(up), depth_row(direction, bounds), Vec4::W];
        record(rows, direction, texel_width)
    }

    /// The window through which the ball is seen from a position. Its width is a power of √2 and its middle on a
    /// lattice of whole texels.
    fn window(&self, from: Vec3, axis: Vec3, resolution: u32) -> Option<Window> {
        let (right, up) = axis.any_orthonormal_pair();
        let offset = self.center - from;
        let half_angle = self.half_angle(from);
        let tilt = offset.angle_between(axis);
        // Beyond this a plane across the axis has texels that are drawn out too long.
        if tilt + half_angle > std::f32::consts::FRAC_PI_3 {
            return None;
        }
        let (nearest, farthest) = ((tilt - half_angle).tan(), (tilt + half_angle).tan());
        let radial = Vec2::new(right.dot(offset), up.dot(offset)).normalize_or_zero();
        // Its middle lies up to half a step off.
        let needed = 0.5 * (farthest - nearest) / (1.0 - 1.0 / STEPS_PER_WINDOW);
        let half_width = ((2.0 * needed.log2()).ceil() * 0.5).exp2();
        let texels = (resolution - 2 * GUARD_TEXELS) as f32;
        let step = 2.0 * half_width / texels * (texels / STEPS_PER_WINDOW).floor();
        let middle = (radial * 0.5 * (nearest + farthest) / step).round() * step;
        Some(Window { axis, middle, half_width })
    }
}

/// The one of a cube's faces, edges and corners that lies most in a direction.
fn nearest_axis(direction: Vec3) -> Vec3 {
    let coordinate = |i: u32| i as f32 - 1.0;
    (0..27)
        .map(|i| Vec3::new(coordinate(i % 3), coordinate(i / 3 % 3), coordinate(i / 9)).normalize_or_zero())
        .max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
        .expect("there are 27")
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Mat4;
    use probelight_math::sampling::Rng;

    use super::*;

    const RESOLUTION: u32 = 512;

    fn bounds() -> Bounds {
        Bounds { min: Vec3::new(-3.0, 0.0, 2.0), max: Vec3::new(9.0, 4.0, 5.0) }
    }

    fn eye() -> Camera {
        Camera {
            name: "eye".into(),
            position: Vec3::new(1.0, 2.0, 3.0),
            target: Vec3::new(4.0, 1.0, 3.5),
            up: Vec3::Y,
            vertical_fov: 0.9,
            width: 640,
            height: 400,
        }
    }

    fn sun() -> Light {
        Light::Directional { direction: Vec3::new(0.3, -0.8, 0.1).normalize(), irradiance: Vec3::ONE }
    }

    fn lamp(position: Vec3) -> Light {
        Light::Point { position, intensity: Vec3::ONE, range: None }
    }

    fn spot(position: Vec3, towards: Vec3, outer_angle: f32) -> Light {
        Light::Spot {
            position,
            direction: (towards - position).normalize(),
            intensity: Vec3::ONE,
            inner_angle: 0.0,
            outer_angle,
            range: None,
        }
    }

    fn project(view: &ShadowViewRecord, point: Vec3) -> Vec3 {
        Mat4::from_cols_array_2d(&view.clip_from_world).project_point3(point)
    }

    /// Clip-space distance from the middle within which a view's own share lies.
    fn core() -> f32 {
        1.0 - (2 * GUARD_TEXELS) as f32 / RESOLUTION as f32
    }

    /// Points that an eye sees up to a distance.
    fn seen(eye: &Camera, reach: f32) -> impl Iterator<Item = Vec3> {
        let forward = (eye.target - eye.position).normalize();
        (0..12u32).map(move |i| {
            let corner = Vec2::new((i % 2 * eye.width) as f32, (i / 2 % 2 * eye.height) as f32);
            let ray = eye.ray_direction(corner);
            eye.position + ray * ((i / 4) as f32 * 0.5 * reach / ray.dot(forward))
        })
    }

    #[test]
    fn views_hold_what_the_eye_sees() {
        let mut rng = Rng::new(3, 0);
        let mut windows = 0;
        for _ in 0..200 {
            let b = bounds();
            let position = b.min + b.size() * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
            let lights = [sun(), lamp(position), spot(position, eye().target, 0.9)];
            let views = EyeViews::new(&lights, &b, RESOLUTION, &eye());
            assert_eq!(views.first[0], 0, "suns come first");
            assert!(views.records.len() <= eye_view_count(&lights));
            for (first, light) in views.first.iter().zip(&lights).filter(|(first, _)| **first != NO_VIEW) {
                for (i, reach) in EYE_REACHES.into_iter().enumerate() {
                    let view = &views.records[*first as usize + i];
                    if *view == nowhere() {
                        continue;
                    }
                    windows += usize::from(!matches!(light, Light::Directional { .. }));
                    for point in seen(&eye(), reach * b.diagonal()) {
                        let ndc = project(view, point).truncate().abs().max_element();
                        assert!(ndc < core() + 2.5 / RESOLUTION as f32, "{ndc} at {point} of {light:?}");
                    }
                }
            }
        }
        assert!(windows > 100, "{windows} windows of lamps");
    }

    #[test]
    fn windows_are_finer_than_the_faces_of_a_cube() {
        let lights = [lamp(Vec3::new(8.5, 3.5, 2.2)), spot(Vec3::new(8.5, 3.5, 2.2), Vec3::ONE, 0.9)];
        let views = EyeViews::new(&lights, &bounds(), RESOLUTION, &eye());
        let face = 2.0 / (RESOLUTION - 2 * GUARD_TEXELS) as f32;
        for first in views.first {
            let [fine, coarse] = [0, 1].map(|i| views.records[first as usize + i].texel_width / face);
            assert!(fine < 0.3 && fine < coarse && coarse < WIDEST_WINDOW, "{fine} {coarse}");
        }
        // Behind the eye, out of range and beside the cone there is nothing to see.
        let away = spot(Vec3::new(8.5, 3.5, 2.2), Vec3::new(20.0, 3.5, 2.2), 0.3);
        let mut weak = lamp(Vec3::new(8.5, 3.5, 2.2));
        if let Light::Point { range, .. } = &mut weak {
            *range = Some(1.0);
        }
        assert_eq!(EyeViews::new(&[away, weak], &bounds(), RESOLUTION, &eye()).first, [NO_VIEW; 2]);
    }

    #[test]
    fn the_brightest_lamps_have_views() {
        let far = |i: u32| lamp(Vec3::new(8.9, 3.9, 2.1 + 0.1 * i as f32));
        let mut lights: Vec<_> = (0..20).map(far).collect();
        lights.push(sun());
        if let Light::Point { intensity, .. } = &mut lights[13] {
            *intensity *= 9.0;
        }
        let views = EyeViews::new(&lights, &bounds(), RESOLUTION, &eye());
        assert_eq!(views.records.len(), eye_view_count(&lights));
        assert_eq!([views.first[20], views.first[13]], [0, EYE_VIEWS as u32]);
        assert_eq!(views.first.iter().filter(|first| **first != NO_VIEW).count(), MAX_EYE_LIGHTS);
    }

    #[test]
    fn views_move_by_whole_texels() {
        let lights = [sun(), lamp(Vec3::new(8.5, 3.5, 2.2))];
        let views = |step: f32| {
            let offset = Vec3::new(0.017, -0.003, 0.011) * step;
            let eye = Camera { position: eye().position + offset, target: eye().target + offset, ..eye() };
            EyeViews::new(&lights, &bounds(), RESOLUTION, &eye).records
        };
        let fixed = Vec3::new(2.0, 1.0, 3.0);
        let texel = |view: &ShadowViewRecord| project(view, fixed).truncate() * 0.5 * RESOLUTION as f32;
        let (mut stays, mut other_lattice) = ([0; 2 * EYE_VIEWS], 0);
        for step in 0..40 {
            let (before, after) = (views(step as f32), views(step as f32 + 1.0));
            for (stays, (before, after)) in stays.iter_mut().zip(before.iter().zip(&after)) {
                *stays += i32::from(before == after);
                if (before.axis, before.texel_width) != (after.axis, after.texel_width) {
                    other_lattice += 1;
                    continue;
                }
                let moved = texel(after) - texel(before);
                assert!((moved - moved.round()).abs().max_element() < 2e-2, "{moved}");
            }
        }
        assert!(other_lattice < 5, "{other_lattice}");
        assert!(stays[..EYE_VIEWS].iter().all(|n| *n < 20), "a sun's follow the eye: {stays:?}");
        assert!(stays[EYE_VIEWS..].iter().all(|n| (20..40).contains(n)), "a lamp's seldom move: {stays:?}");
    }
}
