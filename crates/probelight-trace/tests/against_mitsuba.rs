//! Our path tracer against Mitsuba 3, point by point. `tests/data` holds the first 200 surface points of
//! references made with 4,096 to 16,384 paths a point.

mod agreement;

use std::path::Path;
use std::sync::Arc;

use agreement::{Agreement, ESTIMATED_PARTS, ReferencePoint, delta_mismatches, read_reference};
use probelight_math::glam::Vec3;
use probelight_scene::{Lighting, Setup, load_gltf};
use probelight_trace::{PathTracer, PointIrradiance, Silent, Tracer};

/// Paths a point: enough for a standard error of the mean below one per cent.
const SAMPLES: u32 = 2048;

fn data(name: &str) -> (Vec<ReferencePoint>, Setup, Arc<Tracer>) {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let reference = read_reference(&crate_folder.join(format!("tests/data/{name}.csv")));
    let setup = Setup::load(&crate_folder.join(format!("tests/data/{name}.json"))).unwrap();
    let scene = load_gltf(&crate_folder.join("../../assets/scenes").join(&setup.scene)).unwrap();
    (reference, setup, Arc::new(Tracer::new(Arc::new(scene))))
}

fn estimates(
    tracer: Arc<Tracer>,
    lighting: Lighting,
    reference: &[ReferencePoint],
    samples: u32,
) -> Vec<PointIrradiance> {
    let points: Vec<(Vec3, Vec3)> = reference.iter().map(|point| (point.position, point.normal)).collect();
    PathTracer::new(tracer, lighting).irradiance_of_points(&points, samples, 17, &Silent).unwrap()
}

fn assert_agrees(name: &str, samples: u32) {
    let (reference, setup, tracer) = data(name);
    let ours = estimates(tracer, setup.lighting, &reference, samples);
    for (what, part) in ESTIMATED_PARTS {
        if let Some(agreement) = Agreement::of(part, &ours, &reference) {
            assert!(agreement.is_convincing(), "{name}, {what}: {agreement:?}");
        }
    }
    assert!(delta_mismatches(&ours, &reference) <= 0.01, "{name}: shadows differ");
}

#[test]
fn furnace_agrees() {
    assert_agrees("furnace", SAMPLES);
}

#[test]
fn cornell_box_with_a_point_light_agrees() {
    assert_agrees("cornell_point", SAMPLES);
}

#[test]
fn cornell_box_with_its_area_light_agrees() {
    assert_agrees("cornell_area", SAMPLES);
}

#[test]
fn cornell_box_with_a_spot_agrees() {
    assert_agrees("cornell_spot", SAMPLES);
}

#[test]
fn rooms_under_sun_and_sky_agree() {
    // Few points see the sky, and those little of it.
    assert_agrees("rooms_sunsky", 4 * SAMPLES);
}

/// Negative control: three per cent more light, or less than that of albedo, must not pass for the same.
#[test]
fn wrong_light_and_wrong_albedo_are_noticed() {
    let (reference, setup, tracer) = data("cornell_area");
    let indirect = ESTIMATED_PARTS[2].1;
    let convinces = |tracer: Arc<Tracer>, lighting: Lighting| {
        let ours = estimates(tracer, lighting, &reference, SAMPLES);
        Agreement::of(indirect, &ours, &reference).unwrap().is_convincing()
    };
    assert!(convinces(tracer.clone(), setup.lighting.clone()));
    let brighter = Lighting { emissive_scale: 1.03, ..setup.lighting.clone() };
    assert!(!convinces(tracer.clone(), brighter));

    let mut scene = (**tracer.scene()).clone();
    for material in &mut scene.materials {
        material.base_color *= 0.97;
    }
    assert!(!convinces(Arc::new(Tracer::new(Arc::new(scene))), setup.lighting));
}
