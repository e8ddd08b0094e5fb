//! A setup as the text of its file.

use probelight_math::glam::Vec3;
use serde_json::{Map, Value, json};

use super::light_motion::write_track;
use super::{Keyframe, MaterialColors, ObjectPath, Setup};
use crate::{Camera, Light, Sky};

impl Setup {
    /// The text of a setup file with all of this: [`parse`](Self::parse) reads it again. Numbers are written so that they
    /// read the same but for angles, which files have in degrees. Objects keep only their turn about +Y.
    pub fn to_json(&self) -> String {
        let lighting = &self.lighting;
        let sky = if lighting.sky.is_black() { None } else { Some(sky(&lighting.sky)) };
        let mut setup = json!({
            "version": 1,
            "name": self.name,
            "scene": self.scene,
            "use_emissive": lighting.emissive_scale > 0.0,
            "lights": self.lights().chain(sky).collect::<Vec<_>>(),
            "cameras": self.cameras.iter().map(camera).collect::<Vec<_>>(),
        });
        let optional = [
            ("emissive_scale", (lighting.emissive_scale > 0.0).then(|| json!(lighting.emissive_scale))),
            ("eval_bounds", self.eval_bounds.map(|bounds| json!([vector(bounds.min), vector(bounds.max)]))),
            ("objects", list(&self.objects, object)),
            ("materials", list(&self.materials, material)),
        ];
        for (name, value) in optional {
            if let Some(value) = value {
                setup[name] = value;
            }
        }
        let mut text = serde_json::to_string_pretty(&setup).unwrap_or_default();
        text.push('\n');
        text
    }

    fn lights(&self) -> impl Iterator<Item = Value> {
        self.lighting.lights.iter().enumerate().map(|(i, light)| {
            let mut members = light_members(light);
            if let Some(track) = self.light_tracks.get(i) {
                write_track(track, &mut members);
            }
            Value::Object(members)
        })
    }
}

/// A list, if there is anything in it.
fn list<T>(items: &[T], write: impl Fn(&T) -> Value) -> Option<Value> {
    (!items.is_empty()).then(|| items.iter().map(write).collect())
}

fn vector(vector: Vec3) -> Value {
    json!(vector.to_array())
}

/// The members of a light.
pub(super) fn light_members(light: &Light) -> Map<String, Value> {
    let members = match light {
        Light::Point { position, intensity, .. } => {
            json!({ "type": "point", "position": vector(*position), "intensity": vector(*intensity) })
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, .. } => json!({
            "type": "spot",
            "position": vector(*position),
            "direction": vector(*direction),
            "intensity": vector(*intensity),
            "inner_deg": inner_angle.to_degrees().min(outer_angle.to_degrees()),
            "outer_deg": outer_angle.to_degrees().min(180.0),
        }),
        Light::Directional { direction, irradiance } => {
            json!({ "type": "directional", "direction": vector(*direction), "irradiance": vector(*irradiance) })
        }
    };
    let mut members = members.as_object().cloned().unwrap_or_default();
    if let Light::Point { range: Some(range), .. } | Light::Spot { range: Some(range), .. } = light {
        members.insert("range".into(), json!(range));
    }
    members
}

fn sky(sky: &Sky) -> Value {
    match sky {
        Sky::Uniform(radiance) => json!({ "type": "sky", "radiance": vector(*radiance) }),
        Sky::Gradient { zenith, horizon, ground } => json!({
            "type": "sky",
            "zenith": vector(*zenith),
            "horizon": vector(*horizon),
            "ground": vector(*ground),
        }),
    }
}

fn camera(camera: &Camera) -> Value {
    json!({
        "name": camera.name,
        "position": vector(camera.position),
        "target": vector(camera.target),
        "up": vector(camera.up),
        "vfov_deg": camera.vertical_fov.to_degrees(),
        "width": camera.width,
        "height": camera.height,
    })
}

fn object(object: &ObjectPath) -> Value {
    let mut written = Map::from_iter([("file".into(), json!(object.file.to_string_lossy()))]);
    if let Some(clip) = &object.clip {
        written.insert("clip".into(), json!(clip));
    }
    if object.is_door {
        written.insert("door".into(), json!(true));
    }
    match &object.keyframes[..] {
        [only] => written.extend(placement(only)),
        keyframes => {
            let timed = |key: &Keyframe| {
                let mut members = placement(key);
                members.insert("time".into(), json!(key.time));
                Value::Object(members)
            };
            written.insert("path".into(), keyframes.iter().map(timed).collect());
        }
    }
    Value::Object(written)
}

fn placement(key: &Keyframe) -> Map<String, Value> {
    let (yaw, _, _) = key.placement.rotation.to_euler(probelight_math::glam::EulerRot::YXZ);
    Map::from_iter([
        ("position".into(), vector(key.placement.translation)),
        ("yaw_deg".into(), json!(yaw.to_degrees())),
        ("scale".into(), json!(key.placement.scale)),
    ])
}

fn material(material: &MaterialColors) -> Value {
    let mut written = Map::from_iter([("name".into(), json!(material.name))]);
    for (name, color) in [("base_color", material.base_color), ("emission", material.emission)] {
        if let Some(color) = color {
            written.insert(name.into(), vector(color));
        }
    }
    Value::Object(written)
}

impl Camera {
    /// The camera as it stands in a setup file.
    pub fn to_setup_json(&self) -> String {
        serde_json::to_string_pretty(&camera(self)).unwrap_or_default()
    }
}
