//! Scenes made of a few shapes.

use std::f32::consts::TAU;

use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{Material, Scene};

/// Triangles, counter-clockwise seen from the front.
pub(crate) type Shape = Vec<[Vec3; 3]>;

/// A parallelogram with a corner at `corner`; its front is where `u × v` points to.
pub(crate) fn sheet(corner: Vec3, u: Vec3, v: Vec3) -> Shape {
    vec![[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]
}

/// A closed box that faces outwards.
pub(crate) fn solid(low: Vec3, high: Vec3) -> Shape {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * (high - low));
    [(low, x, z), (low + y, z, x), (low, y, x), (low + z, x, y), (low, z, y), (low + x, y, z)]
        .into_iter()
        .flat_map(|(corner, u, v)| sheet(corner, u, v))
        .collect()
}

/// The same surface seen from its other side.
pub(crate) fn turned(shape: Shape) -> Shape {
    shape.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

/// A closed upright column with `sides` sides.
pub(crate) fn column(foot: Vec3, radius: f32, height: f32, sides: u32) -> Shape {
    let rim = |i: u32| {
        let (sine, cosine) = (TAU * i as f32 / sides as f32).sin_cos();
        foot + radius * Vec3::new(cosine, 0.0, sine)
    };
    let up = Vec3::Y * height;
    (0..sides)
        .map(|i| (rim(i), rim(i + 1)))
        .flat_map(|(a, b)| [[a, a + up, b + up], [a, b + up, b], [foot, a, b], [foot + up, b + up, a + up]])
        .collect()
}

/// A scene of grey shapes of albedo ½, each single- or double-sided.
pub(crate) fn scene_of(shapes: Vec<(Shape, bool)>) -> Scene {
    let material = |double_sided| Material {
        base_color: Vec4::new(0.5, 0.5, 0.5, 1.0),
        double_sided,
        ..Material::default()
    };
    let mut scene = Scene { materials: [false, true].map(material).to_vec(), ..Scene::default() };
    for (shape, double_sided) in shapes {
        for corners in shape {
            let first = scene.positions.len() as u32;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            scene.positions.extend(corners);
            scene.normals.extend([normal; 3]);
            scene.tangents.extend([normal.any_orthonormal_vector().extend(1.0); 3]);
            scene.uv0.extend([Vec2::ZERO; 3]);
            scene.triangles.push([first, first + 1, first + 2]);
            scene.triangle_material.push(u32::from(double_sided));
        }
    }
    scene.validate().unwrap();
    scene
}
