//! The same answer whatever the number of threads, and an early end when asked.

mod scenes;

use probelight_math::glam::Vec3;
use probelight_scene::{Camera, Lighting, Sky};
use probelight_trace::{Cancelled, PathTracer, Progress, Silent};
use scenes::{closed_box, material, path_tracer};

fn lit_box() -> PathTracer {
    let lighting = Lighting { sky: Sky::Uniform(Vec3::ONE), ..Lighting::default() };
    path_tracer(closed_box(Vec3::splat(2.0), material(0.5, 1.0)), lighting)
}

fn view() -> Camera {
    Camera {
        name: String::new(),
        position: Vec3::new(0.5, 0.6, 0.7),
        target: Vec3::ONE,
        up: Vec3::Y,
        vertical_fov: 1.0,
        width: 20,
        height: 10,
    }
}

fn points() -> Vec<(Vec3, Vec3)> {
    (0..40).map(|i| (Vec3::new(0.04 * i as f32 + 0.1, 0.0, 0.5), Vec3::Y)).collect()
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let tracer = lit_box();
    let image = |threads| with_threads(threads, || tracer.render(&view(), 4, 11, &Silent).unwrap());
    assert_eq!(image(1), image(3));
    let irradiance =
        |threads| with_threads(threads, || tracer.irradiance_of_points(&points(), 32, 11, &Silent).unwrap());
    assert_eq!(irradiance(1), irradiance(3));
}

#[test]
fn seeds_and_points_have_their_own_random_numbers() {
    let tracer = lit_box();
    let first = tracer.render(&view(), 4, 1, &Silent).unwrap();
    let second = tracer.render(&view(), 4, 2, &Silent).unwrap();
    assert!(first.iter().zip(&second).any(|(a, b)| a != b));
    let same_place = [(Vec3::new(1.0, 0.0, 1.0), Vec3::Y); 2];
    let twice = tracer.irradiance_of_points(&same_place, 32, 1, &Silent).unwrap();
    assert_ne!(twice[0], twice[1]);
}

struct Impatient;

impl Progress for Impatient {
    fn begin(&self, _stage: &str, _total: u64) {}

    fn advance(&self, _steps: u64) {}

    fn is_cancelled(&self) -> bool {
        true
    }
}

#[test]
fn cancelled_work_ends_with_an_error() {
    let tracer = lit_box();
    assert_eq!(tracer.render(&view(), 4, 1, &Impatient).unwrap_err(), Cancelled);
    assert_eq!(tracer.irradiance_of_points(&points(), 32, 1, &Impatient).unwrap_err(), Cancelled);
}
