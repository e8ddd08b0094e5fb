//! Changes to a document.

use std::mem::Discriminant;

use probelight_runtime::SurfaceColors;
use probelight_scene::{Camera, Keyframe, Light, LightMotion, ObjectPath, Placement, Sky};

use super::document::{Document, Item, Selection};

/// A change to a document. One that names what is not there changes nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Adds a light and selects it.
    AddLight(Light),
    /// Adds another light like this one, and selects it.
    CopyLight(Item),
    /// Removes a light.
    RemoveLight(Item),
    /// Gives a light other properties.
    SetLight(Item, Light),
    /// Calls a light something else.
    NameLight(Item, String),
    /// Lets a light move, or stand still.
    SetMotion(Item, LightMotion),
    /// Another sky.
    SetSky(Sky),
    /// Factor on all emission.
    SetEmissiveScale(f32),
    /// Colours of a material.
    SetMaterial(usize, SurfaceColors),
    /// Adds an object and selects it.
    AddObject(ObjectPath),
    /// Removes an object.
    RemoveObject(Item),
    /// Puts an object somewhere: all of its path moves along.
    PlaceObject(Item, Placement),
    /// The clip that an object plays.
    SetClip(Item, Option<String>),
    /// Whether an object opens and shuts ways for light.
    SetDoor(Item, bool),
    /// Notes where an object is at a time, seconds.
    AddObjectKey(Item, f32, Placement),
    /// Lets an object stand where it begins.
    ClearObjectKeys(Item),
    /// Adds a camera, or another place for one of this name.
    SetCamera(Camera),
    /// Removes a camera.
    RemoveCamera(usize),
}

/// What an edit is about: edits with equal keys that follow each other are one step to undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct EditKey(Discriminant<Edit>, u64);

impl Edit {
    /// For the list of steps to undo.
    pub fn description(&self) -> &'static str {
        match self {
            Self::AddLight(_) => "add a light",
            Self::CopyLight(_) => "copy a light",
            Self::RemoveLight(_) => "remove a light",
            Self::SetLight(..) => "change a light",
            Self::NameLight(..) => "rename a light",
            Self::SetMotion(..) => "change a light's motion",
            Self::SetSky(_) => "change the sky",
            Self::SetEmissiveScale(_) => "change emission",
            Self::SetMaterial(..) => "change a material",
            Self::AddObject(_) => "add an object",
            Self::RemoveObject(_) => "remove an object",
            Self::PlaceObject(..) => "move an object",
            Self::SetClip(..) => "change a clip",
            Self::SetDoor(..) => "make an object a door, or none",
            Self::AddObjectKey(..) => "add a keyframe",
            Self::ClearObjectKeys(_) => "remove keyframes",
            Self::SetCamera(_) => "keep a camera",
            Self::RemoveCamera(_) => "remove a camera",
        }
    }

    /// `None` if it is a step of its own.
    pub(super) fn key(&self) -> Option<EditKey> {
        let about = match self {
            Self::SetLight(item, _)
            | Self::NameLight(item, _)
            | Self::SetMotion(item, _)
            | Self::PlaceObject(item, _) => item.0,
            Self::SetMaterial(material, _) => *material as u64,
            Self::SetSky(_) | Self::SetEmissiveScale(_) => 0,
            _ => return None,
        };
        Some(EditKey(std::mem::discriminant(self), about))
    }

    /// Changes the document, and what is selected if something new is to be.
    pub(super) fn apply(self, document: &mut Document, selection: &mut Selection) {
        match self {
            Self::AddLight(light) => {
                *selection = Selection::Light(document.add_light(light, LightMotion::Still));
            }
            Self::CopyLight(item) => {
                if let Some(entry) = document.light(item).cloned() {
                    *selection = Selection::Light(document.add_light(entry.light, entry.motion));
                }
            }
            Self::RemoveLight(item) => document.lights.retain(|entry| entry.item != item),
            Self::SetLight(item, light) => set(document.light_mut(item).map(|entry| &mut entry.light), light),
            Self::NameLight(item, name) => set(document.light_mut(item).map(|entry| &mut entry.name), name),
            Self::SetMotion(item, motion) => {
                set(document.light_mut(item).map(|entry| &mut entry.motion), motion);
            }
            Self::SetSky(sky) => document.sky = sky,
            Self::SetEmissiveScale(scale) => document.emissive_scale = scale,
            Self::SetMaterial(material, colors) => set(document.materials.get_mut(material), colors),
            Self::AddObject(path) => *selection = Selection::Object(document.add_object(path)),
            Self::RemoveObject(item) => document.objects.retain(|entry| entry.item != item),
            Self::PlaceObject(item, placement) => {
                if let Some(entry) = document.object_mut(item) {
                    place(&mut entry.path, placement);
                }
            }
            Self::SetClip(item, clip) => {
                set(document.object_mut(item).map(|entry| &mut entry.path.clip), clip);
            }
            Self::SetDoor(item, is_door) => {
                set(document.object_mut(item).map(|entry| &mut entry.path.is_door), is_door);
            }
            Self::AddObjectKey(item, time, placement) => {
                if let Some(entry) = document.object_mut(item) {
                    add_key(&mut entry.path.keyframes, Keyframe { time, placement });
                }
            }
            Self::ClearObjectKeys(item) => {
                if let Some(entry) = document.object_mut(item) {
                    entry.path.keyframes.truncate(1);
                }
            }
            Self::SetCamera(camera) => match document.cameras.iter_mut().find(|c| c.name == camera.name) {
                Some(known) => *known = camera,
                None => document.cameras.push(camera),
            },
            Self::RemoveCamera(camera) if camera < document.cameras.len() => {
                document.cameras.remove(camera);
            }
            Self::RemoveCamera(_) => {}
        }
        if !document.has(*selection) {
            *selection = Selection::Nothing;
        }
    }
}

fn set<T>(place: Option<&mut T>, value: T) {
    if let Some(place) = place {
        *place = value;
    }
}

/// Moves the first keyframe to a place, the others by as much; all turn and grow with it.
fn place(path: &mut ObjectPath, placement: Placement) {
    let Some(first) = path.keyframes.first().map(|key| key.placement) else { return };
    let turn = placement.rotation * first.rotation.inverse();
    for key in &mut path.keyframes {
        key.placement.translation += placement.translation - first.translation;
        key.placement.rotation = (turn * key.placement.rotation).normalize();
        key.placement.scale = placement.scale;
    }
}

/// Keeps the order of time, and one keyframe for each.
fn add_key(keyframes: &mut Vec<Keyframe>, key: Keyframe) {
    keyframes.retain(|other| other.time != key.time);
    let next = keyframes.partition_point(|other| other.time < key.time);
    keyframes.insert(next, key);
}
