//! Where the camera and the lights are in each frame.

use probelight_math::glam::Quat;
use probelight_scene::{Camera, CameraPath, Light, Lighting};

/// How far lamps go from one frame to the next, metres.
const LAMP_STEP: f32 = 0.02;

/// How far suns go, radians.
const SUN_STEP: f32 = 0.002;

/// Frames after which lights turn back.
const SWING: usize = 20;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum LightMotion {
    /// Lamps and suns move a little with each frame
    #[default]
    Moving,
    /// Nothing changes: frames after all light has bounced
    Still,
}

impl LightMotion {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Still => "still",
        }
    }

    /// The lights of a frame: on their way there and back, if they move.
    pub(super) fn at(self, lighting: &Lighting, frame: usize) -> Lighting {
        let phase = (frame + 1) % (2 * SWING);
        let steps = if self == Self::Moving { phase.min(2 * SWING - phase) as f32 } else { 0.0 };
        let mut lighting = lighting.clone();
        for light in &mut lighting.lights {
            match light {
                Light::Point { position, .. } | Light::Spot { position, .. } => {
                    position.x += LAMP_STEP * steps;
                }
                Light::Directional { direction, .. } => {
                    *direction = Quat::from_rotation_y(SUN_STEP * steps) * *direction;
                }
            }
        }
        lighting
    }
}

/// How the camera moves.
pub(super) enum CameraMotion {
    /// Ahead and round: metres and degrees over all frames.
    Ahead { camera: Camera, dolly: f32, turn: f32 },
    /// Past others.
    Past { name: String, path: CameraPath },
}

impl CameraMotion {
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Ahead { camera, .. } => &camera.name,
            Self::Past { name, .. } => name,
        }
    }

    /// Where it is when a share of the frames has gone by.
    pub(super) fn at(&self, share: f32) -> Camera {
        match self {
            Self::Past { path, .. } => path.at(share),
            Self::Ahead { camera, dolly, turn } => {
                let ahead = camera.target - camera.position;
                let position = camera.position + ahead.normalize() * dolly * share;
                let turned =
                    Quat::from_axis_angle(camera.up.normalize(), (turn * share).to_radians()) * ahead;
                Camera { position, target: position + turned, ..camera.clone() }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::glam::Vec3;

    #[test]
    fn lights_swing_there_and_back() {
        let lamp = Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE, range: None };
        let lighting = Lighting { lights: vec![lamp], ..Lighting::default() };
        let x = |motion: LightMotion, frame| match motion.at(&lighting, frame).lights[0] {
            Light::Point { position, .. } => position.x,
            _ => f32::NAN,
        };
        let moving = |frame| x(LightMotion::Moving, frame);
        assert_eq!(moving(0), LAMP_STEP);
        assert!((moving(SWING - 1) - SWING as f32 * LAMP_STEP).abs() < 1e-6);
        assert_eq!(moving(2 * SWING - 1), 0.0);
        let all_move = (0..100).all(|frame| (moving(frame + 1) - moving(frame)).abs() > 0.9 * LAMP_STEP);
        assert!(all_move, "light changes with each frame");
        assert_eq!(x(LightMotion::Still, 7), 0.0);
    }
}
