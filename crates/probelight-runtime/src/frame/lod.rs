//! Levels of detail ([SED] section 5): how much of what is stored a frame computes.

use serde::{Deserialize, Serialize};

use crate::RuntimeError;

/// Levels of detail by distance. The default has one level with everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodSettings {
    /// From near to far, at least one. What is nearer than the first has the first.
    pub levels: Vec<LodLevel>,
}

/// How much a level computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodLevel {
    /// Where it begins, metres from the view: to a cluster's box, or to a probe's farthest receiver.
    pub distance: f32,
    /// Most singular values of a cluster; all without it.
    pub rank: Option<u32>,
    /// Highest spherical-harmonics band of the probes; all without it.
    pub degree: Option<u32>,
    /// Relight rays of a probe; all without it. There are prefixes of all, half, a quarter and an eighth of the rays: the
    /// shortest with as many counts.
    pub rays: Option<u32>,
    /// Level n of the lightmap: only receivers at every 2ⁿ-th texel of every 2ⁿ-th row are computed, the others keep their
    /// light. Up to 3.
    pub lightmap_level: u32,
}

impl Default for LodSettings {
    fn default() -> Self {
        Self { levels: vec![LodLevel::default()] }
    }
}

impl LodSettings {
    /// Whether these are levels.
    ///
    /// # Errors
    /// [`RuntimeError::InvalidLod`] if there are none, or their distances are not finite, negative, or do not ascend.
    pub fn check(&self) -> Result<(), RuntimeError> {
        let refuse = |reason| Err(RuntimeError::InvalidLod { reason });
        if self.levels.is_empty() {
            return refuse("there must be at least one level");
        }
        if !self.levels.iter().all(|level| level.distance.is_finite() && level.distance >= 0.0) {
            return refuse("distances must be finite and not negative");
        }
        if !self.levels.is_sorted_by(|near, far| near.distance <= far.distance) {
            return refuse("levels must be listed from near to far");
        }
        Ok(())
    }

    /// The level at a distance (metres), or one as many steps coarser, the last if there are no more.
    pub(super) fn level(&self, distance: f32, coarser: usize) -> LodLevel {
        let begun = self.levels.partition_point(|level| level.distance <= distance);
        let index = begun.saturating_sub(1) + coarser;
        self.levels.get(index).or(self.levels.last()).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(distances: &[f32]) -> LodSettings {
        let level = |distance: &f32| LodLevel { distance: *distance, ..LodLevel::default() };
        LodSettings { levels: distances.iter().map(level).collect() }
    }

    #[test]
    fn a_level_holds_from_its_distance_on() {
        let settings = levels(&[5.0, 20.0, 50.0]);
        let found = |distance, coarser| settings.level(distance, coarser).distance;
        assert_eq!([0.0, 5.0, 19.9, 20.0, 1e9].map(|d| found(d, 0)), [5.0, 5.0, 5.0, 20.0, 50.0]);
        assert_eq!([0, 1, 2, 3].map(|coarser| found(6.0, coarser)), [5.0, 20.0, 50.0, 50.0]);
    }

    #[test]
    fn what_are_no_levels_is_refused() {
        for wrong in [&[][..], &[f32::NAN], &[0.0, f32::INFINITY], &[-1.0], &[2.0, 1.0]] {
            assert!(levels(wrong).check().is_err(), "{wrong:?}");
        }
        levels(&[0.0, 1.0, 1.0]).check().unwrap();
        LodSettings::default().check().unwrap();
    }
}
