//! How much the light changes from frame to frame, with levels of detail and without: what would be seen as a pop.

use probelight_math::glam::Vec3;

/// The largest changes of receivers' light between two frames, W/m² in the strongest channel.
#[derive(Default)]
pub(super) struct LightSteps {
    /// Irradiance of all receivers in the frame before, with levels of detail and without.
    before: Option<[Vec<Vec3>; 2]>,
    /// By how much a change with levels of detail exceeded that without, of the same receiver.
    excess: f32,
    /// The largest changes with and without.
    largest: [f32; 2],
    mean: f64,
}

impl LightSteps {
    /// Takes in a frame's irradiance of all receivers, with levels of detail and without.
    pub(super) fn note(&mut self, now: [&[Vec3]; 2]) {
        if let Some(before) = &self.before {
            let receivers = before[0].iter().zip(now[0]).zip(before[1].iter().zip(now[1]));
            for ((with_before, with_now), (before, now)) in receivers {
                let [with, without] =
                    [*with_now - *with_before, *now - *before].map(|change| change.abs().max_element());
                self.excess = self.excess.max(with - without);
                self.largest = [self.largest[0].max(with), self.largest[1].max(without)];
            }
        }
        let sum: f64 = now[1].iter().map(|irradiance| f64::from(irradiance.max_element())).sum();
        self.mean = sum / now[1].len().max(1) as f64;
        self.before = Some(now.map(<[Vec3]>::to_vec));
    }

    /// The largest excess as a share of the mean irradiance of the last frame.
    pub(super) fn largest_excess(&self) -> f64 {
        self.share(self.excess)
    }

    /// The largest changes with and without levels of detail, as shares of the same.
    pub(super) fn largest(&self) -> [f64; 2] {
        self.largest.map(|change| self.share(change))
    }

    fn share(&self, change: f32) -> f64 {
        if self.mean > 0.0 { f64::from(change) / self.mean } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_more_than_without_levels_is_found() {
        let mut steps = LightSteps::default();
        let frame = |a: f32, b: f32| vec![Vec3::splat(a), Vec3::splat(b)];
        steps.note([&frame(1.0, 3.0), &frame(1.0, 3.0)]);
        assert_eq!((steps.largest_excess(), steps.largest()), (0.0, [0.0, 0.0]));
        // The first receiver changes by one with and without levels, the second by half with them only.
        steps.note([&frame(2.0, 3.5), &frame(2.0, 2.0)]);
        assert_eq!(steps.largest(), [0.5, 0.5]);
        assert_eq!(steps.largest_excess(), 0.0);
        steps.note([&frame(2.0, 4.5), &frame(2.0, 2.0)]);
        assert_eq!(steps.largest_excess(), 0.5, "one of a mean of two");
    }
}
