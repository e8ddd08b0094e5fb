//! Levels of detail ([SED] section 5): how much of what is stored a frame computes.

use serde::{Deserialize, Serialize};

use super::sight::Sight;
use super::zones::LodZones;
use crate::RuntimeError;

/// Levels of detail by distance and direction. The default has one level with everything; [`LodPreset`](crate::LodPreset)
/// has others. A runtime takes new settings between any two frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodSettings {
    /// From near to far, at least one. What is nearer than the first has the first.
    pub levels: Vec<LodLevel>,
    /// What is in front of the view, beside and behind it.
    pub zones: LodZones,
    /// A probe counts as nearer by this many support radii, so that near receivers that draw on a far probe get its detail:
    /// 1 as published, 0 for the probe's own distance.
    pub support_shift: f32,
}

/// How much a level computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodLevel {
    /// Where it begins in front of the view, metres: to a cluster's box, or to a probe's farthest receiver.
    pub distance: f32,
    /// Where it begins beside the view, metres; without it as far as in front.
    pub beside: Option<f32>,
    /// Where it begins behind the view, metres; without it as far as beside.
    pub behind: Option<f32>,
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
        Self { levels: vec![LodLevel::default()], zones: LodZones::default(), support_shift: 1.0 }
    }
}

impl LodLevel {
    /// Where it begins in front of the view, beside it and behind it, metres.
    pub fn distances(&self) -> [f32; 3] {
        let beside = self.beside.unwrap_or(self.distance);
        [self.distance, beside, self.behind.unwrap_or(beside)]
    }

    /// Where it begins for something that belongs to the zones with such weights.
    pub(super) fn begins(&self, weights: [f32; 3]) -> f32 {
        self.distances().iter().zip(weights).map(|(distance, weight)| distance * weight).sum()
    }
}

impl LodSettings {
    /// Whether these are levels.
    ///
    /// # Errors
    /// [`RuntimeError::InvalidLod`] if there are none, their distances are not finite, negative, or do not ascend in each
    /// zone, or the zones or the shift are none.
    pub fn check(&self) -> Result<(), RuntimeError> {
        let refuse = |reason| Err(RuntimeError::InvalidLod { reason });
        if self.levels.is_empty() {
            return refuse("there must be at least one level");
        }
        let mut distances = self.levels.iter().flat_map(LodLevel::distances);
        if !distances.all(|distance| distance.is_finite() && distance >= 0.0) {
            return refuse("distances must be finite and not negative");
        }
        let ascend = |zone: usize| self.levels.is_sorted_by_key(|level| level.distances()[zone]);
        if !(0..3).all(ascend) {
            return refuse("levels must be listed from near to far, in front, beside and behind");
        }
        if !(self.support_shift.is_finite() && self.support_shift >= 0.0) {
            return refuse("the shift by support radii must be finite and not negative");
        }
        if !self.zones.are_zones() {
            return refuse(
                "zones are divided by two cosines, that behind below that in front, and a width from 0 to 1",
            );
        }
        Ok(())
    }

    /// The level of what is seen so, or one as many steps coarser, the last if there are no more.
    pub(super) fn level(&self, sight: Sight, coarser: usize) -> LodLevel {
        let weights = self.zones.weights(sight.cosine);
        let begun = self.levels.partition_point(|level| level.begins(weights) <= sight.distance);
        let index = begun.saturating_sub(1) + coarser;
        self.levels.get(index).or(self.levels.last()).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(distances: &[f32]) -> LodSettings {
        let level = |distance: &f32| LodLevel { distance: *distance, ..LodLevel::default() };
        LodSettings { levels: distances.iter().map(level).collect(), ..LodSettings::default() }
    }

    fn ahead(distance: f32) -> Sight {
        Sight { distance, cosine: 1.0 }
    }

    #[test]
    fn a_level_holds_from_its_distance_on() {
        let settings = levels(&[5.0, 20.0, 50.0]);
        let found = |distance, coarser| settings.level(ahead(distance), coarser).distance;
        assert_eq!([0.0, 5.0, 19.9, 20.0, 1e9].map(|d| found(d, 0)), [5.0, 5.0, 5.0, 20.0, 50.0]);
        assert_eq!([0, 1, 2, 3].map(|coarser| found(6.0, coarser)), [5.0, 20.0, 50.0, 50.0]);
    }

    #[test]
    fn each_zone_has_its_own_distances() {
        let far = LodLevel { distance: 40.0, beside: Some(20.0), behind: Some(5.0), ..LodLevel::default() };
        let settings = LodSettings { levels: vec![LodLevel::default(), far], ..LodSettings::default() };
        let is_far = |distance, cosine| settings.level(Sight { distance, cosine }, 0) == far;
        let begins = |cosine| (0..100).find(|d| is_far(*d as f32, cosine)).unwrap();
        assert_eq!([1.0, 0.0, -1.0].map(begins), [40, 20, 5]);
        let between = begins(settings.zones.front);
        assert!((25..35).contains(&between), "{between}: nothing jumps where zones meet");
        // Zones that are left out have the distance of the one before.
        assert_eq!(LodLevel { behind: None, ..far }.distances(), [40.0, 20.0, 20.0]);
        assert_eq!(LodLevel { beside: None, ..far }.distances(), [40.0, 40.0, 5.0]);
    }

    #[test]
    fn what_are_no_levels_is_refused() {
        for wrong in [&[][..], &[f32::NAN], &[0.0, f32::INFINITY], &[-1.0], &[2.0, 1.0]] {
            assert!(levels(wrong).check().is_err(), "{wrong:?}");
        }
        levels(&[0.0, 1.0, 1.0]).check().unwrap();
        LodSettings::default().check().unwrap();
        let mut behind = levels(&[0.0, 1.0]);
        behind.levels[0].behind = Some(2.0);
        assert!(behind.check().is_err(), "behind the view the second level would begin before the first");
        for shift in [-1.0, f32::NAN] {
            assert!(LodSettings { support_shift: shift, ..LodSettings::default() }.check().is_err());
        }
        let zones = LodZones { front: -0.5, behind: 0.5, ..LodZones::default() };
        assert!(LodSettings { zones, ..LodSettings::default() }.check().is_err());
    }
}
