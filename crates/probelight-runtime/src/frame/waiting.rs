//! When a change is computed: what makes clusters and probes run, and which of them may wait.
//!
//! What changed a little may wait: the bound of its change since it was last computed, see
//! [`ChangeTables`](super::change_tables::ChangeTables), stays below a share of its own light. What waits for long runs
//! whatever it has changed, unless that is next to nothing. Where a frame is not allowed everything that should run, the most
//! urgent goes first.

use bytemuck::{Pod, Zeroable};
use probelight_asset::NONE;

/// Levels of urgency; four for each doubling of the change.
pub(crate) const URGENCIES: usize = 64;

/// Steps of a doubling of the change, as a power of two.
#[cfg(any(feature = "cpu", test))]
pub(crate) const URGENCY_STEP_BITS: u32 = 2;

/// Share of the largest change that may wait below which nothing is computed however long it waits. Without it, light
/// that stands still would go on to be computed for changes of last digits.
pub(crate) const NEXT_TO_NOTHING: f32 = 1.0 / 64.0;

/// What probes may leave waiting, as a share of what clusters may: what a probe misses reaches all clusters around it.
#[cfg(any(feature = "cpu", test))]
pub(crate) const PROBES_SHARE: f32 = 0.25;

/// Neighbouring probes that have their turn together: as many as the CPU multiplies at once.
#[cfg(any(feature = "cpu", test))]
pub(crate) const PROBES_A_TURN: u32 = 8;

/// Which probes may be relit in a frame, where they have turns.
#[cfg(any(feature = "cpu", test))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProbeTurn {
    /// Number of the frame.
    pub(crate) frame: u32,
    /// Frames until all had theirs, at least one.
    pub(crate) turns: u32,
}

#[cfg(any(feature = "cpu", test))]
impl ProbeTurn {
    /// Whether it is the turn of a probe.
    pub(crate) fn is_of(self, probe: u32) -> bool {
        (probe / PROBES_A_TURN + self.frame % self.turns).is_multiple_of(self.turns)
    }
}

/// What waits of a cluster or a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Waiting {
    /// Bound of what its light changed since it was last computed.
    pub(crate) change: f32,
    /// Its light when it was last computed.
    pub(crate) light: f32,
    /// Frames since then.
    pub(crate) frames: u32,
    /// How urgent it is in the present frame, or no such index.
    pub(crate) urgency: u32,
}

impl Waiting {
    /// Whether its light is not that of the last frame, or not what is wanted of it, given the share of it that may wait.
    pub(crate) fn is_pending(&self, threshold: f32) -> bool {
        let was_refused = self.frames > 0 && self.urgency != NONE;
        was_refused || self.change > NEXT_TO_NOTHING * threshold * self.light
    }
}

/// How urgent something is: the higher the sooner; [`NONE`] for what may wait.
///
/// `is_new` says that something else is wanted than what was last computed; a `threshold` of zero lets nothing wait.
#[cfg(any(feature = "cpu", test))]
pub(crate) fn urgency(waiting: &Waiting, is_new: bool, threshold: f32, longest_wait: u32) -> u32 {
    let most = URGENCIES as u32 - 1;
    let allowed = threshold * waiting.light;
    let is_overdue = waiting.frames >= longest_wait && waiting.change > NEXT_TO_NOTHING * allowed;
    if is_new || threshold == 0.0 || is_overdue {
        return most;
    }
    if waiting.change <= allowed {
        return NONE;
    }
    // The exponent and the first bits of the mantissa: the logarithm in steps.
    let ratio = (waiting.change / allowed).min(f32::MAX);
    let steps = (ratio.to_bits() >> (23 - URGENCY_STEP_BITS)) - (127 << URGENCY_STEP_BITS);
    steps.min(most - 1)
}

/// Which of what is urgent runs in a frame.
#[cfg(any(feature = "cpu", test))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Admission {
    /// All of a higher urgency run.
    pub(crate) cutoff: u32,
    /// Of this urgency, so many words of work.
    pub(crate) words_left: u32,
    /// Of so many.
    pub(crate) words_there: u32,
}

#[cfg(any(feature = "cpu", test))]
impl Admission {
    /// For a frame that has so many words of work of each urgency, and may do `most` of it.
    pub(crate) fn new(words: &[u32; URGENCIES], most: u32) -> Self {
        let mut left = most;
        for cutoff in (0..URGENCIES).rev() {
            let there = words[cutoff];
            if there > left {
                return Self { cutoff: cutoff as u32, words_left: left, words_there: there };
            }
            left -= there;
        }
        Self { cutoff: 0, words_left: 1, words_there: 1 }
    }

    /// Whether something of such an urgency runs. Where only a part of an urgency does, chance decides, anew in each
    /// frame, so that nothing is always left out.
    pub(crate) fn admits(&self, urgency: u32, index: u32, frames: u32) -> bool {
        urgency > self.cutoff
            || (urgency == self.cutoff && scatter(index, frames) % self.words_there < self.words_left)
    }
}

/// A number that looks random, from two.
#[cfg(any(feature = "cpu", test))]
fn scatter(index: u32, frames: u32) -> u32 {
    let mixed =
        (index.wrapping_mul(0x9e37_79b9) ^ frames.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
    mixed ^ (mixed >> 15)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(change: f32) -> Waiting {
        Waiting { change, light: 2.0, frames: 3, urgency: NONE }
    }

    #[test]
    fn small_changes_wait_and_large_ones_do_not() {
        let found = |change| urgency(&after(change), false, 0.01, 100);
        assert_eq!([0.0, 0.01, 0.02].map(found), [NONE; 3]);
        assert_eq!([0.021, 0.026, 0.041, 0.08].map(found), [0, 1, 4, 8]);
        assert_eq!(found(f32::MAX), 62);
        let dark = Waiting { light: 0.0, ..after(1e-9) };
        assert_eq!(urgency(&dark, false, 0.01, 100), 62, "darkness has no change that may wait");
        assert_eq!(urgency(&Waiting { change: 0.0, ..dark }, false, 0.01, 100), NONE);
    }

    #[test]
    fn what_changed_by_more_than_next_to_nothing_is_pending() {
        let found = [0.0, 1e-4, 4e-4, 0.1].map(|change| after(change).is_pending(0.01));
        assert_eq!(found, [false, false, true, true]);
        let refused = Waiting { urgency: 63, ..after(0.0) };
        assert!(refused.is_pending(0.01) && !Waiting { frames: 0, ..refused }.is_pending(0.01));
    }

    #[test]
    fn each_probe_has_one_turn_in_so_many_frames() {
        let turns_of =
            |probe| (3..11).filter(|frame| ProbeTurn { frame: *frame, turns: 8 }.is_of(probe)).count();
        assert!((0..100).all(|probe| turns_of(probe) == 1));
        let at_once = (0..64).filter(|probe| ProbeTurn { frame: 5, turns: 8 }.is_of(*probe)).count();
        assert_eq!(at_once, 8, "an even share");
        assert!((0..100).all(|probe| ProbeTurn { frame: probe * 7, turns: 1 }.is_of(probe)));
    }

    #[test]
    fn what_waited_long_or_is_wanted_otherwise_runs() {
        let late = Waiting { frames: 100, ..after(0.002) };
        assert_eq!(urgency(&late, false, 0.01, 100), 63);
        assert_eq!(urgency(&Waiting { change: 0.0001, ..late }, false, 0.01, 100), NONE, "next to nothing");
        assert_eq!(urgency(&after(0.0), true, 0.01, 100), 63);
        assert_eq!(urgency(&after(0.0), false, 0.0, 100), 63, "a threshold of zero computes everything");
    }

    #[test]
    fn the_most_urgent_go_first() {
        let mut words = [0; URGENCIES];
        (words[63], words[8], words[2]) = (10, 20, 100);
        let admitted = |most| {
            let admission = Admission::new(&words, most);
            [63, 8, 2].map(|urgency| (0..1000).filter(|i| admission.admits(urgency, *i, 7)).count())
        };
        assert_eq!(admitted(u32::MAX), [1000, 1000, 1000]);
        assert_eq!(admitted(30), [1000, 1000, 0]);
        assert_eq!(admitted(0), [0, 0, 0]);
        let [all, all_too, some] = admitted(80);
        assert!(all == 1000 && all_too == 1000 && (400..600).contains(&some), "{some}");
        // Another frame, others.
        let half = Admission::new(&words, 80);
        assert!((0..100).any(|i| half.admits(2, i, 7) != half.admits(2, i, 8)));
    }
}
