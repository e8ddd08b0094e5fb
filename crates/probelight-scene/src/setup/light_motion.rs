//! Lights of a setup that move by themselves.

use std::f32::consts::TAU;

use probelight_math::glam::{Quat, Vec3};
use serde_json::{Map, Value, json};

use super::Setup;
use super::fields::{Field, Object};
use super::keys::keys_at;
use super::parse::light;
use super::write::light_members;
use crate::{Light, Lighting};

/// What a setup says of a light besides how it shines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTrack {
    /// For people; may be empty.
    pub name: String,
    /// How it moves.
    pub motion: LightMotion,
}

/// How a light moves. Times are seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum LightMotion {
    /// Not at all.
    #[default]
    Still,
    /// Lamps go round in a level circle, metres; suns turn about the vertical.
    Circle {
        /// Of a lamp's circle.
        radius: f32,
        /// Of one turn.
        period: f32,
    },
    /// A sun rises in the east (+X), stands in the south (+Z) at noon and sets; at night it is out.
    Day {
        /// From one midnight to the next.
        period: f32,
    },
    /// Brightness wavers as that of a flame.
    Flicker {
        /// Largest loss, as a share.
        strength: f32,
    },
    /// From one keyframe to the next, and again from the first: time, light. They come in the order of time.
    Keyframes(Vec<(f32, Light)>),
}

/// Height of the noon sun, radians.
const NOON: f32 = 0.9;

/// Frequencies of a flame, hertz: what does not repeat soon looks as if by chance.
const FLAME: [f32; 3] = [1.3, 3.7, 8.1];

impl LightMotion {
    /// A light at a time.
    pub fn at(&self, light: &Light, time: f32) -> Light {
        let mut moved = light.clone();
        match self {
            Self::Still => {}
            Self::Circle { radius, period } => {
                let angle = TAU * time / period.max(1e-3);
                match &mut moved {
                    Light::Point { position, .. } | Light::Spot { position, .. } => {
                        // It begins where the light is.
                        *position += *radius * Vec3::new(angle.cos() - 1.0, 0.0, angle.sin());
                    }
                    Light::Directional { direction, .. } => {
                        *direction = (Quat::from_rotation_y(angle) * *direction).normalize();
                    }
                }
            }
            Self::Day { period } => {
                if let Light::Directional { direction, irradiance } = &mut moved {
                    let hour = (24.0 * time / period.max(1e-3)).rem_euclid(24.0);
                    let (towards, height) = sun_at(hour);
                    *direction = -towards;
                    // The last degrees before the horizon dim it, so that it neither appears nor vanishes.
                    *irradiance *= (height / 0.1).clamp(0.0, 1.0);
                }
            }
            Self::Flicker { strength } => {
                let waver: f32 = FLAME.iter().map(|frequency| (TAU * frequency * time).sin()).sum();
                *moved.strength_mut() *= 1.0 - strength.clamp(0.0, 1.0) * (0.5 + waver / 6.0);
            }
            Self::Keyframes(keys) => moved = between(keys, time).unwrap_or(moved),
        }
        moved
    }

    /// When the last keyframe is.
    pub fn end(&self) -> f32 {
        match self {
            Self::Keyframes(keys) => keys.last().map_or(0.0, |(time, _)| *time),
            _ => 0.0,
        }
    }
}

/// Where the sun of the [day](LightMotion::Day) is at an hour, 0 to 24: unit vector towards it, and the sine of its height.
pub fn sun_at(hour: f32) -> (Vec3, f32) {
    let angle = TAU * (hour - 6.0) / 24.0;
    let noon = Vec3::new(0.0, NOON.sin(), NOON.cos());
    let towards = (Vec3::X * angle.cos() + noon * angle.sin()).normalize();
    (towards, towards.y)
}

impl Setup {
    /// All light at a time, seconds, with lights that move by themselves where they are then.
    pub fn lighting_at(&self, time: f32) -> Lighting {
        let mut lighting = self.lighting.clone();
        for (light, track) in lighting.lights.iter_mut().zip(&self.light_tracks) {
            *light = track.motion.at(light, time);
        }
        lighting
    }
}

/// Reads what a light's members say besides how it shines.
pub(super) fn light_track(members: &Object<'_>) -> Result<LightTrack, String> {
    let name = members.optional("name").map(|name| name.text()).transpose()?.unwrap_or_default().into();
    let motion = members.optional("motion").map(|field| motion(&field, members)).transpose()?;
    Ok(LightTrack { name, motion: motion.unwrap_or_default() })
}

fn motion(field: &Field<'_>, of_light: &Object<'_>) -> Result<LightMotion, String> {
    let members = field.object()?;
    let kind = members.required("type")?;
    let seconds = |name| members.required(name)?.number_within(1e-3, f32::MAX);
    match kind.text()? {
        "circle" => {
            members.allow_only(&["type", "radius", "period"])?;
            let radius = members.optional("radius").map_or(Ok(0.0), |radius| radius.number())?;
            Ok(LightMotion::Circle { radius, period: seconds("period")? })
        }
        "day" if of_light.required("type")?.text()? != "directional" => {
            Err(kind.error("only directional lights have days"))
        }
        "day" => {
            members.allow_only(&["type", "period"])?;
            Ok(LightMotion::Day { period: seconds("period")? })
        }
        "flicker" => {
            members.allow_only(&["type", "strength"])?;
            Ok(LightMotion::Flicker { strength: members.required("strength")?.number_within(0.0, 1.0)? })
        }
        "keyframes" => {
            members.allow_only(&["type", "keyframes"])?;
            keyframes(&members.required("keyframes")?, of_light).map(LightMotion::Keyframes)
        }
        other => {
            let reason = "is no motion of a light; allowed: circle, day, flicker, keyframes";
            Err(kind.error(format!("\"{other}\" {reason}")))
        }
    }
}

/// Keyframes say what is other than in the light itself.
fn keyframes(field: &Field<'_>, of_light: &Object<'_>) -> Result<Vec<(f32, Light)>, String> {
    let mut keys: Vec<(f32, Light)> = Vec::new();
    for field in field.array()? {
        let members = field.object()?;
        let time = members.required("time")?.number_within(0.0, f32::MAX)?;
        if keys.last().is_some_and(|(last, _)| *last >= time) {
            return Err(field.error("times must grow from one keyframe to the next"));
        }
        let all = of_light.with_members_of(&members, &["name", "motion", "time"]);
        keys.push((time, light(&field.of_same_path(&all))?));
    }
    if keys.is_empty() {
        return Err(field.error("at least one keyframe is needed"));
    }
    Ok(keys)
}

/// Writes what [`light_track`] reads.
pub(super) fn write_track(track: &LightTrack, members: &mut Map<String, Value>) {
    if !track.name.is_empty() {
        members.insert("name".into(), json!(track.name));
    }
    let motion = match &track.motion {
        LightMotion::Still => return,
        LightMotion::Circle { radius, period } => {
            json!({ "type": "circle", "radius": radius, "period": period })
        }
        LightMotion::Day { period } => json!({ "type": "day", "period": period }),
        LightMotion::Flicker { strength } => json!({ "type": "flicker", "strength": strength }),
        LightMotion::Keyframes(keys) => {
            let key = |(time, light): &(f32, Light)| {
                let mut members = light_members(light);
                members.remove("type");
                members.insert("time".into(), json!(time));
                Value::Object(members)
            };
            json!({ "type": "keyframes", "keyframes": keys.iter().map(key).collect::<Vec<_>>() })
        }
    };
    members.insert("motion".into(), motion);
}

/// A light between its keyframes, which begin anew after the last.
fn between(keys: &[(f32, Light)], time: f32) -> Option<Light> {
    let end = keys.last()?.0;
    let time = if end > 0.0 { time % end } else { 0.0 };
    let (from, next) = keys_at(keys, time, |(time, _)| *time)?;
    Some(next.map_or_else(|| from.1.clone(), |(to, share)| blend(&from.1, &to.1, share)))
}

/// A light so far on the way to another of its kind; lights of two kinds do not blend.
fn blend(from: &Light, to: &Light, share: f32) -> Light {
    let turn = |a: Vec3, b: Vec3| a.lerp(b, share).try_normalize().unwrap_or(a);
    let scalar = |a: f32, b: f32| a + (b - a) * share;
    let mut light = from.clone();
    match (&mut light, to) {
        (
            Light::Point { position, intensity, range },
            Light::Point { position: p, intensity: i, range: r },
        ) => {
            (*position, *intensity) = (position.lerp(*p, share), intensity.lerp(*i, share));
            *range = range.zip(*r).map(|(a, b)| scalar(a, b)).or(*range);
        }
        (
            Light::Spot { position, direction, intensity, inner_angle, outer_angle, .. },
            Light::Spot { position: p, direction: d, intensity: i, inner_angle: n, outer_angle: o, .. },
        ) => {
            (*position, *intensity) = (position.lerp(*p, share), intensity.lerp(*i, share));
            *direction = turn(*direction, *d);
            (*inner_angle, *outer_angle) = (scalar(*inner_angle, *n), scalar(*outer_angle, *o));
        }
        (
            Light::Directional { direction, irradiance },
            Light::Directional { direction: d, irradiance: i },
        ) => {
            (*direction, *irradiance) = (turn(*direction, *d), irradiance.lerp(*i, share));
        }
        _ => {}
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun() -> Light {
        Light::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance: Vec3::ONE }
    }

    fn lamp(x: f32) -> Light {
        Light::Point { position: Vec3::X * x, intensity: Vec3::splat(x), range: None }
    }

    #[test]
    fn circles_begin_and_end_where_the_light_is() {
        let circle = LightMotion::Circle { radius: 2.0, period: 4.0 };
        for light in [lamp(1.0), sun()] {
            assert_eq!(circle.at(&light, 0.0), light);
            let (Light::Point { position: there, .. } | Light::Directional { direction: there, .. }) =
                circle.at(&light, 4.0)
            else {
                unreachable!()
            };
            let (Light::Point { position: here, .. } | Light::Directional { direction: here, .. }) = light
            else {
                unreachable!()
            };
            assert!(there.abs_diff_eq(here, 1e-5));
        }
        let Light::Point { position, .. } = circle.at(&lamp(1.0), 2.0) else { unreachable!() };
        assert!(position.abs_diff_eq(Vec3::new(-3.0, 0.0, 0.0), 1e-5), "{position}");
    }

    #[test]
    fn days_have_a_morning_a_noon_and_a_night() {
        let day = LightMotion::Day { period: 24.0 };
        let at = |hour| match day.at(&sun(), hour) {
            Light::Directional { direction, irradiance } => (direction, irradiance.x),
            _ => unreachable!(),
        };
        assert!(at(6.5).0.x < -0.9 && at(17.5).0.x > 0.9, "from the east, then from the west");
        assert!(at(12.0).0.y < -0.7 && at(12.0).1 == 1.0);
        assert_eq!(at(0.0).1, 0.0);
        assert!(at(6.2).1 < at(6.3).1, "it rises without a leap");
    }

    #[test]
    fn flames_waver_within_their_strength_and_keyframes_blend() {
        let flicker = LightMotion::Flicker { strength: 0.4 };
        let brightness = |time: f32| match flicker.at(&lamp(1.0), time) {
            Light::Point { intensity, .. } => intensity.x,
            _ => unreachable!(),
        };
        let all: Vec<_> = (0..500).map(|i| brightness(i as f32 * 0.013)).collect();
        assert!(all.iter().all(|b| (0.6..=1.0).contains(b)));
        assert!(all.iter().any(|b| *b < 0.7) && all.iter().any(|b| *b > 0.9));
        let keys = LightMotion::Keyframes(vec![(0.0, lamp(0.0)), (2.0, lamp(4.0))]);
        assert_eq!(keys.at(&lamp(9.0), 0.5), lamp(1.0));
        assert_eq!(keys.at(&lamp(9.0), 2.5), lamp(1.0), "and again");
        assert_eq!(LightMotion::Keyframes(vec![]).at(&lamp(9.0), 1.0), lamp(9.0));
    }
}
