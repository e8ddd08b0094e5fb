//! The node tree, flattened to world space.

use std::collections::HashMap;

use gltf::Document;
use probelight_math::glam::{Mat3, Mat4, Vec2, Vec3};

use super::instancing::{claimed_copies, node_from_copies};
use super::lights::{camera_at_node, light_at_node};
use super::materials::Materials;
use super::primitives::{Primitive, import_primitive};
use super::resources::Resources;
use super::tangents::arbitrary_tangent;
use super::topology::{MAX_TRIANGLES, claimed_triangles};
use super::{Reason, Warnings};
use crate::animated_model::Part;
use crate::{Scene, SourceInstance, SourceTriangle};

/// Collects world-space triangles, lights and cameras of the default scene, in the order of its tree; of all
/// root nodes if there is no scene. `parts` gets the vertices of each
/// node as it moves them, if that is asked for.
pub(super) fn flatten(
    document: &Document,
    resources: &Resources<'_>,
    materials: &Materials,
    nodes: &[PlacedNode<'_>],
    warnings: &mut Warnings,
    parts: Option<&mut Vec<Part>>,
) -> Result<Scene, Reason> {
    check_triangle_count(document, nodes)?;
    let (scene, meshes) = (Scene::default(), HashMap::new());
    let mut flattener = Flattener { document, resources, materials, warnings, scene, parts, meshes };
    for (place, node) in nodes.iter().enumerate() {
        flattener.add_node(node, place)?;
    }
    Ok(flattener.finish())
}

/// A visible node.
pub(super) struct PlacedNode<'a> {
    pub(super) node: gltf::Node<'a>,
    /// The place of its parent among the visible nodes.
    pub(super) parent: Option<usize>,
    world_from_node: Mat4,
}

/// All visible nodes of the tree with their transforms, parents first.
pub(super) fn placed_nodes<'a>(
    document: &'a Document,
    warnings: &mut Warnings,
) -> Result<Vec<PlacedNode<'a>>, Reason> {
    let mut placed: Vec<PlacedNode<'_>> = Vec::new();
    let mut visited = vec![false; document.nodes().len()];
    // An explicit stack: files may nest deeper than the program's own.
    let mut stack: Vec<_> = root_nodes(document).into_iter().map(|node| (node, None)).collect();
    stack.reverse();
    while let Some((node, parent)) = stack.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(format!("nodes[{}] has two parents or is its own ancestor", node.index()));
        }
        if is_hidden(&node) {
            warnings.add(
                "hidden nodes, left out with all below them; show them before the export if they matter",
                1,
            );
            continue;
        }
        let world_from_parent = parent.map_or(Mat4::IDENTITY, |parent: usize| placed[parent].world_from_node);
        let world_from_node = world_from_parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        if !world_from_node.is_finite() {
            return Err(format!("the transform of nodes[{}] is not finite", node.index()));
        }
        let first_child = stack.len();
        stack.extend(node.children().map(|child| (child, Some(placed.len()))));
        stack[first_child..].reverse();
        placed.push(PlacedNode { node, parent, world_from_node });
    }
    Ok(placed)
}

/// Whether a node is switched off (`KHR_node_visibility`).
fn is_hidden(node: &gltf::Node<'_>) -> bool {
    let visibility = node.extension_value("KHR_node_visibility");
    visibility.and_then(|extension| extension.get("visible")?.as_bool()) == Some(false)
}

/// Refuses more triangles than can be used before any is read: instances and accessors that primitives share
/// let a small file claim any number.
fn check_triangle_count(document: &Document, nodes: &[PlacedNode<'_>]) -> Result<(), Reason> {
    let mut of_mesh = Vec::new();
    for mesh in document.meshes() {
        of_mesh.push(mesh.primitives().map(|p| claimed_triangles(&p)).fold(0, usize::saturating_add));
    }
    let of_node = |node: &gltf::Node<'_>| {
        let of_copy = node.mesh().map_or(0, |mesh| of_mesh[mesh.index()]);
        of_copy.saturating_mul(claimed_copies(document, node))
    };
    let triangles = nodes.iter().map(|placed| of_node(&placed.node)).fold(0, usize::saturating_add);
    if triangles > MAX_TRIANGLES {
        return Err(format!(
            "with all instances it claims {triangles} triangles; at most {MAX_TRIANGLES} can be used"
        ));
    }
    Ok(())
}

fn root_nodes(document: &Document) -> Vec<gltf::Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut is_child = vec![false; document.nodes().len()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    document.nodes().filter(|node| !is_child[node.index()]).collect()
}

struct Flattener<'a> {
    document: &'a Document,
    resources: &'a Resources<'a>,
    materials: &'a Materials,
    warnings: &'a mut Warnings,
    scene: Scene,
    parts: Option<&'a mut Vec<Part>>,
    /// Each mesh is read once, however many nodes show it.
    meshes: HashMap<usize, Vec<Primitive>>,
}

impl Flattener<'_> {
    fn add_node(&mut self, placed: &PlacedNode<'_>, place: usize) -> Result<(), Reason> {
        let PlacedNode { node, world_from_node, .. } = placed;
        let world_from_node = *world_from_node;
        if let Some(light) = node.light() {
            self.scene.lights.extend(light_at_node(&light, world_from_node, self.warnings));
        }
        if let Some(camera) = node.camera() {
            let fallback = format!("camera {}", camera.index());
            let name = camera.name().or(node.name()).unwrap_or(&fallback);
            self.scene.cameras.extend(camera_at_node(&camera, name, world_from_node, self.warnings));
        }
        let Some(mesh) = node.mesh() else { return Ok(()) };
        if !self.meshes.contains_key(&mesh.index()) {
            let primitives = self.import_mesh(&mesh)?;
            self.meshes.insert(mesh.index(), primitives);
        }
        let at_node = |reason: Reason| format!("nodes[{}]: {reason}", node.index());
        let copies = node_from_copies(self.document, node, self.resources).map_err(at_node)?;
        for (copy, node_from_copy) in copies.into_iter().enumerate() {
            for primitive in &self.meshes[&mesh.index()] {
                self.scene.sources.instances.push(SourceInstance {
                    node: node.index() as u32,
                    node_name: node.name().unwrap_or_default().into(),
                    copy: copy as u32,
                    mesh: mesh.index() as u32,
                    mesh_name: mesh.name().unwrap_or_default().into(),
                    primitive: primitive.index,
                });
                let first_vertex = self.scene.positions.len();
                if let Some(parts) = &mut self.parts {
                    parts.push(part_of(primitive, first_vertex, place, node_from_copy));
                }
                let world_from_copy = world_from_node * node_from_copy;
                append_instance(&mut self.scene, primitive, world_from_copy, self.warnings)
                    .map_err(at_node)?;
            }
        }
        Ok(())
    }

    fn import_mesh(&mut self, mesh: &gltf::Mesh<'_>) -> Result<Vec<Primitive>, Reason> {
        let mut primitives = Vec::new();
        for source in mesh.primitives() {
            let primitive = import_primitive(&source, self.resources, self.materials, self.warnings)
                .map_err(|reason| {
                    format!("meshes[{}].primitives[{}]: {reason}", mesh.index(), source.index())
                })?;
            primitives.extend(primitive);
        }
        Ok(primitives)
    }

    fn finish(self) -> Scene {
        let mut scene = self.scene;
        if !scene.uv1.is_empty() {
            scene.uv1.resize(scene.positions.len(), Vec2::ZERO);
        }
        scene
    }
}

/// The vertices of a primitive as a node moves them.
fn part_of(primitive: &Primitive, first_vertex: usize, node: usize, node_from_mesh: Mat4) -> Part {
    Part {
        first_vertex,
        node,
        node_from_mesh,
        skin: None,
        positions: primitive.positions.clone(),
        normals: primitive.normals.clone(),
        tangents: primitive.tangents.clone(),
        joints: primitive.joints.clone(),
        weights: primitive.weights.clone(),
    }
}

/// Appends a primitive in world space, as triangles of the last source instance. Under a mirroring transform
/// triangles are wound the other way round, so that their front face stays the front face.
fn append_instance(
    scene: &mut Scene,
    primitive: &Primitive,
    world_from_mesh: Mat4,
    warnings: &mut Warnings,
) -> Result<(), Reason> {
    let linear = Mat3::from_mat4(world_from_mesh);
    let mirror = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    // The inverse transpose up to a positive factor, and defined for flattening transforms too.
    let normal_matrix = Mat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    ) * mirror;

    let first = scene.positions.len() as u32;
    scene.positions.extend(primitive.positions.iter().map(|p| world_from_mesh.transform_point3(*p)));
    if scene.positions[first as usize..].iter().any(|position| !position.is_finite()) {
        return Err("its transform moves a vertex out of the range of numbers".into());
    }
    let normals = primitive.normals.iter().map(|n| (normal_matrix * *n).normalize_or(Vec3::Y));
    scene.normals.extend(normals);
    for (tangent, normal) in primitive.tangents.iter().zip(&scene.normals[first as usize..]) {
        let direction = (linear * tangent.truncate()).reject_from_normalized(*normal).try_normalize();
        let sign = if tangent.w < 0.0 { -mirror } else { mirror };
        scene.tangents.push(direction.map_or(arbitrary_tangent(*normal), |t| t.extend(sign)));
    }
    scene.uv0.extend(&primitive.uv0);
    if !primitive.uv1.is_empty() {
        scene.uv1.resize(first as usize, Vec2::ZERO);
        scene.uv1.extend(&primitive.uv1);
    }

    let instance = scene.sources.instances.len() as u32 - 1;
    let mut without_area = 0;
    for (triangle, [a, b, c]) in primitive.triangles.iter().enumerate() {
        let corners = if mirror < 0.0 { [a, c, b] } else { [a, b, c] };
        scene.triangles.push(corners.map(|v| first + v));
        if scene.area(scene.triangles.len() - 1) > 0.0 {
            scene.triangle_material.push(primitive.material);
            scene.sources.triangles.push(SourceTriangle { instance, triangle: triangle as u32 });
        } else {
            scene.triangles.pop();
            without_area += 1;
        }
    }
    warnings.add("triangles without area, left out; no light meets them", without_area);
    Ok(())
}
