//! Scenes built by hand, whose light is known on paper.

#![allow(dead_code, reason = "each test binary builds some of these")]

use std::sync::Arc;

use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{Lighting, Material, Scene};
use probelight_trace::{PathTracer, Tracer};

/// Adds a parallelogram whose front face looks along `cross(edge_u, edge_v)`.
pub(crate) fn add_quad(scene: &mut Scene, corner: Vec3, edge_u: Vec3, edge_v: Vec3, material: u32) {
    let first = scene.positions.len() as u32;
    let normal = edge_u.cross(edge_v).normalize();
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        scene.positions.push(corner + edge_u * u + edge_v * v);
        scene.normals.push(normal);
        scene.tangents.push(edge_u.normalize().extend(1.0));
        scene.uv0.push(Vec2::new(u, v));
    }
    scene.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    scene.triangle_material.extend([material; 2]);
}

/// A Lambertian material that may shine.
pub(crate) fn material(albedo: f32, emission: f32) -> Material {
    Material {
        base_color: Vec4::new(albedo, albedo, albedo, 1.0),
        emission: Vec3::splat(emission),
        ..Material::default()
    }
}

/// A horizontal square of `half_size`, facing up, at height 0.
pub(crate) fn floor(half_size: f32) -> Scene {
    let mut scene = Scene { materials: vec![material(0.5, 0.0)], ..Scene::default() };
    let corner = Vec3::new(-half_size, 0.0, -half_size);
    add_quad(&mut scene, corner, Vec3::Z * 2.0 * half_size, Vec3::X * 2.0 * half_size, 0);
    scene
}

/// A closed box of `size` with one corner at the origin, all faces looking inwards.
pub(crate) fn closed_box(size: Vec3, inside: Material) -> Scene {
    let mut scene = Scene { materials: vec![inside], ..Scene::default() };
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    for (edge_u, edge_v) in [(x, y), (y, z), (z, x)] {
        let across = x + y + z - edge_u - edge_v;
        add_quad(&mut scene, Vec3::ZERO, edge_u, edge_v, 0);
        add_quad(&mut scene, across, edge_v, edge_u, 0);
    }
    scene
}

/// A path tracer of a scene that must be valid.
pub(crate) fn path_tracer(scene: Scene, lighting: Lighting) -> PathTracer {
    scene.validate().expect("the scene is valid");
    PathTracer::new(Arc::new(Tracer::new(Arc::new(scene))), lighting)
}
