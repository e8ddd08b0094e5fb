//! The window's clock: time between frames, and what the title says about it.

use std::time::{Duration, Instant};

/// How often the title changes.
const TITLE_INTERVAL: Duration = Duration::from_millis(500);

/// Longest time that things move in a frame, however long it took: after a pause nothing should leap.
const LONGEST_STEP: Duration = Duration::from_millis(100);

/// Frames and when they were.
#[derive(Debug)]
pub(super) struct FrameClock {
    last_frame: Instant,
    last_title: Instant,
    frames_since_title: u32,
}

impl FrameClock {
    pub(super) fn new(now: Instant) -> Self {
        Self { last_frame: now, last_title: now, frames_since_title: 0 }
    }

    /// Counts a frame; returns for how many seconds things move in it.
    pub(super) fn tick(&mut self, now: Instant) -> f32 {
        let step = now.duration_since(self.last_frame).min(LONGEST_STEP);
        self.last_frame = now;
        self.frames_since_title += 1;
        step.as_secs_f32()
    }

    /// The mean time of a frame since the last title, if it is time for another one.
    pub(super) fn mean_frame(&mut self, now: Instant) -> Option<Duration> {
        let elapsed = now.duration_since(self.last_title);
        if elapsed < TITLE_INTERVAL || self.frames_since_title == 0 {
            return None;
        }
        let mean = elapsed / self.frames_since_title;
        (self.last_title, self.frames_since_title) = (now, 0);
        Some(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_have_the_mean_of_the_frames_since_the_last() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut clock = FrameClock::new(start);
        assert_eq!(clock.tick(at(40)), 0.04);
        assert_eq!(clock.mean_frame(at(40)), None);
        assert_eq!(clock.tick(at(600)), 0.1, "after a pause nothing leaps");
        assert_eq!(clock.mean_frame(at(600)), Some(Duration::from_millis(300)));
        assert_eq!(clock.mean_frame(at(1200)), None, "no frame since");
    }
}
