//! Models that move in themselves: nodes and skins, moved by clips.

use std::sync::Arc;

use probelight_math::glam::{Mat3, Mat4, Quat, Vec3, Vec4};

use crate::Scene;

/// A model with the nodes and skins that move it, and clips of how they do.
#[derive(Clone, Debug)]
pub struct AnimatedModel {
    pub(crate) rest: Arc<Scene>,
    /// Parents before their children.
    pub(crate) nodes: Vec<Node>,
    pub(crate) parts: Vec<Part>,
    pub(crate) skins: Vec<Skin>,
    pub(crate) clips: Vec<Clip>,
}

/// A node of the tree.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Index in the file.
    pub(crate) index: usize,
    /// Place among the nodes.
    pub(crate) parent: Option<usize>,
    pub(crate) rest: NodeTransform,
}

/// From a node's space to its parent's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeTransform {
    pub(crate) translation: Vec3,
    pub(crate) rotation: Quat,
    pub(crate) scale: Vec3,
}

/// Vertices that move with a node, or with the joints of a skin.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// The first of them in the scene.
    pub(crate) first_vertex: usize,
    /// Place among the nodes.
    pub(crate) node: usize,
    pub(crate) node_from_mesh: Mat4,
    pub(crate) skin: Option<usize>,
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) tangents: Vec<Vec4>,
    /// Of each vertex, the joints of the skin that move it; empty without a skin.
    pub(crate) joints: Vec<[u16; 4]>,
    /// How much each of them does.
    pub(crate) weights: Vec<Vec4>,
}

/// The joints that move a skinned mesh.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// Place among the nodes, and the way from the mesh to the joint in its bind pose.
    pub(crate) joints: Vec<(usize, Mat4)>,
}

/// A movement of nodes.
#[derive(Clone, Debug)]
pub(crate) struct Clip {
    pub(crate) name: String,
    pub(crate) duration: f32,
    pub(crate) channels: Vec<Channel>,
}

/// How one property of a node changes.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    /// Place among the nodes.
    pub(crate) node: usize,
    pub(crate) property: Property,
    pub(crate) interpolation: Interpolation,
    /// Seconds, growing.
    pub(crate) times: Vec<f32>,
    /// One for each time; of cubic splines three: tangent before, value, tangent behind.
    pub(crate) values: Vec<Vec4>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Property {
    Translation,
    Rotation,
    Scale,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

impl AnimatedModel {
    /// The model at rest, as [`load_gltf`](crate::load_gltf) reads it.
    pub fn rest(&self) -> &Arc<Scene> {
        &self.rest
    }

    /// Names of the clips, in the order of the file.
    pub fn clips(&self) -> impl ExactSizeIterator<Item = &str> {
        self.clips.iter().map(|clip| &*clip.name)
    }

    /// The clip of a name.
    pub fn clip(&self, name: &str) -> Option<usize> {
        self.clips.iter().position(|clip| clip.name == name)
    }

    /// How long a clip is, seconds; 0 for clips that do not exist.
    pub fn duration(&self, clip: usize) -> f32 {
        self.clips.get(clip).map_or(0.0, |clip| clip.duration)
    }

    /// The model at a time of a clip, seconds; after its end the clip begins anew. Without such a clip, with its skins in the
    /// pose of the nodes at rest.
    #[must_use]
    pub fn pose(&self, clip: Option<usize>, time: f32) -> Scene {
        let mut local: Vec<NodeTransform> = self.nodes.iter().map(|node| node.rest).collect();
        if let Some(clip) = clip.and_then(|clip| self.clips.get(clip)) {
            let time = if clip.duration > 0.0 { time.rem_euclid(clip.duration) } else { 0.0 };
            for channel in &clip.channels {
                channel.apply(&mut local[channel.node], time);
            }
        }
        let mut world: Vec<Mat4> = Vec::with_capacity(self.nodes.len());
        for (node, local) in self.nodes.iter().zip(&local) {
            let matrix =
                Mat4::from_scale_rotation_translation(local.scale, local.rotation, local.translation);
            world.push(node.parent.map_or(matrix, |parent| world[parent] * matrix));
        }
        let mut scene = Scene::clone(&self.rest);
        for part in &self.parts {
            let joints = part.skin.map(|skin| {
                let joints = self.skins[skin].joints.iter();
                joints.map(|(node, inverse_bind)| world[*node] * *inverse_bind).collect::<Vec<_>>()
            });
            let rigid = world[part.node] * part.node_from_mesh;
            part.place(&mut scene, |vertex| match &joints {
                Some(joints) if !part.joints.is_empty() => part.blended(joints, vertex),
                _ => rigid,
            });
        }
        scene
    }
}

impl Part {
    /// Moves its vertices by the matrix of each.
    fn place(&self, scene: &mut Scene, matrix: impl Fn(usize) -> Mat4) {
        for (i, position) in self.positions.iter().enumerate() {
            let (vertex, matrix) = (self.first_vertex + i, matrix(i));
            let linear = Mat3::from_mat4(matrix);
            let mirror = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
            let cofactors = Mat3::from_cols(
                linear.y_axis.cross(linear.z_axis),
                linear.z_axis.cross(linear.x_axis),
                linear.x_axis.cross(linear.y_axis),
            );
            let placed = matrix.transform_point3(*position);
            if !placed.is_finite() {
                continue;
            }
            let normal = (mirror * (cofactors * self.normals[i])).normalize_or(scene.normals[vertex]);
            let tangent = (linear * self.tangents[i].truncate()).reject_from_normalized(normal);
            scene.positions[vertex] = placed;
            scene.normals[vertex] = normal;
            let tangent = tangent.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
            scene.tangents[vertex] = tangent.extend(mirror * self.tangents[i].w);
        }
    }

    /// Mean of the matrices of a vertex's joints, by weight.
    fn blended(&self, joints: &[Mat4], vertex: usize) -> Mat4 {
        let weights = self.weights[vertex] / self.weights[vertex].element_sum();
        let weighted = self.joints[vertex].iter().zip(weights.to_array());
        weighted.fold(Mat4::ZERO, |sum, (joint, weight)| sum + joints[usize::from(*joint)] * weight)
    }
}

impl Channel {
    fn apply(&self, local: &mut NodeTransform, time: f32) {
        let value = self.value(time);
        match self.property {
            Property::Translation => local.translation = value.truncate(),
            Property::Scale => local.scale = value.truncate(),
            Property::Rotation => local.rotation = Quat::from_vec4(value).normalize(),
        }
    }

    /// The value at a time; before the first and after the last key it stays.
    fn value(&self, time: f32) -> Vec4 {
        let next = self.times.partition_point(|key| *key <= time);
        let last = self.times.len() - 1;
        let (from, to) = (next.saturating_sub(1), next.min(last));
        let key = |index: usize| match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * index + 1],
            _ => self.values[index],
        };
        if from == to || next == 0 {
            return key(to);
        }
        let span = self.times[to] - self.times[from];
        let t = (time - self.times[from]) / span;
        match self.interpolation {
            Interpolation::Step => key(from),
            Interpolation::Linear if self.property == Property::Rotation => {
                let [a, b] = [from, to].map(|index| Quat::from_vec4(key(index)).normalize());
                Vec4::from(a.slerp(b, t))
            }
            Interpolation::Linear => key(from).lerp(key(to), t),
            Interpolation::CubicSpline => {
                let (leaving, arriving) = (self.values[3 * from + 2] * span, self.values[3 * to] * span);
                let (squared, cubed) = (t * t, t * t * t);
                key(from) * (2.0 * cubed - 3.0 * squared + 1.0)
                    + leaving * (cubed - 2.0 * squared + t)
                    + key(to) * (3.0 * squared - 2.0 * cubed)
                    + arriving * (cubed - squared)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(interpolation: Interpolation, values: Vec<Vec4>) -> Channel {
        let (property, times) = (Property::Translation, vec![1.0, 3.0]);
        Channel { node: 0, property, interpolation, times, values }
    }

    #[test]
    fn values_stay_before_the_first_key_and_after_the_last() {
        let linear = channel(Interpolation::Linear, vec![Vec4::ZERO, Vec4::X]);
        let x = |time| linear.value(time).x;
        assert_eq!([0.0, 1.0, 2.0, 2.5, 3.0, 9.0].map(x), [0.0, 0.0, 0.5, 0.75, 1.0, 1.0]);
    }

    #[test]
    fn steps_jump_and_splines_leave_and_arrive_along_their_tangents() {
        let step = channel(Interpolation::Step, vec![Vec4::ZERO, Vec4::X]);
        assert_eq!([1.0, 2.9, 3.0].map(|time| step.value(time).x), [0.0, 0.0, 1.0]);
        let (still, steep) = (Vec4::ZERO, Vec4::X);
        let spline =
            channel(Interpolation::CubicSpline, vec![still, Vec4::ZERO, steep, still, Vec4::X, still]);
        assert_eq!([1.0, 3.0].map(|time| spline.value(time).x), [0.0, 1.0]);
        // Slope 1 per second at the first key, 0 at the last.
        let slope = |time: f32| (spline.value(time + 1e-3).x - spline.value(time - 1e-3).x) / 2e-3;
        assert!((slope(1.002) - 1.0).abs() < 0.02 && slope(2.998).abs() < 0.02, "{}", slope(1.002));
    }

    #[test]
    fn rotations_turn_evenly() {
        let turn = Quat::from_rotation_y(1.0);
        let values = vec![Vec4::from(Quat::IDENTITY), Vec4::from(turn)];
        let rotation = Channel { property: Property::Rotation, ..channel(Interpolation::Linear, values) };
        let found = Quat::from_vec4(rotation.value(1.5));
        assert!(found.abs_diff_eq(Quat::from_rotation_y(0.25), 1e-6), "{found}");
    }
}
