//! Levels of detail that hold the time of frames.

use std::time::Duration;

use super::lod::LodSettings;

/// Share of a new time in the smoothed one.
const SMOOTHING: f32 = 0.2;

/// Smoothed times within these shares of the target are left as they are.
const DEAD_BAND: [f32; 2] = [0.8, 1.0];

/// How much nearer levels come in a step, and how much farther.
const STEPS: [f32; 2] = [0.75, 1.1];

/// Frames between two steps: nearer soon, because slow frames are seen, farther late.
const FRAMES: [u32; 2] = [8, 60];

/// Nearest and farthest levels, as factors on their distances.
const SCALES: [f32; 2] = [1.0 / 64.0, 4.0];

/// Moves levels of detail nearer when frames take too long, and farther when there is time left.
///
/// Times are smoothed, and within a dead band nothing happens; levels come nearer quickly and go away slowly. The number
/// of relight rays stays that of the first level everywhere: another number is another quadrature, and would be seen as a
/// jump.
#[derive(Clone, Debug)]
pub struct LodGovernor {
    target: f32,
    smoothed: Option<f32>,
    scale: f32,
    frames: u32,
}

impl LodGovernor {
    /// Holds frames, or what of them is measured, at a time.
    pub fn new(target: Duration) -> Self {
        Self { target: target.as_secs_f32(), smoothed: None, scale: 1.0, frames: 0 }
    }

    /// Factor on the distances of the levels.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Takes the time of a frame. Returns whether the levels are to be [moved](Self::govern) now.
    pub fn note(&mut self, frame: Duration) -> bool {
        let time = frame.as_secs_f32();
        let smoothed = self.smoothed.map_or(time, |smoothed| smoothed + SMOOTHING * (time - smoothed));
        self.smoothed = Some(smoothed);
        self.frames += 1;
        let share = smoothed / self.target.max(f32::MIN_POSITIVE);
        let direction = match share {
            _ if share > DEAD_BAND[1] => 0,
            _ if share < DEAD_BAND[0] => 1,
            _ => return false,
        };
        if self.frames < FRAMES[direction] {
            return false;
        }
        self.frames = 0;
        let scale = (self.scale * STEPS[direction]).clamp(SCALES[0], SCALES[1]);
        let has_changed = scale != self.scale;
        self.scale = scale;
        has_changed
    }

    /// Levels at the distances that hold the time.
    pub fn govern(&self, settings: &LodSettings) -> LodSettings {
        let mut governed = settings.clone().with_distances_scaled(self.scale);
        let rays = governed.levels.first().and_then(|level| level.rays);
        governed.levels.iter_mut().for_each(|level| level.rays = rays);
        governed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LodPreset;

    /// Frames that take 2 ms and so many more as the levels are far away, with noise. Returns times and scales.
    fn play(governor: &mut LodGovernor, frames: usize, per_scale: f32) -> Vec<(f32, f32)> {
        let frame = |i: usize| {
            let noise = if i.is_multiple_of(3) { 1.3 } else { 0.85 };
            let time = (2.0 + per_scale * governor.scale()) * noise;
            governor.note(Duration::from_secs_f32(time * 1e-3));
            (time / noise, governor.scale())
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn frames_are_held_at_their_time() {
        let mut governor = LodGovernor::new(Duration::from_millis(8));
        let times = play(&mut governor, 200, 30.0);
        let (last, _) = times[199];
        assert!((5.0..8.5).contains(&last), "{last}");
        let settled = times.iter().position(|(time, _)| *time < 8.5).unwrap();
        assert!(settled < 60, "{settled} frames");
        // There they stay, whatever the noise.
        assert!(times[150..].iter().all(|(_, scale)| *scale == times[199].1), "{times:?}");
        // Lighter frames: by and by levels go away again.
        let slower = play(&mut governor, 2000, 5.0);
        let back = slower.iter().position(|(time, _)| *time > 6.0).unwrap();
        assert!(back > 2 * settled, "{back} frames, {settled} before");
    }

    #[test]
    fn relight_rays_are_not_touched() {
        let mut governor = LodGovernor::new(Duration::from_millis(1));
        play(&mut governor, 40, 30.0);
        let governed = governor.govern(&LodPreset::Published.settings());
        governed.check().unwrap();
        assert!(governed.levels[1].distance < 20.0);
        assert!(governed.levels.iter().all(|level| level.rays == Some(512)));
        assert_eq!(governed.levels[1].degree, Some(6));
    }
}
