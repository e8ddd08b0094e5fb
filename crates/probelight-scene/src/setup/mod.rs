//! Setup files: the lights, sky, cameras, objects and colours of one picture of a scene, as JSON.

mod fields;
mod framing;
mod keys;
mod light_motion;
mod materials;
mod objects;
mod parse;
mod write;

use std::path::Path;

pub use light_motion::{LightMotion, LightTrack, sun_at};
pub use materials::MaterialColors;
pub use objects::{Keyframe, ObjectPath};

use crate::{Bounds, Camera, Lighting, SceneError};

/// Lights and cameras for one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// What the setup is called.
    pub name: String,
    /// File name of the scene it was written for.
    pub scene: String,
    /// Lights, sky and emissive switch.
    pub lighting: Lighting,
    /// Names and motions of the lights, in their order; lights beyond the last have none.
    pub light_tracks: Vec<LightTrack>,
    /// Cameras, in file order.
    pub cameras: Vec<Camera>,
    /// The region in which reference points were sampled, if not the whole scene.
    pub eval_bounds: Option<Bounds>,
    /// What moves through the scene.
    pub objects: Vec<ObjectPath>,
    /// Colours of the scene's materials that are not those of the file.
    pub materials: Vec<MaterialColors>,
}

impl Setup {
    /// Reads a setup file; [`parse`](Self::parse) says what is in one.
    ///
    /// # Errors
    /// [`SceneError::Read`] if the file cannot be read, [`SceneError::Setup`] as [`parse`](Self::parse).
    #[cfg(feature = "files")]
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| SceneError::Read { path: path.into(), source })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a setup file. Every field is checked, and unknown ones are refused. `path` is the name in errors.
    ///
    /// ```json
    /// { "version": 1, "name": "evening", "scene": "room.glb", "use_emissive": true, "emissive_scale": 1.0,
    ///   "lights": [
    ///     {"type": "point", "position": [0, 2, 0], "intensity": [9, 8, 7], "range": 6, "name": "torch",
    ///      "motion": {"type": "flicker", "strength": 0.4}},
    ///     {"type": "spot", "position": [0, 2, 0], "direction": [0, -1, 0], "intensity": [9, 8, 7],
    ///      "inner_deg": 15, "outer_deg": 25},
    ///     {"type": "directional", "direction": [1, -2, 0], "irradiance": [9, 8, 7]},
    ///     {"type": "sky", "radiance": [1, 1, 1]} ],
    ///   "cameras": [
    ///     {"name": "front", "position": [0, 1, 5], "target": [0, 1, 0], "up": [0, 1, 0],
    ///      "vfov_deg": 40, "width": 640, "height": 480} ],
    ///   "eval_bounds": [[-1, 0, -1], [1, 2, 1]],
    ///   "objects": [
    ///     {"file": "chair.glb", "position": [1, 0, 0], "yaw_deg": 90, "scale": 1.0},
    ///     {"file": "door.glb", "door": true, "position": [3, 0, 0]},
    ///     {"file": "fox.glb", "clip": "Walk", "path": [{"time": 0, "position": [0, 1, 0]}, {"time": 2, "position": [0, 1, 3]}]} ],
    ///   "materials": [ {"name": "wall", "base_color": [0.8, 0.1, 0.1], "emission": [0, 0, 0]} ] }
    /// ```
    ///
    /// Intensities are in W/sr, irradiance in W/m², radiance in W·m⁻²·sr⁻¹; spot angles are half angles.
    /// A directional light's `direction` is the way its light travels. Instead of `radiance` a sky may have
    /// `zenith`, `horizon` and `ground`. Point and spot lights may have a `range` in metres, where their light ends as
    /// `KHR_lights_punctual` defines it. A light's `motion` is one of
    ///
    /// ```json
    /// {"type": "circle", "radius": 2, "period": 12}      {"type": "day", "period": 40}      {"type": "flicker", "strength": 0.4}
    /// {"type": "keyframes", "keyframes": [{"time": 0}, {"time": 2, "position": [1, 2, 0], "intensity": [1, 1, 1]}]}
    /// ```
    ///
    /// of which [`lighting_at`](Self::lighting_at) makes the light of a time; a keyframe has the light's own fields where
    /// they differ. `range`, `name`, `motion`, `emissive_scale`, `eval_bounds`,
    /// `objects`, `materials` and the colours in these may be left out. Files of objects are looked for beside the setup; a clip
    /// is an animation of the file; a door opens and shuts ways for light; times are seconds, a yaw turns about +Y.
    ///
    /// # Errors
    /// [`SceneError::Setup`], with the path of the field and what is allowed there, if it breaks these rules.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        parse::parse(text).map_err(|reason| SceneError::Setup { path: path.into(), reason })
    }

    /// The camera of this name, or the first one.
    ///
    /// # Errors
    /// [`SceneError::Camera`], with the names there are.
    pub fn camera(&self, name: Option<&str>) -> Result<&Camera, SceneError> {
        let found = match name {
            Some(name) => self.cameras.iter().find(|camera| camera.name == name),
            None => self.cameras.first(),
        };
        found.ok_or_else(|| SceneError::Camera {
            setup: self.name.clone(),
            name: name.map(Into::into),
            available: self.cameras.iter().map(|camera| camera.name.clone()).collect(),
        })
    }
}
