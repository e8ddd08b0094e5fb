//! Objects of a setup and their ways.

use std::path::PathBuf;
use std::sync::Arc;

use super::fields::{Field, Object};
use super::keys::keys_at;
use crate::{Placement, Scene, Unusable};

/// A glTF file that moves through the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPath {
    /// The file, relative to the folder of the setup.
    pub file: PathBuf,
    /// Where it is when, at least one, in the order of time.
    pub keyframes: Vec<Keyframe>,
    /// The animation of the file that it plays from the beginning on, again and again.
    pub clip: Option<String>,
    /// Whether it opens and shuts ways for light, see [`crate::Object::as_door`].
    pub is_door: bool,
}

/// Where an object is at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// Seconds from the beginning.
    pub time: f32,
    /// Where it is then.
    pub placement: Placement,
}

impl ObjectPath {
    /// The object itself, somewhere on its path, in one of its poses.
    ///
    /// # Errors
    /// See [`Object::new`](crate::Object::new).
    pub fn object(&self, model: Arc<Scene>, placement: Placement) -> Result<crate::Object, Unusable> {
        let object = crate::Object::new(model, placement)?;
        Ok(if self.is_door { object.as_door() } else { object })
    }

    /// When its last keyframe is, seconds.
    pub fn end(&self) -> f32 {
        self.keyframes.last().map_or(0.0, |key| key.time)
    }

    /// Where the object is: on a straight line between two keyframes, before the first and after the last still.
    pub fn placement(&self, time: f32) -> Placement {
        match keys_at(&self.keyframes, time, |key| key.time) {
            Some((from, Some((to, share)))) => from.placement.towards(&to.placement, share),
            Some((key, None)) => key.placement,
            None => Placement::default(),
        }
    }
}

/// Reads the objects of a setup.
pub(super) fn objects(field: &Field<'_>) -> Result<Vec<ObjectPath>, String> {
    field.array()?.iter().map(object_path).collect()
}

fn object_path(field: &Field<'_>) -> Result<ObjectPath, String> {
    let members = field.object()?;
    let file = members.required("file")?.text()?.into();
    let clip = members.optional("clip").map(|clip| clip.text()).transpose()?.map(Into::into);
    let is_door = members.optional("door").map(|door| door.boolean()).transpose()?.unwrap_or(false);
    let Some(path) = members.optional("path") else {
        members.allow_only(&["file", "clip", "door", "path", "position", "yaw_deg", "scale"])?;
        let keyframes = vec![Keyframe { time: 0.0, placement: placement(field, &members)? }];
        return Ok(ObjectPath { file, keyframes, clip, is_door });
    };
    members.allow_only(&["file", "clip", "door", "path"])?;
    let mut keyframes: Vec<Keyframe> = Vec::new();
    for field in path.array()? {
        let key = field.object()?;
        key.allow_only(&["time", "position", "yaw_deg", "scale"])?;
        let time = key.required("time")?.number()?;
        if keyframes.last().is_some_and(|last| last.time >= time) {
            return Err(field.error("times must grow from one keyframe to the next"));
        }
        keyframes.push(Keyframe { time, placement: placement(&field, &key)? });
    }
    if keyframes.is_empty() {
        return Err(path.error("a path needs at least one keyframe"));
    }
    Ok(ObjectPath { file, keyframes, clip, is_door })
}

fn placement(field: &Field<'_>, members: &Object<'_>) -> Result<Placement, String> {
    let or = |name, default| members.optional(name).map_or(Ok(default), |field| field.number());
    let position = members.required("position")?.vector()?;
    let placement = Placement::upright(position, or("yaw_deg", 0.0)?.to_radians(), or("scale", 1.0)?);
    placement.validate().map_err(|unusable| field.error(unusable))?;
    Ok(placement)
}
