//! Shadow rays of light samples in turns, so that a frame traces but a share of them.

use crate::cpu::SampleTurn;

/// How many turns are left until all samples know the present lights and objects.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShadowTurns {
    lights: u32,
    objects: u32,
    turn: usize,
    /// Whether some frame had all samples at once since the last that was asked to.
    has_begun: bool,
}

/// What the samples whose turn it is need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShadowWork {
    /// Rays against what stands still.
    pub(crate) lights: bool,
    /// Rays against objects.
    pub(crate) objects: bool,
}

impl ShadowTurns {
    /// Makes the next frame leave nothing to later turns.
    pub(crate) fn all_at_once(&mut self) {
        self.has_begun = false;
    }

    /// The samples of a frame in which lights or objects may have moved, and what they need.
    pub(crate) fn next(
        &mut self,
        turns: u32,
        lights_moved: bool,
        objects_moved: bool,
    ) -> (SampleTurn, ShadowWork) {
        let turns = if std::mem::replace(&mut self.has_begun, true) { turns } else { 1 };
        if lights_moved {
            self.lights = turns;
        }
        if objects_moved {
            self.objects = turns;
        }
        let work = ShadowWork { lights: self.lights > 0, objects: self.objects > 0 };
        if turns == 1 {
            (self.lights, self.objects) = (0, 0);
            return (SampleTurn::ALL, work);
        }
        (self.lights, self.objects) = (self.lights.saturating_sub(1), self.objects.saturating_sub(1));
        self.turn = (self.turn + 1) % turns as usize;
        (SampleTurn { turn: self.turn, turns: turns as usize }, work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTHING: ShadowWork = ShadowWork { lights: false, objects: false };
    const LIGHTS: ShadowWork = ShadowWork { lights: true, objects: false };

    #[test]
    fn all_samples_have_a_turn_after_the_last_change() {
        let mut turns = ShadowTurns::default();
        assert_eq!(
            turns.next(4, true, false),
            (SampleTurn::ALL, LIGHTS),
            "the first frame knows nothing yet"
        );
        assert_eq!(turns.next(4, false, false).1, NOTHING);
        let mut seen = vec![turns.next(4, true, false)];
        seen.extend((0..6).map(|_| turns.next(4, false, false)));
        let mut traced: Vec<usize> =
            seen.iter().filter(|(_, work)| *work == LIGHTS).map(|(turn, _)| turn.turn).collect();
        traced.sort_unstable();
        assert_eq!(traced, [0, 1, 2, 3]);
    }

    #[test]
    fn what_is_left_is_made_up_for_when_asked_to() {
        let mut turns = ShadowTurns::default();
        turns.next(4, true, true);
        turns.next(4, true, false);
        turns.all_at_once();
        assert_eq!(turns.next(4, false, false), (SampleTurn::ALL, LIGHTS));
        assert_eq!(turns.next(4, false, false).1, NOTHING);
        // With one turn there is nothing left ever.
        assert_eq!(turns.next(1, true, false), (SampleTurn::ALL, LIGHTS));
        assert_eq!(turns.next(1, false, false).1, NOTHING);
    }
}
