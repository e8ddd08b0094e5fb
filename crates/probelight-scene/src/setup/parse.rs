//! The setup format, version 1.

use probelight_math::glam::Vec3;
use serde_json::Value;

use super::Setup;
use super::fields::{Field, Object};
use super::light_motion::{LightTrack, light_track};
use super::materials::materials;
use super::objects::objects;
use crate::{Bounds, Camera, Light, Lighting, Sky};

/// Reads a setup from its JSON text.
pub(super) fn parse(text: &str) -> Result<Setup, String> {
    let document: Value = serde_json::from_str(text).map_err(|error| format!("it is not JSON ({error})"))?;
    let root = Field::root(&document).object()?;
    root.allow_only(&[
        "version",
        "name",
        "scene",
        "use_emissive",
        "emissive_scale",
        "lights",
        "cameras",
        "eval_bounds",
        "objects",
        "materials",
    ])?;
    let version = root.required("version")?;
    if version.number()? != 1.0 {
        return Err(version.error("only version 1 can be read"));
    }
    let (lighting, light_tracks) = lighting(&root)?;
    Ok(Setup {
        name: root.required("name")?.text()?.into(),
        scene: root.required("scene")?.text()?.into(),
        lighting,
        light_tracks,
        cameras: cameras(&root.required("cameras")?)?,
        eval_bounds: root.optional("eval_bounds").map(|field| bounds(&field)).transpose()?,
        objects: root.optional("objects").map(|field| objects(&field)).transpose()?.unwrap_or_default(),
        materials: root.optional("materials").map(|field| materials(&field)).transpose()?.unwrap_or_default(),
    })
}

fn lighting(root: &Object<'_>) -> Result<(Lighting, Vec<LightTrack>), String> {
    let scale = match root.optional("emissive_scale") {
        Some(field) => field.number_within(0.0, f32::MAX)?,
        None => 1.0,
    };
    let use_emissive = root.required("use_emissive")?.boolean()?;
    let mut lighting =
        Lighting { emissive_scale: if use_emissive { scale } else { 0.0 }, ..Lighting::default() };
    let mut tracks = Vec::new();
    let mut has_sky = false;
    for field in root.required("lights")?.array()? {
        let members = field.object()?;
        if members.required("type")?.text()? != "sky" {
            lighting.lights.push(light(&field)?);
            tracks.push(light_track(&members)?);
        } else if has_sky {
            return Err(field.error("there can be only one sky"));
        } else {
            lighting.sky = sky(&members)?;
            has_sky = true;
        }
    }
    // A setup whose lights stand still, without names, is the same as one that never heard of them.
    let last = tracks.iter().rposition(|track| *track != LightTrack::default());
    tracks.truncate(last.map_or(0, |last| last + 1));
    Ok((lighting, tracks))
}

/// Reads a light that is no sky.
pub(super) fn light(field: &Field<'_>) -> Result<Light, String> {
    let light = field.object()?;
    let kind = light.required("type")?;
    let parsed = match kind.text()? {
        "point" => point_light(&light)?,
        "spot" => spot_light(&light)?,
        "directional" => directional_light(&light)?,
        other => {
            let reason = format!("\"{other}\" is no type of light; allowed: point, spot, directional, sky");
            return Err(kind.error(reason));
        }
    };
    parsed.validate().map_err(|unusable| field.error(unusable))?;
    Ok(parsed)
}

fn point_light(light: &Object<'_>) -> Result<Light, String> {
    light.allow_only(&["type", "position", "intensity", "range", "name", "motion"])?;
    Ok(Light::Point {
        position: light.required("position")?.vector()?,
        intensity: light.required("intensity")?.color()?,
        range: range(light)?,
    })
}

fn spot_light(light: &Object<'_>) -> Result<Light, String> {
    let of_lamps = ["type", "position", "direction", "intensity", "range", "name", "motion"];
    light.allow_only(&[&of_lamps[..], &["inner_deg", "outer_deg"]].concat())?;
    let outer_degrees = light.required("outer_deg")?.number_within(0.0, 180.0)?;
    let inner_degrees = light.required("inner_deg")?.number_within(0.0, outer_degrees)?;
    Ok(Light::Spot {
        position: light.required("position")?.vector()?,
        direction: light.required("direction")?.direction()?,
        intensity: light.required("intensity")?.color()?,
        inner_angle: inner_degrees.to_radians(),
        outer_angle: outer_degrees.to_radians(),
        range: range(light)?,
    })
}

/// Where the light of a lamp ends, metres, if it does.
fn range(light: &Object<'_>) -> Result<Option<f32>, String> {
    light.optional("range").map(|field| field.number()).transpose()
}

fn directional_light(light: &Object<'_>) -> Result<Light, String> {
    light.allow_only(&["type", "direction", "irradiance", "name", "motion"])?;
    let direction = light.required("direction")?.direction()?;
    Ok(Light::Directional { direction, irradiance: light.required("irradiance")?.color()? })
}

fn sky(light: &Object<'_>) -> Result<Sky, String> {
    if light.has("radiance") {
        light.allow_only(&["type", "radiance"])?;
        return Ok(Sky::Uniform(light.required("radiance")?.color()?));
    }
    light.allow_only(&["type", "radiance", "zenith", "horizon", "ground"])?;
    if !["zenith", "horizon", "ground"].iter().any(|name| light.has(name)) {
        return Err(light.error("a sky needs either radiance, or zenith, horizon and ground"));
    }
    Ok(Sky::Gradient {
        zenith: light.required("zenith")?.color()?,
        horizon: light.required("horizon")?.color()?,
        ground: light.required("ground")?.color()?,
    })
}

fn cameras(field: &Field<'_>) -> Result<Vec<Camera>, String> {
    let mut cameras: Vec<Camera> = Vec::new();
    for field in field.array()? {
        let camera = camera(&field)?;
        if cameras.iter().any(|other| other.name == camera.name) {
            return Err(field.error(format!("there is already a camera \"{}\"", camera.name)));
        }
        cameras.push(camera);
    }
    Ok(cameras)
}

fn camera(field: &Field<'_>) -> Result<Camera, String> {
    let members = field.object()?;
    members.allow_only(&["name", "position", "target", "up", "vfov_deg", "width", "height"])?;
    let camera = Camera {
        name: members.required("name")?.text()?.into(),
        position: members.required("position")?.vector()?,
        target: members.required("target")?.vector()?,
        up: members.required("up")?.direction()?,
        vertical_fov: members.required("vfov_deg")?.number()?.to_radians(),
        width: members.required("width")?.count()?,
        height: members.required("height")?.count()?,
    };
    camera.validate().map_err(|unusable| field.error(unusable))?;
    Ok(camera)
}

fn bounds(field: &Field<'_>) -> Result<Bounds, String> {
    let corners = field.array()?.iter().map(Field::vector).collect::<Result<Vec<Vec3>, _>>()?;
    match corners[..] {
        [min, max] if min.cmple(max).all() => Ok(Bounds { min, max }),
        [_, _] => Err(field.error("the first corner must not exceed the second")),
        _ => Err(field.error("two corners expected, the smallest and the largest")),
    }
}
