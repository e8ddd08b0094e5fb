//! Setup files for the figures.

use serde_json::{Value, json};

use super::workshop::Workshop;
use crate::measure::shown;

/// A camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// Metres.
    pub(crate) position: [f32; 3],
    /// What it looks at, metres.
    pub(crate) target: [f32; 3],
    /// Vertical field of view, degrees.
    pub(crate) vfov_deg: f32,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
}

/// An object that stands still.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Object<'a> {
    /// The file's name without extension.
    pub(crate) name: &'a str,
    /// Its origin, metres.
    pub(crate) position: [f32; 3],
    pub(crate) scale: f32,
    pub(crate) yaw_deg: f32,
}

/// What shines.
#[derive(Clone, Debug)]
pub(crate) enum Lights {
    /// Emissive surfaces.
    Emitters,
    /// As a setup file has them.
    Listed(Value),
}

/// A lamp of an intensity in W/sr.
pub(crate) fn lamp(position: [f32; 3], intensity: [f32; 3]) -> Lights {
    Lights::Listed(json!([{ "type": "point", "position": position, "intensity": intensity }]))
}

/// The atrium's sun and sky.
pub(crate) fn sun_and_sky() -> Lights {
    Lights::Listed(json!([
        { "type": "directional", "direction": [0.25, -1.0, 0.42], "irradiance": [20, 18, 15] },
        { "type": "sky", "radiance": [0.6, 0.9, 1.5] },
    ]))
}

/// The text of a setup file; `objects` as it has them.
pub(crate) fn setup(lights: &Lights, camera: &Camera, objects: &[Value]) -> String {
    let (use_emissive, lights) = match lights {
        Lights::Emitters => (true, json!([])),
        Lights::Listed(lights) => (false, lights.clone()),
    };
    let [width, height] = camera.size;
    json!({
        "version": 1, "name": "figure", "scene": "", "use_emissive": use_emissive, "lights": lights,
        "cameras": [{
            "name": "figure", "position": camera.position, "target": camera.target, "up": [0, 1, 0],
            "vfov_deg": camera.vfov_deg, "width": width, "height": height,
        }],
        "objects": objects,
    })
    .to_string()
}

impl Workshop {
    /// An object as setup files have it.
    pub(crate) fn placed(&self, object: &Object<'_>) -> anyhow::Result<Value> {
        let Object { name, position, scale, yaw_deg } = object;
        Ok(json!({
            "file": shown(&self.scene(name)?), "position": position, "scale": scale, "yaw_deg": yaw_deg,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn setups_say_what_shines_and_who_looks() {
        let camera = Camera { position: [0.0; 3], target: [0.0, 0.0, 1.0], vfov_deg: 40.0, size: [4, 3] };
        let text = |lights: &Lights| -> Value {
            serde_json::from_str(&setup(lights, &camera, &[json!({ "file": "a.glb" })])).unwrap()
        };
        let lit = text(&lamp([1.0, 2.0, 3.0], [9.0; 3]));
        assert_eq!((&lit["use_emissive"], &lit["lights"][0]["type"]), (&json!(false), &json!("point")));
        assert_eq!((&lit["cameras"][0]["width"], &lit["objects"][0]["file"]), (&json!(4), &json!("a.glb")));
        let emitters = text(&Lights::Emitters);
        assert_eq!((&emitters["use_emissive"], &emitters["lights"]), (&json!(true), &json!([])));
    }
}
