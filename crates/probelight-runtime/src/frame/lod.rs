//! Levels of detail ([SED] section 5): how much of what is stored a frame computes.

use probelight_asset::BakedScene;
use serde::{Deserialize, Serialize};

use super::plan::FADE_STEPS;
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
    /// Share of a level's distance over which, before it begins, the singular values fade out that it does not have. Without
    /// it they would pop.
    pub fade: f32,
    /// Frames in which the rays of a light have their turns when it or an object moves; with 1, all have theirs at once. GPUs
    /// look into shadow maps instead, all at once.
    pub shadow_turns: u32,
    /// Frames in which probes have their turns to be relit, an even share of them in each; with 1, all have theirs at once.
    /// Counts where something may wait.
    pub probe_turns: u32,
    /// Which changes of light are computed, and when.
    pub changes: LodChanges,
}

/// Which changes of light are computed, and when.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodChanges {
    /// The largest change of a cluster's light that may wait, as a share of its irradiance: clusters whose signals changed
    /// by less are not computed. With 0, the default, everything is computed in each frame, changed or not.
    pub threshold: f32,
    /// Frames after which even a smaller change is computed.
    pub longest_wait: u32,
    /// About which share of all transport matrices a frame may read, 0 to 1; the largest changes go first. Without it, all.
    pub matrix_share: Option<f32>,
}

impl Default for LodChanges {
    fn default() -> Self {
        Self { threshold: 0.0, longest_wait: 64, matrix_share: None }
    }
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
    /// Level n of the lightmap: only receivers at every 2ⁿ-th texel of every 2ⁿ-th row are computed, the others get their
    /// light from these. Up to 3.
    pub lightmap_level: u32,
    /// The largest change that may wait there; that of [`LodChanges`] without it.
    pub threshold: Option<f32>,
}

impl Default for LodSettings {
    fn default() -> Self {
        Self {
            levels: vec![LodLevel::default()],
            zones: LodZones::default(),
            support_shift: 1.0,
            fade: 0.25,
            shadow_turns: 1,
            probe_turns: 1,
            changes: LodChanges::default(),
        }
    }
}

impl LodChanges {
    /// Most words of a scene's matrices that a frame may read, or any number if it is forced to.
    pub(crate) fn most_words(&self, baked: &BakedScene, is_forced: bool) -> u32 {
        let all = baked.receiver_basis.len() + baked.signal_basis.len();
        let share = self.matrix_share.filter(|_| !is_forced);
        // Numbers that are too large become the largest.
        share.map_or(u32::MAX, |share| (f64::from(share) * all as f64) as u32)
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
        if self.shadow_turns == 0 || self.probe_turns == 0 {
            return refuse("rays of lights, and probes, have their turns in at least one frame");
        }
        if self.changes.matrix_share.is_some_and(|share| !(0.0..=1.0).contains(&share)) {
            return refuse("a frame reads a share of the matrices, 0 to 1");
        }
        if !(0.0..=1.0).contains(&self.fade) {
            return refuse("fading takes a share of a level's distance, 0 to 1");
        }
        let mut thresholds = self.levels.iter().map(|level| self.threshold(level));
        if !thresholds.all(|threshold| threshold.is_finite() && threshold >= 0.0) {
            return refuse("thresholds must be finite and not negative");
        }
        if !self.zones.are_zones() {
            return refuse(
                "zones are divided by two cosines, that behind below that in front, and a width from 0 to 1",
            );
        }
        Ok(())
    }

    /// Whether what did not change may rest; else everything is computed in each frame.
    pub(crate) fn lets_wait(&self) -> bool {
        self.changes.threshold > 0.0 || self.changes.matrix_share.is_some()
    }

    /// The coarsest level of the lightmap that any level has.
    pub(crate) fn coarsest_lightmap(&self) -> u32 {
        self.levels.iter().map(|level| level.lightmap_level).max().unwrap_or(0)
    }

    /// The largest change that may wait at a level.
    pub(super) fn threshold(&self, level: &LodLevel) -> f32 {
        level.threshold.unwrap_or(self.changes.threshold)
    }

    /// The same levels at so many times the distance.
    #[must_use]
    pub fn with_distances_scaled(mut self, scale: f32) -> Self {
        for level in &mut self.levels {
            let scaled = |distance: f32| distance * scale;
            (level.distance, level.beside) = (scaled(level.distance), level.beside.map(scaled));
            level.behind = level.behind.map(scaled);
        }
        self
    }

    /// How much those singular values count of what is seen so that the next level does not have, in parts of
    /// [`FADE_STEPS`], and how many that level has.
    pub(super) fn fade(&self, sight: Sight) -> (u32, u32) {
        let weights = self.zones.weights(sight.cosine);
        let next = self.levels.iter().skip(1).find(|level| level.begins(weights) > sight.distance);
        let Some(next) = next else { return (FADE_STEPS, u32::MAX) };
        let begins = next.begins(weights);
        let left = (begins - sight.distance) / (self.fade * begins).max(f32::MIN_POSITIVE);
        ((left.min(1.0) * FADE_STEPS as f32).ceil() as u32, next.rank.unwrap_or(u32::MAX))
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
    fn what_the_next_level_lacks_fades_out_before_it_begins() {
        let far = LodLevel { distance: 40.0, rank: Some(7), ..LodLevel::default() };
        let settings = LodSettings { levels: vec![LodLevel::default(), far], ..LodSettings::default() };
        let fade = |distance| settings.fade(ahead(distance));
        assert_eq!(
            [0.0, 30.0, 35.0, 39.9, 40.0].map(fade),
            [(16, 7), (16, 7), (8, 7), (1, 7), (16, u32::MAX)]
        );
        let sharp = LodSettings { fade: 0.0, ..settings.clone() };
        assert_eq!(sharp.fade(ahead(39.9)), (16, 7));
        assert!(LodSettings { fade: 1.5, ..settings.clone() }.check().is_err());
        assert_eq!(settings.with_distances_scaled(0.5).fade(ahead(17.5)), (8, 7));
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
        for threshold in [-0.1, f32::NAN] {
            let changes = LodChanges { threshold, ..LodChanges::default() };
            assert!(LodSettings { changes, ..LodSettings::default() }.check().is_err());
        }
        let zones = LodZones { front: -0.5, behind: 0.5, ..LodZones::default() };
        assert!(LodSettings { zones, ..LodSettings::default() }.check().is_err());
    }
}
