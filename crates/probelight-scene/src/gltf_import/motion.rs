//! Skins and animations: what moves a model.
//!
//! They are read from the document as it was written: the `gltf` crate refuses files for parts of them that are not needed.

use std::collections::HashMap;

use gltf::Document;
use gltf::accessor::Dimensions;
use probelight_math::glam::{Mat4, Quat, Vec3, Vec4};
use serde_json::Value;

use super::accessors::Elements;
use super::nodes::PlacedNode;
use super::resources::Resources;
use super::{Reason, Warnings};
use crate::animated_model::{Channel, Clip, Interpolation, Node, NodeTransform, Part, Property, Skin};

/// The parts of a document that tell how it moves.
#[derive(Default)]
pub(super) struct MotionSource {
    skins: Vec<Value>,
    animations: Vec<Value>,
    /// Of each node, its skin.
    node_skins: Vec<Option<usize>>,
}

impl MotionSource {
    /// Takes them out of the document, but for the nodes' skins, which stay to be counted.
    pub(super) fn take(document: &mut Value) -> Self {
        let nodes = document.get("nodes").and_then(Value::as_array);
        let node_skins = nodes.into_iter().flatten().map(|node| index(node.get("skin"))).collect();
        let mut array = |name: &str| match document.get_mut(name).map(Value::take) {
            Some(Value::Array(values)) => values,
            _ => Vec::new(),
        };
        Self { skins: array("skins"), animations: array("animations"), node_skins }
    }
}

/// What the motion of a scene is read from.
pub(super) struct MotionInput<'a> {
    pub(super) source: &'a MotionSource,
    pub(super) document: &'a Document,
    pub(super) resources: &'a Resources<'a>,
    pub(super) nodes: &'a [PlacedNode<'a>],
    /// The scene's vertices.
    pub(super) parts: Vec<Part>,
}

/// How a model moves.
#[derive(Default)]
pub(super) struct Motion {
    pub(super) nodes: Vec<Node>,
    pub(super) parts: Vec<Part>,
    pub(super) skins: Vec<Skin>,
    pub(super) clips: Vec<Clip>,
}

impl Motion {
    /// Reads skins and clips for the nodes of a scene, and divides the scene's vertices among them.
    pub(super) fn new(input: MotionInput<'_>, warnings: &mut Warnings) -> Result<Self, Reason> {
        let MotionInput { source, document, resources, nodes: placed, parts } = input;
        let places: HashMap<usize, usize> =
            placed.iter().enumerate().map(|(place, placed)| (placed.node.index(), place)).collect();
        let reader = Reader { document, resources, places };
        let skins = source
            .skins
            .iter()
            .enumerate()
            .map(|(i, skin)| reader.skin(skin).map_err(|reason| format!("skins[{i}]: {reason}")));
        let skins: Vec<Skin> = skins.collect::<Result<_, _>>()?;
        let clips = source.animations.iter().enumerate().map(|(i, animation)| {
            let clip = reader.clip(animation, i, warnings);
            clip.map_err(|reason| format!("animations[{i}]: {reason}"))
        });
        let clips = clips.collect::<Result<Vec<_>, _>>()?;
        let nodes = placed.iter().map(|placed| {
            let (translation, rotation, scale) = placed.node.transform().decomposed();
            let rest = NodeTransform {
                translation: translation.into(),
                rotation: Quat::from_array(rotation).normalize(),
                scale: scale.into(),
            };
            Node { index: placed.node.index(), parent: placed.parent, rest }
        });
        let nodes: Vec<Node> = nodes.collect();
        let parts = parts.into_iter().map(|part| {
            let skin = source.node_skins.get(nodes[part.node].index).copied().flatten();
            let skin = skin.filter(|skin| fits(&part, skins.get(*skin)));
            Part { skin, ..part }
        });
        Ok(Self { parts: parts.collect(), nodes, skins, clips })
    }
}

/// Whether a skin has all joints that a part asks for.
fn fits(part: &Part, skin: Option<&Skin>) -> bool {
    let count = skin.map_or(0, |skin| skin.joints.len());
    let known = part.joints.iter().flatten().all(|joint| usize::from(*joint) < count);
    let weighted = part.weights.iter().all(|weights| weights.is_finite() && weights.element_sum() > 0.0);
    known && weighted && !part.joints.is_empty()
}

struct Reader<'a> {
    document: &'a Document,
    resources: &'a Resources<'a>,
    /// Of each node of the file that is shown, its place among them.
    places: HashMap<usize, usize>,
}

impl<'a> Reader<'a> {
    fn elements(&self, accessor: Option<&Value>, dimensions: Dimensions) -> Result<Elements<'a>, Reason> {
        let number = index(accessor).ok_or("an accessor is missing")?;
        let accessor =
            self.document.accessors().nth(number).ok_or("it uses an accessor that does not exist")?;
        Elements::new(&accessor, dimensions, self.resources)?.backed(&accessor)
    }

    fn skin(&self, skin: &Value) -> Result<Skin, Reason> {
        let joints = skin.get("joints").and_then(Value::as_array).ok_or("it has no joints")?;
        let inverse = match skin.get("inverseBindMatrices") {
            Some(accessor) => Some(self.elements(Some(accessor), Dimensions::Mat4)?),
            None => None,
        };
        if inverse.as_ref().is_some_and(|inverse| inverse.count < joints.len()) {
            return Err("it has fewer inverse bind matrices than joints".into());
        }
        let joint = |(i, joint): (usize, &Value)| {
            let node = index(Some(joint)).and_then(|node| self.places.get(&node));
            let node = *node.ok_or("one of its joints is no node of the scene")?;
            let matrix = inverse.as_ref().map_or(Mat4::IDENTITY, |it| Mat4::from_cols_array(&it.vector(i)));
            if matrix.is_finite() {
                Ok((node, matrix))
            } else {
                Err("an inverse bind matrix is not finite".into())
            }
        };
        Ok(Skin { joints: joints.iter().enumerate().map(joint).collect::<Result<_, Reason>>()? })
    }

    fn clip(&self, animation: &Value, number: usize, warnings: &mut Warnings) -> Result<Clip, Reason> {
        let array = |name: &str| animation.get(name).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let samplers = array("samplers");
        let mut channels = Vec::new();
        for channel in array("channels") {
            let target = channel.get("target").ok_or("a channel has no target")?;
            let property = match target.get("path").and_then(Value::as_str) {
                Some("translation") => Property::Translation,
                Some("rotation") => Property::Rotation,
                Some("scale") => Property::Scale,
                _ => {
                    warnings
                        .add("channels of animations that move no node, such as morph targets; left out", 1);
                    continue;
                }
            };
            // Nodes that are not shown may move too.
            let Some(node) = index(target.get("node")).and_then(|node| self.places.get(&node)) else {
                continue;
            };
            let sampler = index(channel.get("sampler")).and_then(|sampler| samplers.get(sampler));
            channels.push(self.channel(sampler.ok_or("a channel has no sampler")?, *node, property)?);
        }
        let duration =
            channels.iter().filter_map(|channel| channel.times.last()).fold(0.0f32, |a, b| a.max(*b));
        let name = animation.get("name").and_then(Value::as_str).map_or(format!("clip {number}"), Into::into);
        Ok(Clip { name, duration, channels })
    }

    fn channel(&self, sampler: &Value, node: usize, property: Property) -> Result<Channel, Reason> {
        let interpolation = match sampler.get("interpolation").and_then(Value::as_str) {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => return Err(format!("{other:?} is no interpolation")),
        };
        let times = self.elements(sampler.get("input"), Dimensions::Scalar)?;
        let times: Vec<f32> = (0..times.count).map(|i| times.vector::<1>(i)[0]).collect();
        if times.is_empty() || !times.is_sorted_by(|a, b| a < b) || !times.iter().all(|time| time.is_finite())
        {
            return Err("the times of a sampler do not grow".into());
        }
        let values: Vec<Vec4> = if property == Property::Rotation {
            let values = self.elements(sampler.get("output"), Dimensions::Vec4)?;
            (0..values.count).map(|i| Vec4::from(values.vector::<4>(i))).collect()
        } else {
            let values = self.elements(sampler.get("output"), Dimensions::Vec3)?;
            (0..values.count).map(|i| Vec3::from(values.vector::<3>(i)).extend(0.0)).collect()
        };
        let per_time = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if values.len() < per_time * times.len() || !values.iter().all(|value| value.is_finite()) {
            return Err("a sampler has fewer values than times, or some that are not finite".into());
        }
        Ok(Channel { node, property, interpolation, times, values })
    }
}

fn index(value: Option<&Value>) -> Option<usize> {
    value?.as_u64().and_then(|index| usize::try_from(index).ok())
}
