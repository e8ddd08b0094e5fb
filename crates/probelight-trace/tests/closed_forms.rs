//! Light that can be computed on paper.

mod scenes;

use std::f32::consts::PI;

use probelight_math::glam::Vec3;
use probelight_scene::{Camera, Light, Lighting, Sky};
use probelight_trace::Silent;
use scenes::{add_quad, closed_box, floor, material, path_tracer};

fn assert_close(value: f32, expected: f32, relative: f32) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value} instead of {expected}");
}

/// Checks an estimate against its own standard error, which must be small.
fn assert_estimates(value: f32, error: f32, expected: f32) {
    assert!(error < 0.005 * expected, "standard error {error} of {expected}");
    assert!(
        (value - expected).abs() < 4.0 * error + 1e-4 * expected,
        "{value} ± {error} instead of {expected}"
    );
}

fn camera(position: Vec3, target: Vec3) -> Camera {
    let up = Vec3::new(0.0, 1.0, 0.1);
    Camera { name: String::new(), position, target, up, vertical_fov: 1.0, width: 16, height: 12 }
}

#[test]
fn constant_sky_over_a_plane_gives_pi_times_its_radiance() {
    let sky = Vec3::new(1.0, 2.0, 3.0);
    let tracer = path_tracer(floor(10.0), Lighting { sky: Sky::Uniform(sky), ..Lighting::default() });
    let found = tracer.irradiance(Vec3::new(0.3, 0.0, 0.2), Vec3::Y, 256, 1);
    assert!(found.sky.abs_diff_eq(PI * sky, 1e-4), "{found:?}");
    assert!(found.se_sky.max_element() < 1e-5);
    assert_eq!((found.delta, found.area, found.indirect), (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO));
}

#[test]
fn plane_that_faces_down_on_the_sky_reflects_its_albedo() {
    // E_sky of the lower side is 0 where the plane below hides the whole sky; here only the rim is open.
    let sky = Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() };
    let tracer = path_tracer(floor(1e4), sky);
    let below = tracer.irradiance(Vec3::Y, -Vec3::Y, 256, 1);
    assert_close(below.indirect.x, 0.5 * PI, 1e-3);
    assert!(below.sky.x < 1e-3);
}

#[test]
fn point_light_falls_on_a_plane_by_the_inverse_square_law() {
    let light =
        Light::Point { position: Vec3::new(0.0, 2.0, 0.0), intensity: Vec3::splat(10.0), range: None };
    let tracer = path_tracer(floor(10.0), Lighting { lights: vec![light], ..Lighting::default() });
    let at = |x: f32| tracer.irradiance(Vec3::new(x, 0.0, 0.1), Vec3::Y, 16, 1);
    for x in [0.0, 1.0, 4.0f32] {
        let squared = 4.0 + x * x + 0.01;
        assert_close(at(x).delta.x, 10.0 * 2.0 / squared.powf(1.5), 1e-4);
        assert_eq!(at(x).indirect, Vec3::ZERO);
    }
    let lower_side = tracer.irradiance(Vec3::new(1.0, 0.0, 0.1), -Vec3::Y, 16, 1);
    assert_eq!(lower_side.delta, Vec3::ZERO);
}

/// Irradiance (per unit radiance) of a point from a parallel rectangle with one corner right above it.
fn corner_irradiance(width: f32, length: f32, height: f32) -> f32 {
    let (a, b) = (width / height, length / height);
    let (a_root, b_root) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    0.5 * (a / a_root * (b / a_root).atan() + b / b_root * (a / b_root).atan())
}

#[test]
fn emissive_rectangle_matches_its_form_factor_and_is_dark_behind() {
    for height in [0.05, 0.5, 3.0] {
        let mut scene = floor(10.0);
        scene.materials.push(material(0.0, 4.0));
        // Facing down; its corners lie at (±0.7, ±1.1) around the point below, but for a shift.
        let corner = Vec3::new(-0.5, height, -0.8);
        add_quad(&mut scene, corner, Vec3::X * 1.4, Vec3::Z * 2.2, 1);
        let tracer = path_tracer(scene, Lighting::default());
        let expected = 4.0
            * [(0.5, 0.8), (0.9, 0.8), (0.5, 1.4), (0.9, 1.4)]
                .map(|(w, l)| corner_irradiance(w, l, height))
                .iter()
                .sum::<f32>();
        let found = tracer.irradiance(Vec3::ZERO, Vec3::Y, 4096, 3);
        assert_estimates(found.area.x, found.se_area.x, expected);
        let behind = tracer.irradiance(Vec3::new(0.0, height + 1.0, 0.0), -Vec3::Y, 256, 3);
        assert_eq!(behind.area, Vec3::ZERO);
    }
}

#[test]
fn switched_off_emitters_are_dark() {
    let lighting = Lighting { emissive_scale: 0.0, ..Lighting::default() };
    let tracer = path_tracer(closed_box(Vec3::splat(2.0), material(0.5, 1.0)), lighting);
    let found = tracer.irradiance(Vec3::new(1.0, 0.0, 1.0), Vec3::Y, 64, 1);
    assert_eq!((found.area, found.indirect), (Vec3::ZERO, Vec3::ZERO));
}

#[test]
fn furnace_has_the_same_radiance_everywhere() {
    for albedo in [0.5, 0.8] {
        let expected = 1.0 / (1.0 - albedo);
        let furnace = closed_box(Vec3::new(4.0, 3.0, 5.0), material(albedo, 1.0));
        let tracer = path_tracer(furnace, Lighting::default());
        for (position, normal) in
            [(Vec3::new(2.0, 0.0, 2.0), Vec3::Y), (Vec3::new(4.0, 0.01, 4.99), -Vec3::X)]
        {
            let found = tracer.irradiance(position, normal, 16_384, 5);
            assert_estimates(found.area.x, found.se_area.x, PI);
            assert_estimates(found.indirect.x, found.se_indirect.x, PI * (expected - 1.0));
        }
        let view = camera(Vec3::new(1.0, 1.0, 1.0), Vec3::new(3.0, 1.2, 4.0));
        let image = tracer.render(&view, 256, 7, &Silent).unwrap();
        let mean = image.iter().sum::<Vec3>() / image.len() as f32;
        assert_close(mean.x, expected, 5e-3);
        assert!(image.iter().all(|pixel| (pixel.x - expected).abs() < 0.15 * expected));
    }
}

#[test]
fn light_is_proportional_to_its_sources() {
    let box_with = |emission| closed_box(Vec3::splat(2.0), material(0.6, emission));
    let once = path_tracer(box_with(1.0), Lighting::default());
    let thrice = path_tracer(box_with(1.0), Lighting { emissive_scale: 3.0, ..Lighting::default() });
    let at = Vec3::new(0.5, 0.0, 0.5);
    let (once, thrice) = (once.irradiance(at, Vec3::Y, 64, 9), thrice.irradiance(at, Vec3::Y, 64, 9));
    assert!((3.0 * once.indirect).abs_diff_eq(thrice.indirect, 1e-4));
}
