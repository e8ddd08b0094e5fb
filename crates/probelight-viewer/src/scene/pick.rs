//! What is at a place of the picture.

use std::sync::Arc;

use probelight_asset::{BakedScene, ERROR_STEPS, NONE};
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::SurfaceColors;
use probelight_scene::{Camera, Lighting};
use probelight_trace::{Hit, PathTracer, PointIrradiance, Ray, Silent, Tracer};

use super::live_scene::LiveScene;
use super::reference_picture::colored;
use crate::state::document::Item;

/// Paths of the reference at a place.
const PATHS: u32 = 4096;

/// What a ray from the eye met.
#[derive(Clone, Debug)]
pub enum Picked {
    /// The sky.
    Nothing,
    /// An object.
    Object(Item, Vec3),
    /// A surface of the scene.
    Surface(Box<PickedSurface>),
}

/// A place on a surface of the scene.
#[derive(Clone, Debug)]
pub struct PickedSurface {
    /// World position, metres.
    pub position: Vec3,
    /// Unit normal of the side that was met.
    pub normal: Vec3,
    /// Index of the triangle.
    pub triangle: u32,
    /// Index of its material.
    pub material: usize,
    /// The material's name.
    pub material_name: String,
    /// Name of the node in the file.
    pub node: String,
    /// Where its light is kept, if it has light of its own.
    pub light: Option<PickedTexel>,
}

/// Where a surface's light is kept.
#[derive(Clone, Debug)]
pub struct PickedTexel {
    /// Column and row in the lightmap.
    pub texel: [u32; 2],
    /// The receiver there and its cluster.
    pub receiver: Option<PickedReceiver>,
}

/// A receiver and what serves it.
#[derive(Clone, Debug)]
pub struct PickedReceiver {
    /// Number of the receiver.
    pub receiver: u32,
    /// Number of its cluster.
    pub cluster: usize,
    /// Receivers of the cluster.
    pub receivers: u32,
    /// Singular values of the cluster.
    pub rank: u32,
    /// Columns of ΣVᵀ.
    pub columns: usize,
    /// Error of the compressed transport, as a share of the wanted one.
    pub error: f32,
    /// The probes that serve it.
    pub probes: Vec<u32>,
}

/// What the camera sees at a pixel (pixels from the top left corner).
pub fn pick(live: &LiveScene, camera: &Camera, pixel: Vec2) -> Picked {
    let ray = Ray::new(camera.position, camera.ray_direction(pixel));
    let surface = live.tracer.closest_hit(&ray);
    let nearest = surface.as_ref().map_or(f32::INFINITY, |hit| hit.distance);
    match nearest_object(live, &ray, nearest) {
        Some((item, distance)) => Picked::Object(item, ray.origin + ray.direction * distance),
        None => {
            surface.map_or(Picked::Nothing, |hit| Picked::Surface(Box::new(surface_at(live, &ray, &hit))))
        }
    }
}

/// The nearest object that is nearer than something else.
fn nearest_object(live: &LiveScene, ray: &Ray, farthest: f32) -> Option<(Item, f32)> {
    let mut nearest = None;
    let mut limit = farthest;
    for (item, object) in live.placed_objects() {
        let placement = object.placement();
        let model = object.model();
        let origin = placement.local_point(ray.origin);
        let direction = placement.local_direction(ray.direction);
        // A handful of models of some thousand triangles: no tree is needed for a click.
        for triangle in 0..model.triangles.len() {
            let Some(distance) = meets(model.corners(triangle), origin, direction) else { continue };
            let distance = distance * placement.scale;
            if distance < limit {
                limit = distance;
                nearest = Some((item, distance));
            }
        }
    }
    nearest
}

/// Distance to where a ray meets a triangle (Möller and Trumbore 1997).
fn meets([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let (ab, ac, from_a) = (b - a, c - a, origin - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    let u = from_a.dot(across) / determinant;
    let v = direction.dot(from_a.cross(ab)) / determinant;
    let distance = ac.dot(from_a.cross(ab)) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}

fn surface_at(live: &LiveScene, ray: &Ray, hit: &Hit) -> PickedSurface {
    let (baked, scene) = (&live.baked, live.scene());
    let material = scene.triangle_material[hit.triangle as usize] as usize;
    let source = scene.sources.triangles.get(hit.triangle as usize);
    let node = source.and_then(|source| scene.sources.instances.get(source.instance as usize));
    PickedSurface {
        position: ray.origin + ray.direction * hit.distance,
        normal: live.tracer.side_normal(hit.triangle, hit.is_back_face),
        triangle: hit.triangle,
        material,
        material_name: scene.materials[material].name.clone(),
        node: node.map(|node| node.node_name.clone()).unwrap_or_default(),
        light: texel_at(baked, hit),
    }
}

fn texel_at(baked: &BakedScene, hit: &Hit) -> Option<PickedTexel> {
    let texel = baked.lightmap.texel(hit.triangle, hit.is_back_face, hit.barycentric)?;
    let receiver = baked.receivers_of_texels()[texel as usize];
    let column_row = [texel % baked.lightmap.width, texel / baked.lightmap.width];
    Some(PickedTexel {
        texel: column_row,
        receiver: (receiver != NONE).then(|| receiver_of(baked, receiver)).flatten(),
    })
}

/// What is known of a receiver.
pub fn receiver_of(baked: &BakedScene, receiver: u32) -> Option<PickedReceiver> {
    let holds = |cluster: &probelight_asset::Cluster| {
        (cluster.first_receiver..cluster.first_receiver + cluster.receiver_count).contains(&receiver)
    };
    let number = baked.clusters.iter().position(holds)?;
    let cluster = &baked.clusters[number];
    let error = baked.receiver_errors.get(receiver as usize).map_or(0.0, |e| f32::from(*e) / ERROR_STEPS);
    Some(PickedReceiver {
        receiver,
        cluster: number,
        receivers: cluster.receiver_count,
        rank: cluster.rank(),
        columns: baked.column_count(cluster),
        error,
        probes: baked.probes_of(cluster).to_vec(),
    })
}

/// What arrives at a place by the path tracer: takes a moment.
pub fn reference_at(
    live_tracer: &Arc<Tracer>,
    colors: &[SurfaceColors],
    lighting: Lighting,
    place: (Vec3, Vec3),
) -> Option<PointIrradiance> {
    let tracer = if SurfaceColors::of(live_tracer.scene()) == colors {
        Arc::clone(live_tracer)
    } else {
        Arc::new(Tracer::new(Arc::new(colored(live_tracer.scene(), colors))))
    };
    let points = PathTracer::new(tracer, lighting).irradiance_of_points(&[place], PATHS, 1, &Silent);
    points.ok()?.pop()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_triangles_in_front_of_them() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let from = Vec3::new(0.2, 0.2, 3.0);
        assert_eq!(meets(triangle, from, -Vec3::Z), Some(3.0));
        assert_eq!(meets(triangle, from, Vec3::Z), None);
        assert_eq!(meets(triangle, from + Vec3::X, -Vec3::Z), None);
        assert_eq!(meets(triangle, from, Vec3::X), None);
    }
}
