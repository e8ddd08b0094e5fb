//! Rays against objects at their places, and against the same triangles as a part of the scene.

use std::sync::Arc;

use probelight_math::glam::{Quat, Vec3};
use probelight_math::sampling::{hash_pair, sobol_owen};
use probelight_scene::{Object, Placement, Scene, load_gltf};
use probelight_trace::{Occluder, Ray, TracedObject, Tracer, World};

fn load(name: &str) -> Arc<Scene> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    Arc::new(load_gltf(&folder.join(name)).unwrap())
}

/// Two small Cornell boxes, turned, in a large one.
fn objects(scale: f32) -> Vec<Object> {
    let model = load("cornell.glb");
    let placement = |x: f32, angle: f32| Placement {
        translation: Vec3::new(x, 1.0, 2.0),
        rotation: Quat::from_euler(probelight_math::glam::EulerRot::XYZ, 0.3, angle, -0.2),
        scale,
    };
    [(0.5, 0.4), (3.0, 2.1)]
        .map(|(x, angle)| Object::new(Arc::clone(&model), placement(x, angle)).unwrap())
        .to_vec()
}

fn rays() -> impl Iterator<Item = Ray> {
    (0..4000).map(|i| {
        let [a, b] = [0, 1].map(|k| sobol_owen(i, hash_pair(7, k)));
        let from = Vec3::new(a.x, a.y, b.x) * 5.5;
        Ray::new(from, Vec3::new(b.y - 0.5, a.y - 0.5, a.x - 0.5).normalize_or(Vec3::X))
    })
}

/// How many rays find something else than in the merged scene.
fn differences(objects: &[Object], merged: &Tracer) -> usize {
    let still = Tracer::new(load("cornell_empty.glb"));
    let tracer = Arc::new(Tracer::new(Arc::clone(objects[0].model())));
    let traced: Vec<_> =
        objects.iter().map(|object| TracedObject::new(object, Arc::clone(&tracer))).collect();
    let world = World { tracer: &still, objects: &traced };
    let differs = |ray: &Ray| {
        let (a, b) = (world.closest_hit(ray), merged.closest_hit(ray));
        let short = Ray { max_distance: 0.8, ..*ray };
        let same_hit = match (a, b) {
            (Some(a), Some(b)) => {
                (a.hit.distance - b.distance).abs() < 1e-3
                    && a.hit.is_back_face == b.is_back_face
                    && a.hit.normal.abs_diff_eq(b.normal, 1e-3)
            }
            (None, None) => true,
            _ => false,
        };
        !same_hit || world.is_occluded(&short) != merged.is_occluded(&short)
    };
    rays().filter(differs).count()
}

#[test]
fn objects_are_met_where_their_triangles_would_be() {
    let still = load("cornell_empty.glb");
    let merged = Tracer::new(Arc::new(still.with_objects(&objects(0.3))));
    merged.scene().validate().unwrap();
    // Rays along edges may fall to either side.
    assert!(differences(&objects(0.3), &merged) <= 4, "{}", differences(&objects(0.3), &merged));
    // Somewhat larger objects are met elsewhere.
    assert!(differences(&objects(0.4), &merged) > 400, "{}", differences(&objects(0.4), &merged));
}
